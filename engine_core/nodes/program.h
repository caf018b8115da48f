// Register programs: what a node graph becomes.
//
// An instruction reads up to kMaxOperands Vec4f operands (registers or constants) and writes one
// register. Scalars live in x; vectors and colours in xyz; w holds an image's or ramp's alpha.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "math/vec.h"
#include "scene/surface_point.h"
#include "textures/sky.h"

namespace vernier {

class ImageTexture;

// What an instruction does. Families are refined by Instruction::variant, an enum of the family.
enum class Op : uint8_t {
  // conversions
  kSplat,      // x to xyz
  kLuminance,  // colour to x
  kAverage,    // vector to x
  kExtract,    // component `variant` to x
  kCombine,    // x of three operands to xyz
  // arithmetic
  kMath,             // MathOp
  kVectorMath,       // VectorMathOp
  kVectorMathValue,  // VectorMathOp, the scalar output
  kClamp,            // ClampKind
  kMapRange,         // MapRangeKind
  kMapRangeVector,   // MapRangeKind
  kClampBetween,     // to the range of two operands in either order
  kMixFloat,
  kMixVector,  // the factor has three components
  kBlend,      // BlendMode
  kSaturate,
  kVectorRotate,  // RotationKind
  kMapping,       // MappingKind
  kMatrix,        // vector under an affine matrix in data
  kVectorTransform,
  kNormalDot,
  // colour
  kGamma,
  kHueSaturation,
  kBrightContrast,
  kInvert,
  kCombineColor,   // ColorModel
  kSeparateColor,  // ColorModel
  kBlackbody,
  kRamp,
  kCurves,
  // textures
  kImage,
  kImageBox,
  kEnvironment,
  kNoise,  // data: 1 if the next two are the same noise elsewhere, to be evaluated together
  kChecker,
  kGradient,
  kBrick,
  kWave,
  kMagic,
  kVoronoi,  // VoronoiOutput; data: see execute_voronoi
  kWhiteNoise,
  kSky,  // data: an index into ProgramData::skies
  // the surface point
  kGeometry,    // GeometryValue
  kAttribute,   // AttributeUse; data: attribute id
  kObjectInfo,  // ObjectValue
  kLightPath,   // LightPathValue
  kCamera,      // CameraValue
  kFresnel,
  kLayerWeight,
  kNormalMap,
  kBump,
  kTangent,
  kLightFalloff,
};

// The point an instruction is evaluated at: the surface point, or one of the two neighbours that
// bump mapping takes differences with.
enum class EvaluationPoint : uint8_t { kMain, kShiftedX, kShiftedY };
inline constexpr size_t kEvaluationPoints = 3;

// A register, or with the top bit set a constant of the program.
using Operand = uint32_t;
inline constexpr Operand kConstantBit = 0x80000000u;
inline constexpr Operand kNoOperand = 0xffffffffu;

struct Instruction {
  Op op = Op::kSplat;
  uint8_t variant = 0;
  EvaluationPoint point = EvaluationPoint::kMain;
  uint8_t operand_count = 0;
  uint32_t result = 0;    // register
  uint32_t operands = 0;  // first one, in Program::operands
  uint32_t data = 0;      // an index into ProgramData, by family
};

// Tables that instructions refer to; shared by the programs of a material.
struct ProgramData {
  std::vector<float> floats;
  std::vector<const ImageTexture*> images;  // null: none chosen, drawn as missing
  std::vector<PreethamSky> skies;
};

struct Program {
  std::vector<Instruction> code;
  std::vector<Operand> operands;
  std::vector<Vec4f> constants;
  uint32_t register_count = 0;
  bool uses_bump = false;
  float bump_filter = 0.1f;  // step of bump differences over the pixel's width
};

// The operands of one instruction.
class Arguments {
 public:
  Arguments(const Vec4f* registers, const Vec4f* constants, const Operand* operands)
      : registers_(registers), constants_(constants), operands_(operands) {}

  const Vec4f& operator[](int i) const {
    const Operand operand = operands_[i];
    return (operand & kConstantBit) != 0 ? constants_[operand & ~kConstantBit]
                                         : registers_[operand];
  }
  float scalar(int i) const { return (*this)[i].x; }
  Vec3f vector(int i) const { return (*this)[i].xyz(); }

 private:
  const Vec4f* registers_;
  const Vec4f* constants_;
  const Operand* operands_;
};

// What a family of instructions reads beside its operands.
struct OpTraits {
  bool reads_point = false;          // anything of the surface point: never folded
  bool side_dependent = false;       // the side of the surface that wo is on
  bool direction_dependent = false;  // more of wo than that
  bool path_dependent = false;       // ray flags, ray length or depth
};
OpTraits op_traits(Op op, uint8_t variant);

// The value of one instruction; `step` is the length of bump mapping's differences.
Vec4f execute(const Instruction& instruction, const Arguments& arguments, const ProgramData& data,
              const SurfacePoint& point, float step);

// Runs the program; `registers` has room for register_count values.
void run(const Program& program, const ProgramData& data, const SurfacePoint& point,
         Vec4f* registers);

inline Vec4f to_register(Vec3f v) { return {v.x, v.y, v.z, 1.0f}; }
inline Vec4f to_register(float v) { return {v, v, v, 1.0f}; }

}  // namespace vernier
