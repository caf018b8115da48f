// What a camera path tells the film besides its light: coverage and the passes of first surfaces.
#pragma once

#include "bsdf/bsdf.h"
#include "camera/camera.h"
#include "integrators/camera_loop.h"
#include "integrators/light_passes.h"
#include "scene/scene.h"

namespace vernier {

// Stands for LightPasses where no passes are asked for.
struct NoPasses {
  explicit NoPasses(NoPassSample&) {}
};

// Follows a path while it has met nothing but surfaces that let it straight through.
template <bool kPasses>
class CameraFilm {
 public:
  using Sample = std::conditional_t<kPasses, PassSample, NoPassSample>;

  CameraFilm(const Scene& scene, Sample& sample) : scene_(scene), sample_(sample) {}

  float alpha() const { return std::max(alpha_, 0.0f); }

  // Part of the path that a holdout or the open sky takes from the picture.
  void uncover(Color part) { alpha_ -= average(part); }

  // A surface that the camera sees with throughput `beta`, `distance` from the lens. Colours add up
  // over all of them; the rest is of the first that is opaque enough (Cycles:
  // film_write_data_passes).
  void surface(const SurfacePoint& point, const Bsdf& bsdf, Color beta, float distance) {
    if (!is_black(bsdf.holdout)) {
      uncover(beta * bsdf.holdout);
    }
    if constexpr (kPasses) {
      record(point, bsdf, beta, distance);
    }
  }

 private:
  void record(const SurfacePoint& point, const Bsdf& bsdf, Color beta, float distance) {
    PassSample& s = sample_;
    const Color diffuse = beta * bsdf.albedo(kGroupMasks[kGroupDiffuse]);
    const Color glossy = beta * bsdf.albedo(kGroupMasks[kGroupGlossy]);
    const Color transmission = beta * bsdf.albedo(kGroupMasks[kGroupTransmission]);
    s.diffuse_color += diffuse;
    s.glossy_color += glossy;
    s.transmission_color += transmission;
    s.denoising_albedo += diffuse + glossy + transmission;
    if (recorded_) {
      return;
    }
    // Blender's depth is along the view axis for perspective and orthographic cameras alike.
    s.depth = distance * -dot(point.wo, scene_.camera->axis());
    s.position = scene_.to_world(point.p);
    if (average(bsdf.transparency) <= 1.0f - scene_.film.pass_alpha_threshold) {
      s.normal = s.denoising_normal = bsdf.mean_normal();
      s.uv = scene_.uv(point);
      recorded_ = true;
    }
  }

  const Scene& scene_;
  Sample& sample_;
  float alpha_ = 1.0f;
  bool recorded_ = false;  // the passes of one surface have their values
};

}  // namespace vernier
