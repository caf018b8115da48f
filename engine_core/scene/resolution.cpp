#include "scene/resolution.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace vernier {
namespace {

constexpr double kCoarse = 1.0 / 500.0;

struct Coarseness {
  double step = 0.0;  // between neighbouring coordinates, as a part of the size
  double away = 0.0;  // from the origin, in sizes

  // Of what lies in the box, about `origin`.
  static Coarseness of(const Box& box, const std::array<double, 3>& origin) {
    double size = 0.0, reach = 0.0;
    for (size_t a = 0; a < 3; ++a) {
      size = std::max(size, box.upper[a] - box.lower[a]);
      reach =
          std::max({reach, std::abs(box.upper[a] - origin[a]), std::abs(box.lower[a] - origin[a])});
    }
    if (box.empty() || !(size > 0.0)) {
      return {};  // a point has no shape
    }
    constexpr int kMantissa = 23;  // bits of float32 behind the leading one
    return {std::ldexp(1.0, std::ilogb(reach) - kMantissa) / size, reach / size};
  }
};

std::string sentence(const std::string& what, const char* from, const Coarseness& c) {
  char text[256];
  std::snprintf(text, sizeof text,
                " %.2g times its size away from %s, where 32-bit coordinates are %.2g %% of its "
                "size apart: its shape is rounded to that",
                c.away, from, 100.0 * c.step);
  return what + text;
}

}  // namespace

std::vector<std::string> describe_unresolved(const SceneDescription& desc,
                                             std::span<const Box> meshes,
                                             const std::array<double, 3>& origin) {
  std::vector<std::string> sentences;
  Coarseness worst;
  size_t found = 0;
  for (size_t i = 0; i < meshes.size(); ++i) {
    const Coarseness c = Coarseness::of(meshes[i], {});
    if (c.step > worst.step) {
      worst = c, found = i;
    }
  }
  if (worst.step > kCoarse) {
    sentences.push_back(sentence("mesh \"" + desc.meshes[found].name + "\": its vertices are",
                                 "its origin", worst));
  }

  // Vertices of a mesh that is placed once are moved to render space; those of others stay.
  std::vector<uint32_t> uses(meshes.size(), 0);
  for (const int32_t mesh : desc.instances.mesh) {
    ++uses[static_cast<size_t>(mesh)];
  }
  worst = {};
  for (size_t i = 0; i < desc.instances.mesh.size(); ++i) {
    const auto mesh = static_cast<size_t>(desc.instances.mesh[i]);
    if (uses[mesh] == 1) {
      Box placed;
      placed.add_transformed(meshes[mesh], desc.instances.transform.subspan(12 * i, 12));
      const Coarseness c = Coarseness::of(placed, origin);
      if (c.step > worst.step) {
        worst = c, found = mesh;
      }
    }
  }
  if (worst.step > kCoarse) {
    sentences.push_back(sentence("mesh \"" + desc.meshes[found].name + "\": it is",
                                 "the middle of the scene", worst));
  }
  return sentences;
}

}  // namespace vernier
