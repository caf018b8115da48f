// From single-assignment form to a register program: dead code goes, registers are reused as soon
// as their value has had its last reader.
#include <algorithm>
#include <limits>

#include "nodes/builder.h"

namespace vernier {

std::span<const uint32_t> ProgramBuilder::operands_of(uint32_t id) const {
  const Instruction& instruction = definitions_[id].instruction;
  return std::span(operand_ids_).subspan(instruction.operands, instruction.operand_count);
}

// Whether two instructions are one noise at different points, neither of which `b` has from `a`.
bool ProgramBuilder::are_one_noise(uint32_t a, uint32_t b) const {
  constexpr size_t kCoordinates = 2;  // operands: the vector and W
  const Instruction& in = definitions_[a].instruction;
  const Instruction& other = definitions_[b].instruction;
  return in.op == Op::kNoise && other.op == Op::kNoise && in.variant == other.variant &&
         std::ranges::equal(operands_of(a).subspan(kCoordinates),
                            operands_of(b).subspan(kCoordinates)) &&
         !reads(b, a);
}

bool ProgramBuilder::reads(uint32_t reader, uint32_t id) const {
  return std::ranges::count(operands_of(reader), id) != 0;
}

// What the roots need, in an order of dependence in which the noises that a Bump node compares
// follow one another: each is put off until the next, unless something reads it before.
std::vector<uint32_t> ProgramBuilder::ordered(std::span<const Value> roots) const {
  // Definitions come in order of dependence: from the end back, one without a reader is dead.
  std::vector<bool> is_read(definitions_.size());
  for (const Value& root : roots) {
    if (root.exists()) {
      is_read[root.id] = true;
    }
  }
  std::vector<uint32_t> order;
  for (auto id = static_cast<uint32_t>(definitions_.size()); id-- > 0;) {
    if (!is_read[id] || definitions_[id].is_constant) {
      continue;
    }
    order.push_back(id);
    for (const uint32_t operand : operands_of(id)) {
      is_read[operand] = true;
    }
  }
  std::ranges::reverse(order);
  for (auto at = order.end(); at != order.begin();) {
    --at;
    const uint32_t id = *at;
    if (definitions_[id].instruction.op == Op::kNoise) {
      const auto next = std::find_if(at + 1, order.end(), [&](uint32_t other) {
        return are_one_noise(id, other) || reads(other, id);
      });
      if (next != order.end() && are_one_noise(id, *next)) {
        std::rotate(at, at + 1, next);
      }
    }
  }
  return order;
}

Program ProgramBuilder::link(std::span<const Value> roots, std::vector<Operand>& operands) const {
  constexpr uint32_t kAtEnd = std::numeric_limits<uint32_t>::max();
  const std::vector<uint32_t> order = ordered(roots);
  // The position of a definition's last reader.
  std::vector<uint32_t> last_reader(definitions_.size(), kAtEnd);
  for (uint32_t position = 0; position < order.size(); ++position) {
    for (const uint32_t operand : operands_of(order[position])) {
      last_reader[operand] = position;
    }
  }
  for (const Value& root : roots) {
    if (root.exists()) {
      last_reader[root.id] = kAtEnd;
    }
  }

  // Registers by a linear scan with a free list.
  Program program;
  program.bump_filter = bump_filter_;
  std::vector<Operand> location(definitions_.size(), kNoOperand);
  std::vector<uint32_t> free_registers;
  const auto place = [&](uint32_t id) {
    if (definitions_[id].is_constant && location[id] == kNoOperand) {
      location[id] = kConstantBit | static_cast<uint32_t>(program.constants.size());
      program.constants.push_back(definitions_[id].value);
    }
    return location[id];
  };
  for (uint32_t position = 0; position < order.size(); ++position) {
    const uint32_t id = order[position];
    Instruction instruction = definitions_[id].instruction;
    instruction.operands = static_cast<uint32_t>(program.operands.size());
    for (const uint32_t read : operands_of(id)) {
      program.operands.push_back(place(read));
    }
    for (const uint32_t read : operands_of(id)) {
      // An instruction reads its operands before it writes: it may overwrite them. kAtEnd marks
      // that the register was given back, as one operand can occur twice.
      if (!definitions_[read].is_constant && last_reader[read] == position) {
        free_registers.push_back(location[read]);
        last_reader[read] = kAtEnd;
      }
    }
    if (free_registers.empty()) {
      instruction.result = program.register_count++;
    } else {
      instruction.result = free_registers.back();
      free_registers.pop_back();
    }
    location[id] = instruction.result;
    program.uses_bump = program.uses_bump || instruction.op == Op::kBump;
    program.code.push_back(instruction);
  }

  // Noises are evaluated by threes.
  for (size_t i = 0; i + kEvaluationPoints <= order.size(); ++i) {
    const uint32_t first = order[i], second = order[i + 1], third = order[i + 2];
    if (are_one_noise(first, second) && are_one_noise(first, third) &&
        are_one_noise(second, third)) {
      program.code[i].data = 1;
      i += kEvaluationPoints - 1;
    }
  }

  operands.clear();
  for (const Value& root : roots) {
    operands.push_back(root.exists() ? place(root.id) : kNoOperand);
  }
  return program;
}

bool ProgramBuilder::any(const Program& program, bool OpTraits::* trait) {
  return std::any_of(program.code.begin(), program.code.end(),
                     [&](const Instruction& i) { return op_traits(i.op, i.variant).*trait; });
}

}  // namespace vernier
