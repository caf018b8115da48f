// The camera: rays from raster positions, and the importance it emits into the scene.
#pragma once

#include <optional>

#include "embree/intersector.h"
#include "math/frame.h"
#include "math/transform.h"
#include "math/vec.h"
#include "scene/description.h"

namespace vernier {

// A ray that leaves the camera. Raster positions are in pixels, y upward, from the lower left.
struct CameraRay {
  Ray ray;                   // starts on the near clip plane, unit direction, ends on the far one
  float start_distance = 0;  // from the lens point to the ray's origin
};

// The camera seen from a point of the scene.
struct CameraConnection {
  Vec3f p_lens;  // point on the aperture
  Vec3f wi;      // unit, from the point to p_lens
  float distance = 0;
  Vec2f raster;
  float importance = 0;  // We / pdf: pixel-filter-free, per pixel area (see Camera::importance)
  float pdf = 0;         // solid angle at the point; pinhole: 1, a delta distribution
  float clip_begin = 0, clip_end = 0;  // part of the way from p_lens that is not clipped away
};

class Camera {
 public:
  // `origin` is the world position of render space's origin. Values are valid: see validation.
  Camera(const CameraDesc& desc, const FilmDesc& film, const double origin[3]);

  // `u_lens` is uniform in the unit square.
  CameraRay generate_ray(Vec2f raster, Vec2f u_lens) const;

  // Importance emitted along a ray, normalised so that the integral of We over aperture and
  // directions of one pixel is 1: a pixel's value is the integral of We L.
  // `cos_theta` is the cosine between the ray and the view axis.
  float importance(float cos_theta) const;
  // Densities with which generate_ray() makes the ray when raster is uniform over the full frame.
  float pdf_area() const { return 1.0f / lens_area_; }  // of the lens point; pinhole: delta, 1
  float pdf_direction(float cos_theta) const;           // solid angle
  // Density of the ray's point at `distance`, over area across the ray, given its lens point.
  float pdf_across(float cos_theta, float distance) const;

  // Samples a lens point as seen from `p`; empty where p is behind the camera, or more than
  // `margin` pixels out of the full frame.
  std::optional<CameraConnection> connect(Vec3f p, Vec2f u_lens, float margin = 0.0f) const;

  const CameraDesc& desc() const { return desc_; }
  bool is_pinhole() const { return desc_.aperture_radius == 0.0f; }
  bool is_orthographic() const { return desc_.kind == CameraKind::kOrthographic; }
  Vec3f position() const { return position_; }
  Vec3f axis() const { return -frame_.n; }
  Vec3f to_camera(Vec3f v) const { return frame_.to_local(v); }
  Vec3f from_camera(Vec3f v) const { return frame_.to_world(v); }
  // Radius of the disk that one pixel covers at p, across the ray to it, metres: at most the
  // distance. Out of the picture it is as in the corner farthest from the axis.
  float footprint(Vec3f p) const;

 private:
  Vec2f sample_lens(Vec2f u) const;  // metres on the lens plane
  Vec2f raster_to_window(Vec2f raster) const;
  Vec2f window_to_raster(Vec2f window) const;

  CameraDesc desc_;
  Frame frame_;  // s: right, t: up, n: backward
  Vec3f position_;
  float width_, height_;
  float window_area_;
  float lens_area_;     // 1 for a pinhole
  float pixel_radius_;  // at the picture's centre, perspective: at distance 1
  float least_cosine_;  // of a ray with the view axis: at the farthest corner
};

}  // namespace vernier
