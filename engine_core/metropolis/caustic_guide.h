// Directions from which light arrives by way of mirrors and glass alone, as photons tell them.
//
// Where the camera sees a rough surface through glass, and a small light shines on that through
// glass too, a path can be made in one way only: the surface's BSDF must happen to point at the
// light's image, which is as rare as the light is small. Photons that the light has sent tell where
// that is: a direction is drawn near that of one of the nearest (Jensen 1995, "Importance Driven
// Path Tracing using the Photon Map"), with a density that is known. No light is read from photons.
#pragma once

#include <array>
#include <vector>

#include "integrators/integrator.h"
#include "lights/emission_guide.h"
#include "photons/photon.h"
#include "scene/surface_point.h"
#include "spatial/kd_tree.h"

namespace vernier {

// A density of directions at a point: a sum of lobes with heavy tails.
class DirectionLobes {
 public:
  static constexpr size_t kMost = 24;

  bool empty() const { return count_ == 0; }
  // All numbers in [0,1).
  Vec3f sample(float u_lobe, Vec2f u) const;
  // Over solid angle; 0 without lobes.
  double pdf(Vec3f w) const;

  // `axis` unit, `weight` not negative.
  void add(Vec3f axis, float weight);
  // To be called once after the last add(). Each lobe is as wide as it is far to its neighbours.
  void finish();

 private:
  // Arrays of numbers, which are worked on several at a time. What is beyond the lobes weighs
  // nothing.
  std::array<float, kMost> x_{}, y_{}, z_{}, weight_{}, alpha2_{};
  size_t count_ = 0;
};

class CausticGuide {
 public:
  // Knows nothing: all directions are left to BSDFs.
  CausticGuide() = default;
  // By up to `paths` paths from lights; of a few alone, where these make no caustics. The same for
  // any number of threads.
  CausticGuide(const RenderContext& context, const EmissionGuide& guide, uint64_t seed,
               uint32_t paths, RenderStats& stats);

  bool empty() const { return tree_.size() == 0; }
  // Those of the nearest photons on the point's side of surfaces that face about the same way.
  DirectionLobes at(const SurfacePoint& point) const;

 private:
  void trace(const RenderContext& context, const EmissionGuide& guide, uint64_t seed,
             uint32_t first, uint32_t last, std::vector<Vec3f>& positions, RenderStats& stats);

  KdTree tree_;
  std::vector<Photon> photons_;  // in the tree's order
};

}  // namespace vernier
