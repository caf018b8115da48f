#include "math/transform.h"
#include "nodes/color_ops.h"
#include "nodes/image_ops.h"
#include "nodes/math_ops.h"
#include "nodes/normal_ops.h"
#include "nodes/point_ops.h"
#include "nodes/program.h"
#include "nodes/texture_ops.h"
#include "nodes/vector_ops.h"

namespace vernier {
namespace {

Vec4f execute_map_range_vector(MapRangeKind kind, const Arguments& a) {
  Vec3f result;
  for (int i = 0; i < 3; ++i) {
    result[i] = evaluate_map_range_component(
        kind, a.vector(0)[i],
        {a.vector(1)[i], a.vector(2)[i], a.vector(3)[i], a.vector(4)[i], a.vector(5)[i]});
  }
  return to_register(result);
}

Vec3f clamp_between(Vec3f v, Vec3f a, Vec3f b) { return min(max(v, min(a, b)), max(a, b)); }

// Curves: the table's end points are the curve's range; operands are factor and value.
Vec4f execute_curves(const float* table, Vec3f value, float factor) {
  const TableHeader header(table);
  const auto at = [&](float x) {
    return lookup_table(header.rows, (x - header.min) / (header.max - header.min), true,
                        header.extrapolate);
  };
  const Vec3f curved{at(value.x).x, at(value.y).y, at(value.z).z};
  return to_register(value * (1.0f - factor) + curved * factor);
}

Vec4f execute_matrix(const float* rows, Vec3f p) {
  Transform t;
  std::copy_n(rows, t.m.size(), t.m.begin());
  return to_register(t.point(p));
}

Vec4f execute_one_noise(uint8_t variant, const Arguments& a) {
  Vec4f result;
  execute_noise(variant, {&a, 1}, &result);
  return result;
}

float light_falloff(uint8_t power, const SurfacePoint& point, float strength, float smooth) {
  const float length = point.ray_length;
  if (!(length < kInfinity)) {
    return strength;
  }
  for (uint8_t i = 0; i < power; ++i) {
    strength *= length;
  }
  return smooth > 0.0f ? strength * (length * length / (smooth + length * length)) : strength;
}

}  // namespace

OpTraits op_traits(Op op, uint8_t variant) {
  switch (op) {
    case Op::kGeometry: {
      const auto value = static_cast<GeometryValue>(variant);
      OpTraits traits{.reads_point = true};
      traits.side_dependent =
          value == GeometryValue::kBackfacing || value == GeometryValue::kNormal ||
          value == GeometryValue::kTrueNormal || value == GeometryValue::kObjectNormal;
      traits.direction_dependent =
          value == GeometryValue::kIncoming || value == GeometryValue::kReflection;
      return traits;
    }
    case Op::kLightPath:
    case Op::kLightFalloff:
      return {.reads_point = true, .path_dependent = true};
    case Op::kFresnel:
    case Op::kLayerWeight:
      return {.reads_point = true, .direction_dependent = true};
    case Op::kAttribute:
    case Op::kObjectInfo:
    case Op::kCamera:
    case Op::kImageBox:
    case Op::kNormalMap:
    case Op::kBump:
    case Op::kTangent:
    case Op::kVectorTransform:
      return {.reads_point = true};
    default:
      return {};
  }
}

Vec4f execute(const Instruction& in, const Arguments& a, const ProgramData& data,
              const SurfacePoint& point, float step) {
  const auto image = [&] { return data.images[in.data]; };
  const auto floats = [&] { return data.floats.data() + in.data; };
  switch (in.op) {
    case Op::kSplat:
      return to_register(a.scalar(0));
    case Op::kLuminance:
      return to_register(socket_luminance(a.vector(0)));
    case Op::kAverage:
      return to_register(average(a.vector(0)));
    case Op::kExtract:
      return to_register(in.variant == 3 ? a[0].w : a.vector(0)[in.variant]);
    case Op::kCombine:
      return to_register(Vec3f{a.scalar(0), a.scalar(1), a.scalar(2)});
    case Op::kMath:
      return to_register(evaluate_math(static_cast<MathOp>(in.variant), a.scalar(0), a.scalar(1),
                                       in.operand_count > 2 ? a.scalar(2) : 0.0f));
    case Op::kVectorMath:
      return to_register(evaluate_vector_math(static_cast<VectorMathOp>(in.variant), a.vector(0),
                                              a.vector(1), a.vector(2), a.scalar(3)));
    case Op::kVectorMathValue:
      return to_register(evaluate_vector_math_value(static_cast<VectorMathOp>(in.variant),
                                                    a.vector(0), a.vector(1)));
    case Op::kClamp:
      return to_register(evaluate_clamp(static_cast<ClampKind>(in.variant), a.scalar(0),
                                        a.scalar(1), a.scalar(2)));
    case Op::kMapRange:
      return to_register(
          evaluate_map_range(static_cast<MapRangeKind>(in.variant), a.scalar(0),
                             {a.scalar(1), a.scalar(2), a.scalar(3), a.scalar(4), a.scalar(5)}));
    case Op::kMapRangeVector:
      return execute_map_range_vector(static_cast<MapRangeKind>(in.variant), a);
    case Op::kClampBetween:
      return to_register(clamp_between(a.vector(0), a.vector(1), a.vector(2)));
    case Op::kMixFloat:
      return to_register(lerp(a.scalar(1), a.scalar(2), a.scalar(0)));
    case Op::kMixVector: {
      const Vec3f t = a.vector(0);
      return to_register(a.vector(1) * (splat(1.0f) - t) + a.vector(2) * t);
    }
    case Op::kBlend:
      return to_register(
          blend(static_cast<BlendMode>(in.variant), a.scalar(0), a.vector(1), a.vector(2)));
    case Op::kSaturate:
      return to_register(min(max(a.vector(0), Vec3f{}), splat(1.0f)));
    case Op::kVectorRotate:
      return to_register(rotate_vector(static_cast<RotationKind>(in.variant), a.vector(0),
                                       a.vector(1), a.vector(2), a.scalar(3)));
    case Op::kMapping:
      return to_register(map_vector(static_cast<MappingKind>(in.variant), a.vector(0), a.vector(1),
                                    a.vector(2), a.vector(3)));
    case Op::kMatrix:
      return execute_matrix(floats(), a.vector(0));
    case Op::kVectorTransform:
      return to_register(transform_between(static_cast<TransformKind>(in.variant & 3u),
                                           static_cast<VectorSpace>(in.variant >> 2 & 3u),
                                           static_cast<VectorSpace>(in.variant >> 4 & 3u),
                                           a.vector(0), point));
    case Op::kNormalDot:
      return to_register(dot(normalize(a.vector(0)), normalize(a.vector(1))));
    case Op::kGamma:
      return to_register(apply_gamma(a.vector(0), a.scalar(1)));
    case Op::kHueSaturation:
      return to_register(
          adjust_hsv(a.vector(0), a.scalar(1), a.scalar(2), a.scalar(3), a.scalar(4)));
    case Op::kBrightContrast:
      return to_register(adjust_brightness_contrast(a.vector(0), a.scalar(1), a.scalar(2)));
    case Op::kInvert:
      return to_register(invert(a.vector(1), a.scalar(0)));
    case Op::kCombineColor:
      return to_register(
          to_rgb(static_cast<ColorModel>(in.variant), {a.scalar(0), a.scalar(1), a.scalar(2)}));
    case Op::kSeparateColor:
      return to_register(from_rgb(static_cast<ColorModel>(in.variant), a.vector(0)));
    case Op::kBlackbody:
      return to_register(blackbody(a.scalar(0)));
    case Op::kRamp: {
      const TableHeader header(floats());
      return lookup_table(header.rows, a.scalar(0), in.variant != 0, false);
    }
    case Op::kCurves:
      return execute_curves(floats(), a.vector(1), a.scalar(0));
    case Op::kImage:
      return image_texture(image(), ImageUse::unpack(in.variant), a.vector(0));
    case Op::kImageBox:
      return box_texture(image(), ImageUse::unpack(in.variant), a.vector(0), a.scalar(1), point);
    case Op::kEnvironment:
      return environment_texture(image(), ImageUse::unpack(in.variant), a.vector(0));
    case Op::kNoise:
      return execute_one_noise(in.variant, a);
    case Op::kChecker:
      return execute_checker(a);
    case Op::kGradient:
      return execute_gradient(in.variant, a);
    case Op::kBrick:
      return execute_brick(in.variant, a, floats());
    case Op::kWave:
      return execute_wave(in.variant, a);
    case Op::kMagic:
      return execute_magic(in.variant, a);
    case Op::kVoronoi:
      return execute_voronoi(in.variant, a, floats());
    case Op::kWhiteNoise:
      return execute_white_noise(in.variant, a);
    case Op::kSky:
      return to_register(data.skies[in.data].radiance(normalize(a.vector(0))));
    case Op::kGeometry:
      return to_register(geometry_value(static_cast<GeometryValue>(in.variant), point));
    case Op::kAttribute:
      return attribute_value(static_cast<AttributeUse>(in.variant), point, in.data);
    case Op::kObjectInfo:
      return to_register(object_value(static_cast<ObjectValue>(in.variant), point));
    case Op::kLightPath:
      return to_register(light_path_value(static_cast<LightPathValue>(in.variant), point));
    case Op::kCamera:
      return to_register(camera_value(static_cast<CameraValue>(in.variant), point));
    case Op::kFresnel:
      return to_register(fresnel_node(point, a.scalar(0), a.vector(1)));
    case Op::kLayerWeight:
      return to_register(
          layer_weight(static_cast<LayerWeightKind>(in.variant), point, a.scalar(0), a.vector(1)));
    case Op::kNormalMap:
      return to_register(normal_map(static_cast<NormalSpace>(in.variant), point, a.vector(1),
                                    a.scalar(0), in.data));
    case Op::kBump:
      return to_register(bump_normal(point, a.vector(5), {a.scalar(2), a.scalar(3), a.scalar(4)},
                                     a.scalar(0), a.scalar(1), step));
    case Op::kTangent:
      return to_register(in.variant < 3
                             ? radial_tangent(static_cast<TangentAxis>(in.variant), point)
                             : uv_tangent(point, in.data));
    case Op::kLightFalloff:
      return to_register(light_falloff(in.variant, point, a.scalar(0), a.scalar(1)));
  }
  return {};
}

namespace {

// `points` by EvaluationPoint.
void run_at(const std::array<const SurfacePoint*, kEvaluationPoints>& points, float step,
            const Program& program, const ProgramData& data, Vec4f* registers) {
  const auto arguments = [&](const Instruction& in) {
    return Arguments(registers, program.constants.data(), program.operands.data() + in.operands);
  };
  const Instruction* const end = program.code.data() + program.code.size();
  for (const Instruction* in = program.code.data(); in != end; ++in) {
    if (in->op == Op::kNoise && in->data != 0) {
      const std::array<Arguments, kEvaluationPoints> a{arguments(in[0]), arguments(in[1]),
                                                       arguments(in[2])};
      std::array<Vec4f, kEvaluationPoints> results;
      execute_noise(in->variant, a, results.data());
      registers[in[0].result] = results[0];
      registers[in[1].result] = results[1];
      registers[in[2].result] = results[2];
      in += kEvaluationPoints - 1;
    } else {
      registers[in->result] =
          execute(*in, arguments(*in), data, *points[static_cast<size_t>(in->point)], step);
    }
  }
}

}  // namespace

void run(const Program& program, const ProgramData& data, const SurfacePoint& point,
         Vec4f* registers) {
  if (program.uses_bump) {
    const float step = bump_step(point, program.bump_filter);
    const ShiftedPoints moved(point, step);
    run_at({&point, &moved.x, &moved.y}, step, program, data, registers);
  } else {
    run_at({&point, nullptr, nullptr}, 0.0f, program, data, registers);
  }
}

}  // namespace vernier
