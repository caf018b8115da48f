#include "camera/camera.h"

#include "math/warp.h"

namespace vernier {
namespace {

// Area of the regular polygon with `n` corners on the unit circle.
float polygon_area(int n) {
  const auto sides = static_cast<float>(n);
  return 0.5f * sides * std::sin(kTwoPi / sides);
}

// A point uniform over that polygon, the first corner at angle `rotation`.
Vec2f sample_polygon(int n, float rotation, Vec2f u) {
  const float scaled = u.x * static_cast<float>(n);
  const float corner = std::min(std::floor(scaled), static_cast<float>(n - 1));
  const Vec2f b = square_to_triangle({std::min(scaled - corner, kOneMinusEpsilon), u.y});
  const float step = kTwoPi / static_cast<float>(n);
  const float a0 = rotation + corner * step;
  const float a1 = a0 + step;
  return Vec2f{std::cos(a0), std::sin(a0)} * b.x + Vec2f{std::cos(a1), std::sin(a1)} * b.y;
}

}  // namespace

Camera::Camera(const CameraDesc& desc, const FilmDesc& film, const double origin[3])
    : desc_(desc),
      width_(static_cast<float>(film.width)),
      height_(static_cast<float>(film.height)) {
  const Transform& t = desc.transform;
  frame_ = Frame(normalize(t.column(2)), normalize(t.column(0)));
  // Frame() puts s in the plane of normal and tangent: for an orthogonal matrix it is the tangent.
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    position_[axis] = static_cast<float>(static_cast<double>(t.m[4 * a + 3]) - origin[a]);
  }
  const auto& w = desc.window;
  window_area_ = (w[1] - w[0]) * (w[3] - w[2]);
  lens_area_ = 1.0f;
  if (!is_pinhole()) {
    const float unit_area = desc.blades >= 3 ? polygon_area(desc.blades) : kPi;
    lens_area_ = unit_area * square(desc.aperture_radius) / desc.aperture_ratio;
  }
  pixel_radius_ = 0.5f * std::sqrt(window_area_ / (width_ * height_));
  const Vec2f corner{std::max(std::abs(w[0]), std::abs(w[1])),
                     std::max(std::abs(w[2]), std::abs(w[3]))};
  least_cosine_ = 1.0f / std::hypot(1.0f, corner.x, corner.y);
}

Vec2f Camera::raster_to_window(Vec2f raster) const {
  const auto& w = desc_.window;
  return {lerp(w[0], w[1], raster.x / width_), lerp(w[2], w[3], raster.y / height_)};
}

Vec2f Camera::window_to_raster(Vec2f p) const {
  const auto& w = desc_.window;
  return {(p.x - w[0]) / (w[1] - w[0]) * width_, (p.y - w[2]) / (w[3] - w[2]) * height_};
}

Vec2f Camera::sample_lens(Vec2f u) const {
  const Vec2f p =
      desc_.blades >= 3 ? sample_polygon(desc_.blades, desc_.blade_rotation, u) : square_to_disk(u);
  return {p.x * desc_.aperture_radius / desc_.aperture_ratio, p.y * desc_.aperture_radius};
}

CameraRay Camera::generate_ray(Vec2f raster, Vec2f u_lens) const {
  const Vec2f window = raster_to_window(raster);
  Vec3f origin, direction;  // camera space; the view axis is -z
  if (is_orthographic()) {
    origin = {window.x, window.y, 0.0f};
    direction = {0.0f, 0.0f, -1.0f};
  } else {
    direction = {window.x, window.y, -1.0f};
  }
  if (!is_pinhole()) {
    const Vec2f lens = sample_lens(u_lens);
    const Vec3f offset{lens.x, lens.y, 0.0f};
    const Vec3f focus = origin + direction * desc_.focus_distance;
    origin += offset;
    direction = focus - origin;
  }
  direction = normalize(direction);
  // Distances along the ray to planes at a depth grow by 1/cos.
  const float inv_cos = 1.0f / std::max(-direction.z, std::numeric_limits<float>::min());
  CameraRay r;
  r.start_distance = desc_.clip_start * inv_cos;
  r.ray.d = frame_.to_world(direction);
  r.ray.o = position_ + frame_.to_world(origin + direction * r.start_distance);
  r.ray.t_max = (desc_.clip_end - desc_.clip_start) * inv_cos;
  return r;
}

// A pixel's rays pass uniformly through its part of the window, area W = window_area / pixels.
// Perspective: solid angle and area at distance 1 along the axis are tied by cos^3, and the
// measurement has a further cosine at the lens: We = 1 / (W cos^4 A_lens) (Pharr, Jakob and
// Humphreys 2016, equation 16.3). Orthographic: We = 1 / (W A_lens) over area for the one
// direction (a delta when A_lens is a pinhole's).
float Camera::importance(float cos_theta) const {
  const float pixel_area = window_area_ / (width_ * height_);
  if (is_orthographic()) {
    if (is_pinhole()) {
      return 1.0f / pixel_area;
    }
    const float f2 = square(desc_.focus_distance);
    return f2 / (pixel_area * square(square(cos_theta)) * lens_area_);
  }
  return 1.0f / (pixel_area * square(square(cos_theta)) * lens_area_);
}

