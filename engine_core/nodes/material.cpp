#include "nodes/material.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "nodes/material_code.h"
#include "textures/image.h"

namespace vernier {
namespace {

// Registers that fit on the stack; the rare program that needs more has them per thread.
constexpr uint32_t kStackRegisters = 64;

// Runs the program of a part, if it has one, and hands its values to `use`.
template <typename Use>
auto with_values(const ProgramPart& part, const ProgramData& data, const SurfacePoint& point,
                 Use use) {
  const Program& program = part.program;
  if (program.code.empty()) {
    return use(ProgramResult{nullptr, program.constants.data()});
  }
  if (program.register_count <= kStackRegisters) {
    alignas(Vec4f) std::byte storage[kStackRegisters * sizeof(Vec4f)];
    auto* registers = reinterpret_cast<Vec4f*>(storage);
    run(program, data, point, registers);
    return use(ProgramResult{registers, program.constants.data()});
  }
  // Materials do not evaluate one another, so one store per thread is enough.
  static thread_local std::vector<Vec4f> store;
  if (store.size() < program.register_count) {
    store.resize(program.register_count);
  }
  run(program, data, point, store.data());
  return use(ProgramResult{store.data(), program.constants.data()});
}

}  // namespace

NodeContext::NodeContext(std::span<const std::shared_ptr<const ImageTexture>> images,
                         std::vector<std::string>& attribute_names,
                         std::vector<std::string>& warnings)
    : images_(images), attribute_names_(attribute_names), warnings_(warnings) {
  for (size_t i = 0; i < attribute_names.size(); ++i) {
    attribute_ids_.emplace(attribute_names[i], static_cast<uint32_t>(i));
  }
}

uint32_t NodeContext::attribute_id(std::string_view name) {
  const auto next = static_cast<uint32_t>(attribute_names_.size());
  const auto [entry, is_new] = attribute_ids_.try_emplace(std::string(name), next);
  if (is_new) {
    attribute_names_.emplace_back(name);
  }
  return entry->second;
}

const ImageTexture* NodeContext::image(int64_t index) const {
  return index < 0 || index >= static_cast<int64_t>(images_.size())
             ? nullptr
             : images_[static_cast<size_t>(index)].get();
}

void NodeContext::warn(std::string message) {
  if (warning_ids_.try_emplace(message, 0).second) {
    warnings_.push_back(std::move(message));
  }
}

Material::Material(std::string name, std::unique_ptr<const MaterialCode> code,
                   MaterialTraits traits)
    : name_(std::move(name)), code_(std::move(code)), traits_(std::move(traits)) {
  if (traits_.is_constant && !traits_.is_emissive) {
    prepare();
  }
}

Material::~Material() = default;

void Material::prepare() {
  const auto& closures = code_->surface.list.closures;
  if (std::any_of(closures.begin(), closures.end(),
                  [](const ClosureCode& c) { return c.normal != kNoOperand; })) {
    return;
  }
  for (const bool backfacing : {false, true}) {
    SurfacePoint point;
    point.ng = point.ns = point.wo = {0, 0, 1};
    point.backfacing = backfacing;
    auto bsdf = std::make_unique<Bsdf>();
    bsdf->begin(point);
    evaluate(point, *bsdf);
    prepared_[backfacing ? 1 : 0] = std::move(bsdf);
  }
}

void Material::evaluate(const SurfacePoint& point, Bsdf& bsdf) const {
  if (const Bsdf* prepared = prepared_[point.backfacing ? 1 : 0].get()) {
    bsdf.reuse(*prepared);
    return;
  }
  const ProgramPart& part = code_->surface;
  with_values(part, code_->data, point, [&](const ProgramResult& values) {
    for (const ClosureCode& closure : part.list.closures) {
      add_closure(part.list, closure, values, point, bsdf);
    }
  });
}

Color Material::emission(const SurfacePoint& point) const {
  if (traits_.emission_constant) {
    return traits_.average_emission;
  }
  const ProgramPart& part = code_->emission;
  return with_values(part, code_->data, point, [&](const ProgramResult& values) {
    Color sum;
    for (const ClosureCode& closure : part.list.closures) {
      sum += closure_emission(part.list, closure, values, point);
    }
    return sum;
  });
}

Color Material::transparency(const SurfacePoint& point) const {
  const ProgramPart& part = code_->transparency;
  return with_values(part, code_->data, point, [&](const ProgramResult& values) {
    Color sum;
    for (const ClosureCode& closure : part.list.closures) {
      sum += closure_transparency(part.list, closure, values);
    }
    return sum;
  });
}

size_t Material::program_length() const { return code_->surface.program.code.size(); }
size_t Material::register_count() const { return code_->surface.program.register_count; }

}  // namespace vernier
