// The closures that a material program ends in, and how they reach a Bsdf.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bsdf/bsdf.h"
#include "nodes/program.h"

namespace vernier {

enum class ClosureKind : uint8_t {
  kDiffuse,
  kTranslucent,
  kTransparent,
  kGlossy,
  kMetallic,
  kGlass,
  kRefraction,
  kSheen,
  kVelvet,
  kToon,
  kSubsurface,
  kPrincipled,
  kEmission,
  kHoldout,
};

// A closure: its share in the mix, its normal (kNoOperand: the shading normal) and the node's
// sockets, in the order of the enums below.
struct ClosureCode {
  ClosureKind kind = ClosureKind::kDiffuse;
  Distribution distribution = Distribution::kGgx;
  bool option = false;  // metallic: physical; toon: glossy; principled: coat normal linked
  Operand weight = kNoOperand;
  Operand normal = kNoOperand;
  uint32_t parameters = 0;  // first one, in ClosureList::operands
};

// Closures and what they read, for one program.
struct ClosureList {
  std::vector<ClosureCode> closures;
  std::vector<Operand> operands;
};

// Values that a program has left for its closures.
struct ProgramResult {
  const Vec4f* registers = nullptr;
  const Vec4f* constants = nullptr;

  const Vec4f& operator[](Operand operand) const {
    return (operand & kConstantBit) != 0 ? constants[operand & ~kConstantBit] : registers[operand];
  }
};

// Order of the parameters, by kind of closure. Transparent, translucent, sheen, velvet,
// subsurface and holdout have a colour (holdout: none) and, sheen and velvet, a roughness.
namespace diffuse {
enum : uint8_t { kColor, kRoughness };
}
namespace glossy {
enum : uint8_t { kColor, kRoughness, kAnisotropy, kRotation, kTangent };
}
namespace metallic {
enum : uint8_t {
  kBase,
  kEdge,
  kRoughness,
  kAnisotropy,
  kRotation,
  kTangent,
  kFilmThickness,
  kFilmIor,
};
}
namespace glass {
enum : uint8_t { kColor, kRoughness, kIor, kFilmThickness, kFilmIor };
}
namespace toon {
enum : uint8_t { kColor, kSize, kSmooth };
}
namespace emission {
enum : uint8_t { kColor, kStrength };
}
namespace principled {
enum : uint8_t {
  kBaseColor,
  kMetallic,
  kRoughness,
  kIor,
  kAlpha,
  kThinWall,
  kDiffuseRoughness,
  kSubsurface,
  kSubsurfaceAnisotropy,
  kSpecularLevel,
  kSpecularTint,
  kAnisotropic,
  kAnisotropicRotation,
  kTangent,
  kTransmission,
  kCoat,
  kCoatRoughness,
  kCoatIor,
  kCoatTint,
  kCoatNormal,
  kSheen,
  kSheenRoughness,
  kSheenTint,
  kEmissionColor,
  kEmissionStrength,
  kFilmThickness,
  kFilmIor,
};
}

// Adds a closure's lobes, as the kernel's closure nodes do (Cycles, kernel/svm/closure.h).
void add_closure(const ClosureList& list, const ClosureCode& closure, const ProgramResult& values,
                 const SurfacePoint& point, Bsdf& bsdf);
// Radiance toward point.wo of one closure.
Color closure_emission(const ClosureList& list, const ClosureCode& closure,
                       const ProgramResult& values, const SurfacePoint& point);
// Weight of what one closure passes straight through.
Color closure_transparency(const ClosureList& list, const ClosureCode& closure,
                           const ProgramResult& values);

}  // namespace vernier
