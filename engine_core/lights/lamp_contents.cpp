#include "lights/lamp_contents.h"

#include <cmath>

#include "math/warp.h"
#include "scene/scene.h"

namespace vernier {
namespace {

constexpr int kMostLamps = 256;
constexpr int kDirections = 64;
constexpr double kGoldenRatio = 1.61803398874989485;

}  // namespace

bool lamps_hold_things(const Scene& scene, std::span<const LightDesc> lamps) {
  int looked_at = 0;
  for (const LightDesc& lamp : lamps) {
    const bool sphere = lamp.kind == LightKind::kPoint || lamp.kind == LightKind::kSpot;
    if (!sphere || lamp.soft_falloff || !(lamp.radius > 0.0f) || looked_at++ >= kMostLamps) {
      continue;
    }
    const Vec3f at = lamp.transform.translation();
    const auto& origin = scene.origin();
    const Vec3f center{static_cast<float>(static_cast<double>(at.x) - origin[0]),
                       static_cast<float>(static_cast<double>(at.y) - origin[1]),
                       static_cast<float>(static_cast<double>(at.z) - origin[2])};
    for (int i = 0; i < kDirections; ++i) {
      // A lattice on the sphere (Swinbank and Purser, "Fibonacci grids", 2006).
      const double turn = i / kGoldenRatio;
      const Vec2f u{(static_cast<float>(i) + 0.5f) / kDirections,
                    static_cast<float>(turn - std::floor(turn))};
      Hit hit;
      if (scene.intersect({center, square_to_uniform_sphere(u), lamp.radius}, kVisibleAll, hit)) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace vernier
