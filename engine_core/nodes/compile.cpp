// compile_material: validation, lowering, linking of the three programs, and what can be said of
// the material in advance.
#include <algorithm>
#include <cmath>

#include "nodes/graph.h"
#include "nodes/image_ops.h"
#include "nodes/lowering.h"
#include "nodes/material_code.h"

namespace vernier {
namespace {

// Directions over which emission that varies is averaged.
constexpr int kAverageDirections = 64;

class Compiler {
 public:
  Compiler(const ProgramBuilder& builder, const std::vector<PendingClosure>& closures)
      : builder_(builder), closures_(closures) {}

  // The program for the closures that `wanted` accepts.
  template <typename Predicate>
  ProgramPart part(Predicate wanted) const {
    ProgramPart part;
    std::vector<Value> roots;
    for (const PendingClosure& pending : closures_) {
      if (!wanted(pending)) {
        continue;
      }
      ClosureCode code = pending.code;
      code.parameters = static_cast<uint32_t>(roots.size());
      roots.insert(roots.end(), pending.parameters.begin(), pending.parameters.end());
      // Until the program is linked these two hold positions among the roots.
      code.weight = static_cast<Operand>(roots.size());
      roots.push_back(pending.weight);
      code.normal = static_cast<Operand>(roots.size());
      roots.push_back(pending.normal);
      part.list.closures.push_back(code);
    }
    part.program = builder_.link(roots, part.list.operands);
    for (ClosureCode& code : part.list.closures) {
      code.weight = part.list.operands[code.weight];
      code.normal = part.list.operands[code.normal];
    }
    return part;
  }

  bool emits(const PendingClosure& c) const {
    if (c.code.kind == ClosureKind::kEmission) {
      return !is_black(c, emission::kColor) && !is_zero(c, emission::kStrength);
    }
    return c.code.kind == ClosureKind::kPrincipled && !is_black(c, principled::kEmissionColor) &&
           !is_zero(c, principled::kEmissionStrength);
  }
  bool transmits(const PendingClosure& c) const {
    if (c.code.kind == ClosureKind::kTransparent) {
      return !is_black(c, 0);
    }
    return c.code.kind == ClosureKind::kPrincipled &&
           !(is_constant(c, principled::kAlpha) && scalar(c, principled::kAlpha) >= 1.0f);
  }
  // Whether what a closure emits is dimmed by layers above.
  bool covered(const PendingClosure& c) const {
    return c.code.kind == ClosureKind::kPrincipled &&
           !(is_zero(c, principled::kCoat) && is_zero(c, principled::kSheen));
  }
  uint8_t lobes(const PendingClosure& c) const;

 private:
  bool is_constant(const PendingClosure& c, size_t parameter) const {
    return builder_.is_constant(c.parameters[parameter]);
  }
  float scalar(const PendingClosure& c, size_t parameter) const {
    return builder_.constant_value(c.parameters[parameter]).x;
  }
  bool is_zero(const PendingClosure& c, size_t parameter) const {
    return is_constant(c, parameter) && scalar(c, parameter) == 0.0f;
  }
  bool is_black(const PendingClosure& c, size_t parameter) const {
    return is_constant(c, parameter) &&
           vernier::is_black(builder_.constant_value(c.parameters[parameter]).xyz());
  }
  // Bits of a microfacet lobe: smooth ones are delta distributions (Cycles'
  // BSDF_ROUGHNESS_SQ_THRESH on the product of the two alphas, each a squared roughness).
  uint8_t glossy(const PendingClosure& c, size_t roughness) const {
    constexpr float kSmooth = 5e-7f;
    const bool varies = !is_constant(c, roughness);
    const bool smooth = !varies && square(square(saturate(scalar(c, roughness)))) <= kSmooth;
    const unsigned singular = varies || smooth ? unsigned{kLobeSingular} : 0u;
    return static_cast<uint8_t>(kLobeGlossy | singular);
  }

