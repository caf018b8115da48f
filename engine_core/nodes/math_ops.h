// Scalar and vector arithmetic of the Math, Vector Math, Clamp and Map Range nodes, as Cycles
// defines it (kernel/svm/math_util.h, map_range.h; util/math_base.h).
#pragma once

#include <cstdint>

#include "math/vec.h"

namespace vernier {

// In the order of the node's enum items.
enum class MathOp : uint8_t {
  kAdd,
  kSubtract,
  kMultiply,
  kDivide,
  kMultiplyAdd,
  kPower,
  kLogarithm,
  kSqrt,
  kInverseSqrt,
  kAbsolute,
  kExponent,
  kMinimum,
  kMaximum,
  kLessThan,
  kGreaterThan,
  kSign,
  kCompare,
  kSmoothMin,
  kSmoothMax,
  kRound,
  kFloor,
  kCeil,
  kTrunc,
  kFract,
  kModulo,
  kFlooredModulo,
  kWrap,
  kSnap,
  kPingpong,
  kSine,
  kCosine,
  kTangent,
  kArcsine,
  kArccosine,
  kArctangent,
  kArctan2,
  kSinh,
  kCosh,
  kTanh,
  kRadians,
  kDegrees,
};
float evaluate_math(MathOp op, float a, float b, float c);

enum class VectorMathOp : uint8_t {
  kAdd,
  kSubtract,
  kMultiply,
  kDivide,
  kMultiplyAdd,
  kCrossProduct,
  kProject,
  kReflect,
  kRefract,
  kFaceforward,
  kDotProduct,
  kDistance,
  kLength,
  kScale,
  kNormalize,
  kAbsolute,
  kPower,
  kSign,
  kMinimum,
  kMaximum,
  kRound,
  kFloor,
  kCeil,
  kFraction,
  kModulo,
  kWrap,
  kSnap,
  kSine,
  kCosine,
  kTangent,
};
// Whether the operation's result is the scalar output.
bool is_scalar(VectorMathOp op);
Vec3f evaluate_vector_math(VectorMathOp op, Vec3f a, Vec3f b, Vec3f c, float scale);
float evaluate_vector_math_value(VectorMathOp op, Vec3f a, Vec3f b);

enum class ClampKind : uint8_t { kMinMax, kRange };
float evaluate_clamp(ClampKind kind, float value, float lo, float hi);

enum class MapRangeKind : uint8_t { kLinear, kStepped, kSmoothstep, kSmootherstep };
struct MapRange {
  float from_min, from_max, to_min, to_max, steps;
};
float evaluate_map_range(MapRangeKind kind, float value, const MapRange& range);
// One component of the vector form, which differs where the range is empty or reversed.
float evaluate_map_range_component(MapRangeKind kind, float value, const MapRange& range);

// a / b, 0 where b is 0.
inline float safe_divide(float a, float b) { return b != 0.0f ? a / b : 0.0f; }
inline Vec3f safe_divide(Vec3f a, Vec3f b) {
  return {safe_divide(a.x, b.x), safe_divide(a.y, b.y), safe_divide(a.z, b.z)};
}

}  // namespace vernier
