// From single-assignment form to a register program: dead code goes, registers are reused as soon
// as their value has had its last reader.
#include <algorithm>
#include <limits>

#include "nodes/builder.h"

namespace vernier {

Program ProgramBuilder::link(std::span<const Value> roots, std::vector<Operand>& operands) const {
  constexpr uint32_t kNever = 0;
  constexpr uint32_t kAtEnd = std::numeric_limits<uint32_t>::max();
  const auto count = static_cast<uint32_t>(definitions_.size());

  // 1. The last reader of every definition, from the end back: definitions come in order of
  //    dependence, so a definition without a reader by then is dead. Readers are counted from 1.
  std::vector<uint32_t> last_reader(count, kNever);
  for (const Value& root : roots) {
    if (root.exists()) {
      last_reader[root.id] = kAtEnd;
    }
  }
  for (uint32_t id = count; id-- > 0;) {
    if (last_reader[id] == kNever || definitions_[id].is_constant) {
      continue;
    }
    const Instruction& instruction = definitions_[id].instruction;
    for (uint32_t i = 0; i < instruction.operand_count; ++i) {
      uint32_t& reader = last_reader[operand_ids_[instruction.operands + i]];
      reader = std::max(reader, id + 1);
    }
  }

  // 2. Registers by a linear scan with a free list.
  Program program;
  program.bump_filter = bump_filter_;
  std::vector<Operand> location(count, kNoOperand);
  std::vector<uint32_t> free_registers;
  const auto place = [&](uint32_t id) {
    if (definitions_[id].is_constant && location[id] == kNoOperand) {
      location[id] = kConstantBit | static_cast<uint32_t>(program.constants.size());
      program.constants.push_back(definitions_[id].value);
    }
    return location[id];
  };
  for (uint32_t id = 0; id < count; ++id) {
    if (last_reader[id] == kNever || definitions_[id].is_constant) {
      continue;
    }
    Instruction instruction = definitions_[id].instruction;
    const uint32_t first = instruction.operands;
    instruction.operands = static_cast<uint32_t>(program.operands.size());
    for (uint32_t i = 0; i < instruction.operand_count; ++i) {
      program.operands.push_back(place(operand_ids_[first + i]));
    }
    for (uint32_t i = 0; i < instruction.operand_count; ++i) {
      const uint32_t read = operand_ids_[first + i];
      // An instruction reads its operands before it writes: it may overwrite them. kAtEnd marks
      // that the register was given back, as one operand can occur twice.
      if (!definitions_[read].is_constant && last_reader[read] == id + 1) {
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
