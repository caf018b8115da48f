#include "nodes/math_ops.h"

namespace vernier {
namespace {

float safe_power(float a, float b) {
  if (b == 0.0f) {
    return 1.0f;
  }
  if (a == 0.0f || (a < 0.0f && b != std::trunc(b))) {
    return 0.0f;
  }
  return std::pow(a, b);
}

float wrap(float value, float max, float min) {
  const float range = max - min;
  return range != 0.0f ? value - range * std::floor((value - min) / range) : min;
}

float sign(float a) { return a == 0.0f ? 0.0f : (a < 0.0f ? -1.0f : 1.0f); }

float smooth_minimum(float a, float b, float k) {
  if (k == 0.0f) {
    return std::min(a, b);
  }
  const float h = std::max(k - std::abs(a - b), 0.0f) / k;
  return std::min(a, b) - h * h * h * k * (1.0f / 6.0f);
}

float pingpong(float a, float b) {
  if (b == 0.0f) {
    return 0.0f;
  }
  const float t = (a - b) / (b * 2.0f);
  return std::abs((t - std::floor(t)) * b * 2.0f - b);
}

float logarithm(float a, float b) {
  return a <= 0.0f || b <= 0.0f ? 0.0f : safe_divide(std::log(a), std::log(b));
}

template <typename F>
Vec3f map(F f, Vec3f a) {
  return {f(a.x), f(a.y), f(a.z)};
}
template <typename F>
Vec3f map(F f, Vec3f a, Vec3f b) {
  return {f(a.x, b.x), f(a.y, b.y), f(a.z, b.z)};
}

Vec3f reflect(Vec3f incident, Vec3f normal) {
  return incident - normal * (2.0f * dot(incident, normal));
}

Vec3f refract(Vec3f incident, Vec3f normal, float eta) {
  const float cosine = dot(normal, incident);
  const float k = 1.0f - eta * eta * (1.0f - cosine * cosine);
  return k < 0.0f ? Vec3f{} : incident * eta - normal * (eta * cosine + std::sqrt(k));
}

Vec3f project(Vec3f a, Vec3f b) {
  const float squared = dot(b, b);
  return squared != 0.0f ? b * (dot(a, b) / squared) : Vec3f{};
}

float smooth_step(float t) { return t * t * (3.0f - 2.0f * t); }
float smoother_step(float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }

}  // namespace

float evaluate_math(MathOp op, float a, float b, float c) {
  switch (op) {
    case MathOp::kAdd:
      return a + b;
    case MathOp::kSubtract:
      return a - b;
    case MathOp::kMultiply:
      return a * b;
    case MathOp::kDivide:
      return safe_divide(a, b);
    case MathOp::kMultiplyAdd:
      return a * b + c;
    case MathOp::kPower:
      return safe_power(a, b);
    case MathOp::kLogarithm:
      return logarithm(a, b);
    case MathOp::kSqrt:
      return safe_sqrt(a);
    case MathOp::kInverseSqrt:
      return a > 0.0f ? 1.0f / std::sqrt(a) : 0.0f;
    case MathOp::kAbsolute:
      return std::abs(a);
    case MathOp::kExponent:
      return std::exp(a);
    case MathOp::kMinimum:
      return std::min(a, b);
    case MathOp::kMaximum:
      return std::max(a, b);
    case MathOp::kLessThan:
      return a < b ? 1.0f : 0.0f;
    case MathOp::kGreaterThan:
      return a > b ? 1.0f : 0.0f;
    case MathOp::kSign:
      return sign(a);
    // The least tolerance is the spacing of floats at 1, as in Cycles.
    case MathOp::kCompare:
      return a == b || std::abs(a - b) <= std::max(c, 2.0f * 0x1p-24f) ? 1.0f : 0.0f;
    case MathOp::kSmoothMin:
      return smooth_minimum(a, b, c);
    case MathOp::kSmoothMax:
      return -smooth_minimum(-a, -b, c);
    case MathOp::kRound:
      return std::floor(a + 0.5f);
    case MathOp::kFloor:
      return std::floor(a);
    case MathOp::kCeil:
      return std::ceil(a);
    case MathOp::kTrunc:
      return std::trunc(a);
    case MathOp::kFract:
      return a - std::floor(a);
    case MathOp::kModulo:
      return b != 0.0f ? std::fmod(a, b) : 0.0f;
    case MathOp::kFlooredModulo:
      return b != 0.0f ? a - std::floor(a / b) * b : 0.0f;
    case MathOp::kWrap:
      return wrap(a, b, c);
    case MathOp::kSnap:
      return std::floor(safe_divide(a, b)) * b;
    case MathOp::kPingpong:
      return pingpong(a, b);
    case MathOp::kSine:
      return std::sin(a);
    case MathOp::kCosine:
      return std::cos(a);
    case MathOp::kTangent:
      return std::tan(a);
    case MathOp::kArcsine:
      return std::asin(clamp(a, -1.0f, 1.0f));
    case MathOp::kArccosine:
      return std::acos(clamp(a, -1.0f, 1.0f));
    case MathOp::kArctangent:
      return std::atan(a);
    case MathOp::kArctan2:
      return a == 0.0f && b == 0.0f ? 0.0f : std::atan2(a, b);
    case MathOp::kSinh:
      return std::sinh(a);
    case MathOp::kCosh:
      return std::cosh(a);
    case MathOp::kTanh:
      return std::tanh(a);
    case MathOp::kRadians:
      return a * (kPi / 180.0f);
    case MathOp::kDegrees:
      return a * (180.0f / kPi);
  }
  return 0.0f;
}

bool is_scalar(VectorMathOp op) {
  return op == VectorMathOp::kDotProduct || op == VectorMathOp::kDistance ||
         op == VectorMathOp::kLength;
}

Vec3f evaluate_vector_math(VectorMathOp op, Vec3f a, Vec3f b, Vec3f c, float scale) {
  const auto each = [&](MathOp scalar) {
    return Vec3f{evaluate_math(scalar, a.x, b.x, c.x), evaluate_math(scalar, a.y, b.y, c.y),
                 evaluate_math(scalar, a.z, b.z, c.z)};
  };
  switch (op) {
    case VectorMathOp::kAdd:
      return a + b;
    case VectorMathOp::kSubtract:
      return a - b;
    case VectorMathOp::kMultiply:
      return a * b;
    case VectorMathOp::kDivide:
      return safe_divide(a, b);
    case VectorMathOp::kMultiplyAdd:
      return a * b + c;
    case VectorMathOp::kCrossProduct:
      return cross(a, b);
    case VectorMathOp::kProject:
      return project(a, b);
    case VectorMathOp::kReflect:
      return reflect(a, normalize(b));
    case VectorMathOp::kRefract:
      return refract(a, normalize(b), scale);
    case VectorMathOp::kFaceforward:
      return dot(c, b) < 0.0f ? a : -a;
    case VectorMathOp::kScale:
      return a * scale;
    case VectorMathOp::kNormalize:
      return normalize(a);
    case VectorMathOp::kAbsolute:
      return abs(a);
    case VectorMathOp::kPower:
      return map(safe_power, a, b);
    case VectorMathOp::kSign:
      return map(sign, a);
    case VectorMathOp::kMinimum:
      return min(a, b);
    case VectorMathOp::kMaximum:
      return max(a, b);
    case VectorMathOp::kRound:
      return each(MathOp::kRound);
    case VectorMathOp::kFloor:
      return each(MathOp::kFloor);
    case VectorMathOp::kCeil:
      return each(MathOp::kCeil);
    case VectorMathOp::kFraction:
      return each(MathOp::kFract);
    case VectorMathOp::kModulo:
      return each(MathOp::kModulo);
    case VectorMathOp::kWrap:
      return each(MathOp::kWrap);
    case VectorMathOp::kSnap:
      return each(MathOp::kSnap);
    case VectorMathOp::kSine:
      return each(MathOp::kSine);
    case VectorMathOp::kCosine:
      return each(MathOp::kCosine);
    case VectorMathOp::kTangent:
      return each(MathOp::kTangent);
    case VectorMathOp::kDotProduct:
    case VectorMathOp::kDistance:
    case VectorMathOp::kLength:
      break;
  }
  return {};
}

float evaluate_vector_math_value(VectorMathOp op, Vec3f a, Vec3f b) {
  switch (op) {
    case VectorMathOp::kDotProduct:
      return dot(a, b);
    case VectorMathOp::kDistance:
      return length(a - b);
    case VectorMathOp::kLength:
      return length(a);
    default:
      return 0.0f;
  }
}

float evaluate_clamp(ClampKind kind, float value, float lo, float hi) {
  return kind == ClampKind::kRange && lo > hi ? clamp(value, hi, lo) : clamp(value, lo, hi);
}

float evaluate_map_range(MapRangeKind kind, float value, const MapRange& r) {
  if (r.from_max == r.from_min) {
    return 0.0f;
  }
  // A reversed range needs no case of its own: 1 - s(1 - t) = s(t) for both smooth steps.
  float t = (value - r.from_min) / (r.from_max - r.from_min);
  switch (kind) {
    case MapRangeKind::kLinear:
      break;
    case MapRangeKind::kStepped:
      t = r.steps > 0.0f ? std::floor(t * (r.steps + 1.0f)) / r.steps : 0.0f;
      break;
    case MapRangeKind::kSmoothstep:
      t = smooth_step(saturate(t));
      break;
    case MapRangeKind::kSmootherstep:
      t = smoother_step(saturate(t));
      break;
  }
  return r.to_min + t * (r.to_max - r.to_min);
}

float evaluate_map_range_component(MapRangeKind kind, float value, const MapRange& r) {
  if (r.from_max == r.from_min) {
    return r.to_min;
  }
  return evaluate_map_range(kind, value, r);
}

}  // namespace vernier
