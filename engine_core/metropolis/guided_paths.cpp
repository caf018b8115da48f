#include "metropolis/guided_paths.h"

namespace vernier {

bool GuidedPaths::suits(const Subpath& camera, uint32_t at) {
  if (!rough(camera[at])) {
    return false;
  }
  bool was_rough = true;
  for (uint32_t i = camera[at].parent; i != kNoIndex; i = camera[i].parent) {
    const PathVertex& v = camera[i];
    if (specular(v)) {
      was_rough = false;
    } else if (was_rough || !rough(v)) {
      return false;
    } else {
      was_rough = true;
    }
  }
  return !was_rough;
}

float GuidedPaths::left(const Subpath& camera, const FoundPath& path) const {
  if (path.s != 0 || path.z == nullptr) {
    return 1.0f;
  }
  int surfaces = 0;
  const PathVertex* v = path.z;
  Vec3f wi;
  for (; specular(*v); v = &camera[v->parent]) {
    wi = -v->point.wo;
    if (++surfaces > kMostSpecular || v->parent == kNoIndex) {
      return 1.0f;
    }
  }
  if (surfaces == 0 || !suits(camera, static_cast<uint32_t>(v - camera.data()))) {
    return 1.0f;
  }
  const DirectionLobes lobes = guide_.at(v->point);
  const auto pdf = static_cast<double>(scatter_eval(context_.scene, *v, wi).pdf);
  return lobes.empty() || !(pdf > 0.0)
             ? 1.0f
             : static_cast<float>(1.0 / (1.0 + heuristic_(lobes.pdf(wi) / pdf)));
}

}  // namespace vernier
