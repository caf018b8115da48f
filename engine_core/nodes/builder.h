// Building of programs in single-assignment form, where every operation folds when it can.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <span>
#include <unordered_map>
#include <vector>

#include "nodes/node_kinds.h"
#include "nodes/program.h"

namespace vernier {

// A value of the program under construction: a constant or an instruction's result.
struct Value {
  uint32_t id = 0xffffffffu;
  SocketType type = SocketType::kFloat;

  bool exists() const { return id != 0xffffffffu; }
};

class ProgramBuilder {
 public:
  Value constant(Vec4f value, SocketType type);
  Value constant(float value) { return constant(to_register(value), SocketType::kFloat); }

  // Emits an instruction. Where all operands are constants and the operation reads nothing of the
  // surface point, it is executed now; where an equal one exists, that one's value is returned.
  Value emit(Op op, uint8_t variant, SocketType type, std::initializer_list<Value> operands,
             uint32_t data = 0, EvaluationPoint point = EvaluationPoint::kMain);
  template <typename Variant>
  Value emit(Op op, Variant variant, SocketType type, std::initializer_list<Value> operands,
             uint32_t data = 0, EvaluationPoint point = EvaluationPoint::kMain) {
    return emit(op, static_cast<uint8_t>(variant), type, operands, data, point);
  }

  // As Cycles converts between socket types: scalars are spread, colours become luminance, vectors
  // their average.
  Value convert(Value value, SocketType type);

  Value add(Value a, Value b);       // scalars
  Value multiply(Value a, Value b);  // scalars
  Value one_minus(Value a);          // scalar

  bool is_constant(Value value) const;
  Vec4f constant_value(Value value) const;  // of a constant
  bool is_constant(Value value, float scalar) const;

  // Appends to the data tables and returns the index of the first element. Floats that are there
  // already are not added again, so that equal instructions are known for it.
  uint32_t add_floats(std::span<const float> floats);
  uint32_t add_image(const ImageTexture* image);
  uint32_t add_sky(const PreethamSky& sky);

  const ProgramData& data() const { return data_; }
  ProgramData take_data() { return std::move(data_); }

  // The program that computes `roots`, with nothing else in it. operands[i] receives what reads
  // roots[i] when the program has run (kNoOperand where the root does not exist).
  Program link(std::span<const Value> roots, std::vector<Operand>& operands) const;
  // Whether some instruction has the trait.
  static bool any(const Program& program, bool OpTraits::* trait);

  // Width of a Bump node's differences. A program takes all of its own at the least one.
  void add_bump_filter(float filter);

 private:
  struct Definition {
    Instruction instruction;  // result and operands are definition ids here
    bool is_constant = false;
    Vec4f value;
  };
  struct KeyHash {
    size_t operator()(const std::vector<uint32_t>& key) const;
  };

  std::span<const uint32_t> operands_of(uint32_t id) const;
  bool reads(uint32_t reader, uint32_t id) const;
  bool are_one_noise(uint32_t a, uint32_t b) const;
  std::vector<uint32_t> ordered(std::span<const Value> roots) const;

  ProgramData data_;
  std::vector<Definition> definitions_;
  std::vector<uint32_t> operand_ids_;
  std::unordered_map<std::vector<uint32_t>, uint32_t, KeyHash> known_;
  std::unordered_map<std::vector<uint32_t>, uint32_t, KeyHash> known_floats_;  // by their bits
  float bump_filter_ = kInfinity;
};

}  // namespace vernier
