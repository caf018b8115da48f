#include "nodes/builder.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "nodes/math_ops.h"

namespace vernier {
namespace {

// Leads the keys of constants; instructions' keys start with their operation.
constexpr uint32_t kConstantKey = 0xffffffffu;

}  // namespace

// FNV-1a over the words.
size_t ProgramBuilder::KeyHash::operator()(const std::vector<uint32_t>& key) const {
  uint64_t hash = 0xcbf29ce484222325u;
  for (const uint32_t word : key) {
    hash = (hash ^ word) * 0x100000001b3u;
  }
  return static_cast<size_t>(hash ^ (hash >> 32));
}

Value ProgramBuilder::constant(Vec4f value, SocketType type) {
  std::vector<uint32_t> key{kConstantKey, std::bit_cast<uint32_t>(value.x),
                            std::bit_cast<uint32_t>(value.y), std::bit_cast<uint32_t>(value.z),
                            std::bit_cast<uint32_t>(value.w)};
  const auto next = static_cast<uint32_t>(definitions_.size());
  const auto [entry, is_new] = known_.try_emplace(std::move(key), next);
  if (is_new) {
    Definition definition;
    definition.is_constant = true;
    definition.value = value;
    definitions_.push_back(definition);
  }
  return {entry->second, type};
}

Value ProgramBuilder::emit(Op op, uint8_t variant, SocketType type,
                           std::initializer_list<Value> operands, uint32_t data,
                           EvaluationPoint point) {
  const OpTraits traits = op_traits(op, variant);
  // What reads nothing of the point is the same at every point.
  if (!traits.reads_point) {
    point = EvaluationPoint::kMain;
  }
  std::vector<uint32_t> key{static_cast<uint32_t>(op),
                            static_cast<uint32_t>(variant) | static_cast<uint32_t>(point) << 8,
                            data};
  bool foldable = !traits.reads_point;
  for (const Value& operand : operands) {
    key.push_back(operand.id);
    foldable = foldable && is_constant(operand);
  }
  if (const auto entry = known_.find(key); entry != known_.end()) {
    return {entry->second, type};
  }

  Instruction instruction;
  instruction.op = op;
  instruction.variant = variant;
  instruction.point = point;
  instruction.operand_count = static_cast<uint8_t>(operands.size());
  instruction.data = data;
  if (foldable) {
    std::vector<Vec4f> values;
    std::vector<Operand> indices;
    for (const Value& operand : operands) {
      indices.push_back(kConstantBit | static_cast<uint32_t>(values.size()));
      values.push_back(constant_value(operand));
    }
    const Arguments arguments(nullptr, values.data(), indices.data());
    const Value folded =
        constant(execute(instruction, arguments, data_, SurfacePoint{}, 0.0f), type);
    known_.emplace(std::move(key), folded.id);
    return folded;
  }

  const auto id = static_cast<uint32_t>(definitions_.size());
  instruction.result = id;
  instruction.operands = static_cast<uint32_t>(operand_ids_.size());
  for (const Value& operand : operands) {
    operand_ids_.push_back(operand.id);
  }
  Definition definition;
  definition.instruction = instruction;
  definitions_.push_back(definition);
  known_.emplace(std::move(key), id);
  return {id, type};
}

Value ProgramBuilder::convert(Value value, SocketType type) {
  if (value.type == type || type == SocketType::kShader || value.type == SocketType::kShader) {
    return value;
  }
  if (type == SocketType::kFloat) {
    const Op op = value.type == SocketType::kColor ? Op::kLuminance : Op::kAverage;
    return emit(op, 0, type, {value});
  }
  if (value.type == SocketType::kFloat) {
    return emit(Op::kSplat, 0, type, {value});
  }
  return {value.id, type};
}

Value ProgramBuilder::add(Value a, Value b) {
  if (is_constant(a, 0.0f)) {
    return b;
  }
  return is_constant(b, 0.0f) ? a : emit(Op::kMath, MathOp::kAdd, SocketType::kFloat, {a, b});
}

Value ProgramBuilder::multiply(Value a, Value b) {
  if (is_constant(a, 1.0f) || is_constant(b, 0.0f)) {
    return b;
  }
  if (is_constant(b, 1.0f) || is_constant(a, 0.0f)) {
    return a;
  }
  return emit(Op::kMath, MathOp::kMultiply, SocketType::kFloat, {a, b});
}

Value ProgramBuilder::one_minus(Value a) {
  return emit(Op::kMath, MathOp::kSubtract, SocketType::kFloat, {constant(1.0f), a});
}

bool ProgramBuilder::is_constant(Value value) const {
  return value.exists() && definitions_[value.id].is_constant;
}

Vec4f ProgramBuilder::constant_value(Value value) const { return definitions_[value.id].value; }

bool ProgramBuilder::is_constant(Value value, float scalar) const {
  return is_constant(value) && constant_value(value).x == scalar;
}

uint32_t ProgramBuilder::add_floats(std::span<const float> floats) {
  std::vector<uint32_t> key(floats.size());
  std::transform(floats.begin(), floats.end(), key.begin(),
                 [](float f) { return std::bit_cast<uint32_t>(f); });
  const auto next = static_cast<uint32_t>(data_.floats.size());
  const auto [entry, is_new] = known_floats_.try_emplace(std::move(key), next);
  if (is_new) {
    data_.floats.insert(data_.floats.end(), floats.begin(), floats.end());
  }
  return entry->second;
}

void ProgramBuilder::add_bump_filter(float filter) {
  bump_filter_ = std::min(bump_filter_, std::max(filter, 0.0f));
}

uint32_t ProgramBuilder::add_sky(const PreethamSky& sky) {
  data_.skies.push_back(sky);
  return static_cast<uint32_t>(data_.skies.size() - 1);
}

uint32_t ProgramBuilder::add_image(const ImageTexture* image) {
  data_.images.push_back(image);
  return static_cast<uint32_t>(data_.images.size() - 1);
}

}  // namespace vernier