  const ProgramBuilder& builder_;
  const std::vector<PendingClosure>& closures_;
};

uint8_t Compiler::lobes(const PendingClosure& c) const {
  unsigned bits = 0;
  switch (c.code.kind) {
    case ClosureKind::kDiffuse:
    case ClosureKind::kSheen:
    case ClosureKind::kVelvet:
    case ClosureKind::kSubsurface:
      return kLobeDiffuse | kLobeReflection;
    case ClosureKind::kToon:
      return static_cast<uint8_t>(c.code.option ? kLobeGlossy | kLobeReflection
                                                : kLobeDiffuse | kLobeReflection);
    case ClosureKind::kTranslucent:
      return kLobeDiffuse | kLobeTransmission;
    case ClosureKind::kTransparent:
      return kLobeTransparent | kLobeSingular | kLobeTransmission;
    case ClosureKind::kGlossy:
      bits = glossy(c, glossy::kRoughness) | kLobeReflection;
      break;
    case ClosureKind::kMetallic:
      bits = glossy(c, metallic::kRoughness) | kLobeReflection;
      break;
    case ClosureKind::kGlass:
      bits = glossy(c, glass::kRoughness) | kLobeReflection | kLobeTransmission;
      break;
    case ClosureKind::kRefraction:
      bits = glossy(c, glass::kRoughness) | kLobeTransmission;
      break;
    case ClosureKind::kPrincipled: {
      const auto full = [&](size_t parameter) {
        return is_constant(c, parameter) && scalar(c, parameter) >= 1.0f;
      };
      bits = glossy(c, principled::kRoughness) | kLobeReflection;
      if (!full(principled::kMetallic) && !full(principled::kTransmission)) {
        bits |= kLobeDiffuse;
      }
      if (!full(principled::kMetallic) && !is_zero(c, principled::kTransmission)) {
        bits |= kLobeTransmission;
      }
      if (!is_zero(c, principled::kCoat)) {
        bits |= glossy(c, principled::kCoatRoughness);
      }
      if (!is_zero(c, principled::kSheen)) {
        bits |= kLobeDiffuse;
      }
      if (!is_zero(c, principled::kThinWall)) {
        bits |= kLobeTransmission;
      }
      if (transmits(c)) {
        bits |= kLobeTransparent | kLobeSingular | kLobeTransmission;
      }
      break;
    }
    case ClosureKind::kEmission:
    case ClosureKind::kHoldout:
      break;
  }
  return static_cast<uint8_t>(bits);
}

bool reads_image(const Instruction& instruction) {
  return instruction.op == Op::kImage || instruction.op == Op::kImageBox ||
         instruction.op == Op::kEnvironment;
}

// Runs an emission program with every image replaced by its average, over directions spread evenly
// on the sphere (a Fibonacci lattice) for what depends on them.
Color average_emission(const ProgramPart& part, const ProgramData& data) {
  std::vector<Vec4f> registers(part.program.register_count);
  std::vector<Vec4f> image_averages;
  for (const ImageTexture* image : data.images) {
    const Color c = image == nullptr ? Color{1, 0, 1} : image->average();
    image_averages.push_back(to_register(c));
  }
  Color sum;
  for (int i = 0; i < kAverageDirections; ++i) {
    SurfacePoint point;
    const float z = 1.0f - (2.0f * static_cast<float>(i) + 1.0f) / kAverageDirections;
    const float phi = static_cast<float>(i) * 2.39996323f;  // the golden angle
    const float r = safe_sqrt(1.0f - z * z);
    point.wo = {r * std::cos(phi), r * std::sin(phi), z};
    point.ns = point.ng = point.wo;
    for (const Instruction& instruction : part.program.code) {
      const Arguments arguments(registers.data(), part.program.constants.data(),
                                part.program.operands.data() + instruction.operands);
      registers[instruction.result] = reads_image(instruction)
                                          ? image_averages[instruction.data]
                                          : execute(instruction, arguments, data, point, 0.0f);
    }
    const ProgramResult values{registers.data(), part.program.constants.data()};
    Color emitted;
    for (const ClosureCode& closure : part.list.closures) {
      emitted += closure_emission(part.list, closure, values, point);
    }
    sum += is_finite(emitted) ? emitted : Color{};
  }
  return sum * (1.0f / kAverageDirections);
}

std::vector<uint32_t> attributes_read(const Program& program) {
  std::vector<uint32_t> ids;
  for (const Instruction& instruction : program.code) {
    const bool tangent_space = instruction.op == Op::kNormalMap && instruction.variant == 0;
    const bool uv_tangent = instruction.op == Op::kTangent && instruction.variant == 3;
    if (instruction.op == Op::kAttribute || tangent_space || uv_tangent) {
      ids.push_back(instruction.data);
    }
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

int widest_image(const Program& program, const ProgramData& data) {
  int width = 0;
  for (const Instruction& instruction : program.code) {
    const ImageTexture* image = reads_image(instruction) ? data.images[instruction.data] : nullptr;
    width = std::max(width, image == nullptr ? 0 : image->width());
  }
  return width;
}

}  // namespace

std::unique_ptr<Material> compile_material(const GraphDesc& desc, std::string_view name,
                                           NodeContext& context) {
  const Graph graph(desc, name);
  GraphLowering lowering(graph, name, context);
  lowering.run();
  ProgramBuilder& builder = lowering.builder();
  const std::vector<PendingClosure>& closures = lowering.closures();
  const Compiler compiler(builder, closures);

  auto code = std::make_unique<MaterialCode>();
  code->surface = compiler.part([](const PendingClosure&) { return true; });
  code->emission = compiler.part([&](const PendingClosure& c) { return compiler.emits(c); });
  code->transparency =
      compiler.part([&](const PendingClosure& c) { return compiler.transmits(c); });

  MaterialTraits traits;
  traits.is_constant = code->surface.program.code.empty();
  traits.is_emissive = !code->emission.list.closures.empty();
  traits.maybe_transparent = !code->transparency.list.closures.empty();
  const auto reads = [](const ProgramPart& part, bool OpTraits::* trait) {
    return ProgramBuilder::any(part.program, trait);
  };
  traits.side_dependent = reads(code->surface, &OpTraits::side_dependent);
  traits.direction_dependent = reads(code->surface, &OpTraits::direction_dependent);
  traits.path_dependent = reads(code->surface, &OpTraits::path_dependent);
  traits.emission_view_dependent = reads(code->emission, &OpTraits::side_dependent) ||
                                   reads(code->emission, &OpTraits::direction_dependent) ||
                                   reads(code->emission, &OpTraits::path_dependent);
  for (const PendingClosure& closure : closures) {
    traits.lobes |= compiler.lobes(closure);
    traits.uses_bump = traits.uses_bump || closure.normal.exists();
    if (compiler.emits(closure) && compiler.covered(closure)) {
      traits.emission_view_dependent = true;
    }
  }
  traits.attributes = attributes_read(code->surface.program);
  traits.emission_constant = code->emission.program.code.empty() && !traits.emission_view_dependent;
  code->data = builder.take_data();
  if (traits.is_emissive) {
    traits.average_emission = average_emission(code->emission, code->data);
    traits.emission_image_width = widest_image(code->emission.program, code->data);
  }
  return std::make_unique<Material>(std::string(name), std::move(code), std::move(traits));
}

}  // namespace vernier
