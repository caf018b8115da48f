#include "nodes/image_ops.h"

#include "nodes/point_ops.h"

namespace vernier {
namespace {

Vec4f sample(const ImageTexture* image, const ImageUse& use, Vec2f uv) {
  if (image == nullptr) {
    return {1.0f, 0.0f, 1.0f, 1.0f};  // Cycles' missing image
  }
  return image->sample(uv.x, uv.y, use.interpolation, use.extension, use.straight);
}

Vec2f to_sphere(Vec3f p) {
  const float squared = length_squared(p);
  if (!(squared > 0.0f)) {
    return {};
  }
  const float u = p.x == 0.0f && p.y == 0.0f ? 0.0f : 0.5f - std::atan2(p.x, p.y) * kInvTwoPi;
  return {u, 1.0f - std::acos(clamp(p.z / std::sqrt(squared), -1.0f, 1.0f)) * kInvPi};
}

Vec2f to_tube(Vec3f p) {
  if (p.x == 0.0f && p.y == 0.0f) {
    return {};
  }
  return {(1.0f - std::atan2(p.x, p.y) * kInvPi) * 0.5f, (p.z + 1.0f) * 0.5f};
}

Vec2f to_equirectangular(Vec3f d) {
  if (is_black(d)) {
    return {};
  }
  return {0.5f - std::atan2(d.y, d.x) * kInvTwoPi,
          1.0f - std::acos(clamp(d.z, -1.0f, 1.0f)) * kInvPi};
}

// Seen in a mirror ball from -y.
Vec2f to_mirror_ball(Vec3f d) {
  d.y -= 1.0f;
  const float divisor = 2.0f * safe_sqrt(-0.5f * d.y);
  if (divisor > 0.0f) {
    d = d / divisor;
  }
  return {0.5f * (d.x + 1.0f), 0.5f * (d.z + 1.0f)};
}

// Shares of the three projections. `n` holds the normal's magnitudes, summing to 1: barycentric
// coordinates in a triangle whose corners show one side, edges two and middle three.
Vec3f box_weights(Vec3f n, float blend) {
  const float limit = 0.5f * (1.0f + blend);
  const auto leads = [&](float a, float b, float c) {
    return a > limit * (a + b) && a > limit * (a + c);
  };
  if (leads(n.x, n.y, n.z)) return {1, 0, 0};
  if (leads(n.y, n.x, n.z)) return {0, 1, 0};
  if (leads(n.z, n.x, n.y)) return {0, 0, 1};
  if (!(blend > 0.0f)) return {1, 0, 0};
  const auto share = [&](float a, float b) {
    return saturate((a / (a + b) - 0.5f * (1.0f - blend)) / blend);
  };
  if (n.z < (1.0f - limit) * (n.y + n.x)) {
    const float x = share(n.x, n.y);
    return {x, 1.0f - x, 0};
  }
  if (n.x < (1.0f - limit) * (n.y + n.z)) {
    const float y = share(n.y, n.z);
    return {0, y, 1.0f - y};
  }
  if (n.y < (1.0f - limit) * (n.x + n.z)) {
    const float x = share(n.x, n.z);
    return {x, 0, 1.0f - x};
  }
  return (n * (2.0f - limit) + splat(limit - 1.0f)) / (2.0f * limit - 1.0f);
}

}  // namespace

uint8_t ImageUse::pack() const {
  return static_cast<uint8_t>(projection | static_cast<unsigned>(interpolation) << 2 |
                              static_cast<unsigned>(extension) << 4 | (straight ? 64u : 0u));
}

ImageUse ImageUse::unpack(uint8_t bits) {
  return {static_cast<uint8_t>(bits & 3u), static_cast<Interpolation>(bits >> 2 & 3u),
          static_cast<Extension>(bits >> 4 & 3u), (bits & 64u) != 0};
}

Vec4f image_texture(const ImageTexture* image, const ImageUse& use, Vec3f p) {
  switch (static_cast<ImageProjection>(use.projection)) {
    case ImageProjection::kFlat:
      return sample(image, use, {p.x, p.y});
    case ImageProjection::kSphere:
      return sample(image, use, to_sphere(p * 2.0f - splat(1.0f)));
    case ImageProjection::kTube:
      return sample(image, use, to_tube(p * 2.0f - splat(1.0f)));
  }
  return {};
}

Vec4f box_texture(const ImageTexture* image, const ImageUse& use, Vec3f p, float blend,
                  const SurfacePoint& point) {
  const Vec3f n = render_normal_to_object(point, point.ns);
  const Vec3f magnitude = abs(n);
  const float sum = magnitude.x + magnitude.y + magnitude.z;
  const Vec3f weight = sum > 0.0f ? box_weights(magnitude / sum, blend) : Vec3f{1, 0, 0};
  Vec4f color;
  if (weight.x > 0.0f) {
    color = color + sample(image, use, {n.x < 0.0f ? 1.0f - p.y : p.y, p.z}) * weight.x;
  }
  if (weight.y > 0.0f) {
    color = color + sample(image, use, {n.y > 0.0f ? 1.0f - p.x : p.x, p.z}) * weight.y;
  }
  if (weight.z > 0.0f) {
    color = color + sample(image, use, {n.z > 0.0f ? 1.0f - p.y : p.y, p.x}) * weight.z;
  }
  return color;
}

Vec4f environment_texture(const ImageTexture* image, const ImageUse& use, Vec3f direction) {
  const Vec3f d = normalize(direction);
  const bool ball =
      static_cast<EnvironmentProjection>(use.projection) == EnvironmentProjection::kMirrorBall;
  return sample(image, use, ball ? to_mirror_ball(d) : to_equirectangular(d));
}

}  // namespace vernier
