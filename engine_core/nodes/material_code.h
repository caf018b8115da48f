// What a material runs: one program for all its closures, and shorter ones for emission and
// transparency alone.
#pragma once

#include "nodes/closures.h"
#include "nodes/program.h"

namespace vernier {

struct ProgramPart {
  Program program;
  ClosureList list;
};

struct MaterialCode {
  ProgramData data;
  ProgramPart surface, emission, transparency;
};

}  // namespace vernier