float Camera::pdf_direction(float cos_theta) const {
  if (cos_theta <= 0.0f) {
    return 0.0f;
  }
  if (is_orthographic()) {
    if (is_pinhole()) {
      return 1.0f;
    }
    return square(desc_.focus_distance) / (window_area_ * cos_theta * square(cos_theta));
  }
  return 1.0f / (window_area_ * cos_theta * square(cos_theta));
}

float Camera::pdf_across(float cos_theta, float distance) const {
  // The rays of one lens point are parallel in an orthographic camera, and cross its window aslant.
  return is_orthographic() ? 1.0f / (window_area_ * cos_theta)
                           : pdf_direction(cos_theta) / square(distance);
}

std::optional<CameraConnection> Camera::connect(Vec3f p, Vec2f u_lens, float margin) const {
  const Vec3f local = frame_.to_local(p - position_);
  const float depth = -local.z;
  if (!(depth > desc_.clip_start) || !(depth < desc_.clip_end)) {
    return std::nullopt;
  }
  CameraConnection c;
  Vec3f lens;
  Vec2f window;
  if (is_orthographic() && is_pinhole()) {
    lens = {local.x, local.y, 0.0f};
    window = {local.x, local.y};
  } else {
    if (!is_pinhole()) {
      const Vec2f l = sample_lens(u_lens);
      lens = {l.x, l.y, 0.0f};
    }
    // Where the line from the lens point crosses the plane in focus (pinhole: the plane z = -1).
    const float focus = is_pinhole() ? 1.0f : desc_.focus_distance;
    const float s = focus / depth;
    window = {lens.x + (local.x - lens.x) * s, lens.y + (local.y - lens.y) * s};
    if (!is_orthographic()) {
      window = window * (1.0f / focus);
    } else {
      // An orthographic lens is centred on its window point w, and its rays by offset o meet in
      // focus behind w: p = w + o (1 - depth/focus).
      window = {local.x + lens.x * (1.0f / s - 1.0f), local.y + lens.y * (1.0f / s - 1.0f)};
      lens = {window.x + lens.x, window.y + lens.y, 0.0f};
    }
  }
  c.raster = window_to_raster(window);
  if (!(c.raster.x >= -margin && c.raster.x < width_ + margin && c.raster.y >= -margin &&
        c.raster.y < height_ + margin)) {
    return std::nullopt;
  }
  c.p_lens = position_ + frame_.to_world(lens);
  const Vec3f d = lens - local;
  c.distance = length(d);
  c.wi = frame_.to_world(d * (1.0f / c.distance));
  const float cos_theta = depth / c.distance;
  c.clip_begin = desc_.clip_start / cos_theta;
  c.clip_end = desc_.clip_end / cos_theta;
  if (is_orthographic() && is_pinhole()) {
    c.pdf = 1.0f;
    c.importance = importance(1.0f);
    return c;
  }
  if (is_orthographic()) {
    // The lens point is p + o depth/focus: this much area per area of the sampled offset o.
    const float jacobian = square(depth / desc_.focus_distance);
    c.pdf = square(c.distance) / (cos_theta * lens_area_ * jacobian);
    c.importance = importance(cos_theta) * cos_theta / square(c.distance) * lens_area_ * jacobian;
    return c;
  }
  if (is_pinhole()) {
    c.pdf = 1.0f;
    c.importance = importance(cos_theta) * cos_theta / square(c.distance);
    return c;
  }
  c.pdf = square(c.distance) / (cos_theta * lens_area_);
  c.importance = importance(cos_theta) / c.pdf;
  return c;
}

// Perspective: the pixel's part of the window, seen from here at an angle with the axis, has the
// solid angle of its area times cos^3, and a disk's radius goes with the root of that. Pixels that
// are wide beside the distance to the window cut what a cone of that slope cuts from a sphere.
float Camera::footprint(Vec3f p) const {
  if (is_orthographic()) {
    return pixel_radius_;
  }
  const Vec3f d = p - position_;
  const float distance = length(d);
  if (!(distance > 0.0f)) {
    return 0.0f;
  }
  const float cosine = std::max(dot(d, axis()) / distance, least_cosine_);
  const float slope = pixel_radius_ * cosine * std::sqrt(cosine);
  // To the last bit what hypot gives, without its call.
  const auto hypotenuse = static_cast<float>(std::sqrt(1.0 + square(static_cast<double>(slope))));
  return distance * (slope / hypotenuse);
}

}  // namespace vernier
