#include "paths/technique_pdfs.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vernier {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();

double log_of(double x) { return x > 0.0 ? std::log(x) : kNever; }

// |cos| as paths/path_vertex.h bounds it.
double cosine(const PathSurface& v, Vec3f w) {
  return std::max(std::abs(static_cast<double>(dot(v.ng, w))), static_cast<double>(kUnitRoundoff));
}

// From one surface to the next.
struct Edge {
  Vec3f direction;
  double distance;

  Edge(Vec3f from, Vec3f to) {
    double d[3], sum = 0.0;
    for (int i = 0; i < 3; ++i) {
      d[i] = static_cast<double>(to[i]) - static_cast<double>(from[i]);
      sum += d[i] * d[i];
    }
    distance = std::sqrt(std::max(sum, kLeastSquare));
    for (int i = 0; i < 3; ++i) {
      direction[i] = static_cast<float>(d[i] / distance);
    }
  }
};

// Which techniques can make the path: what lies between the ends decides it.
struct Possible {
  const Path& path;
  size_t count;                   // surfaces
  std::vector<char> light_makes;  // the light's walk can make surface i and all beyond

  explicit Possible(const Path& p) : path(p), count(p.surfaces.size()), light_makes(count + 1) {
    light_makes[count] = p.light.pdf_emitted > 0.0 && p.light.light_crosses;
    for (size_t i = count; i-- > 0;) {
      const bool edge = i + 1 == count || p.surfaces[i + 1].light_crosses;
      light_makes[i] = light_makes[i + 1] && edge && p.surfaces[i].light_reaches;
    }
  }

  bool operator()(size_t s) const {
    const size_t t = path.length() - s;
    if (count == 0) {
      return s == 0;
    }
    if (s == 0) {
      return path.light.hittable;
    }
    if (!path.joins) {
      return false;
    }
    if (s == 1) {
      return !path.surfaces[count - 1].singular;
    }
    const PathSurface& y = path.surfaces[t - 1];
    return light_makes[t - 1] && !y.singular && y.light_crosses &&
           (t > 1 ? !path.surfaces[t - 2].singular : y.camera_sees);
  }

  // Whether sub-paths may be merged at a surface.
  bool merge(size_t surface) const {
    const PathSurface& v = path.surfaces[surface];
    return path.merges && v.merge_area > 0.0 && !v.singular && light_makes[surface];
  }
};

}  // namespace

SurfacePdfs surface_pdfs(const Path& path) {
  const std::vector<PathSurface>& v = path.surfaces;
  const size_t count = v.size();
  SurfacePdfs pdfs{std::vector<double>(count), std::vector<double>(count)};
  if (count == 0) {
    return pdfs;
  }
  pdfs.log_camera[0] =
      log_of(path.camera.pdf_across) + std::log(cosine(v[0], path.camera.direction));
  pdfs.log_light[count - 1] =
      log_of(path.light.pdf_emitted) + std::log(cosine(v[count - 1], path.light.direction));
  for (size_t i = 0; i + 1 < count; ++i) {
    const Edge edge(v[i].p, v[i + 1].p);
    const double log_d2 = 2.0 * std::log(edge.distance);
    pdfs.log_camera[i + 1] =
        log_of(v[i].pdf_to_light) + std::log(cosine(v[i + 1], edge.direction)) - log_d2;
    pdfs.log_light[i] =
        log_of(v[i + 1].pdf_to_camera) + std::log(cosine(v[i], edge.direction)) - log_d2;
  }
  return pdfs;
}

std::vector<double> technique_log_pdfs(const Path& path) {
  const size_t n = path.length(), count = path.surfaces.size();
  const SurfacePdfs pdfs = surface_pdfs(path);
  const Possible possible(path);
  std::vector<double> camera(count + 1), light(count + 1);  // products over parts of the path
  for (size_t i = 0; i < count; ++i) {
    camera[i + 1] = camera[i] + pdfs.log_camera[i];
  }
  for (size_t i = count; i-- > 0;) {
    light[i] = light[i + 1] + pdfs.log_light[i];
  }
  std::vector<double> result(n, kNever);
  for (size_t s = 0; s < n; ++s) {
    if (!possible(s)) {
      continue;
    }
    const size_t from_camera = std::min(n - s - 1, count);  // surfaces
    result[s] = camera[from_camera] + light[from_camera];
    if (s == 0 && count > 0) {
      result[s] += log_of(path.surfaces[count - 1].pdf_to_light);
    } else if (s == 1) {
      result[s] += log_of(path.light.pdf_sampled);
    } else if (s > 1 && s + 1 < n) {
      result[s] += std::log(path.surfaces[from_camera].joins);
    }
  }
  for (size_t i = 0; path.merges && i < count; ++i) {
    result.push_back(possible.merge(i)
                         ? camera[i + 1] + light[i] + std::log(path.surfaces[i].merge_area)
                         : kNever);
  }
  return result;
}

std::vector<double> technique_weights(const std::vector<double>& log_pdfs, bool power) {
  std::vector<double> weights(log_pdfs.size());
  const double largest = *std::max_element(log_pdfs.begin(), log_pdfs.end());
  if (largest == kNever) {
    return weights;
  }
  double sum = 0.0;
  for (size_t s = 0; s < weights.size(); ++s) {
    weights[s] = std::exp((power ? 2.0 : 1.0) * (log_pdfs[s] - largest));
    sum += weights[s];
  }
  for (double& w : weights) {
    w /= sum;
  }
  return weights;
}

std::vector<double> recursive_weights(const Path& path, const MisHeuristic& h) {
  const std::vector<PathSurface>& v = path.surfaces;
  const size_t n = path.length(), count = v.size();
  std::vector<double> weights(n + (path.merges ? count : 0));
  if (count == 0) {
    weights[0] = 1.0;
    return weights;
  }
  const Possible possible(path);
  const LightEnd& end = path.light;
  const PathSurface& last = v[count - 1];
  const double last_cosine = cosine(last, end.direction);
  const double emitted = end.light_crosses ? end.pdf_emitted * last_cosine : 0.0;

  std::vector<MisState> camera(count), light(count);
  MisDeparture to_light;  // from the last surface
  camera[0].pdf = path.camera.pdf_across * cosine(v[0], path.camera.direction);
  camera[0].neighbour = path.joins && v[0].light_crosses && v[0].camera_sees ? 1.0 : 0.0;
  for (size_t i = 0; i < count; ++i) {
    if (path.merges && v[i].light_reaches) {
      camera[i].merges(h, v[i].merge_area);
    }
    const Edge edge(v[i].p, i + 1 < count ? v[i + 1].p : v[i].p);
    const double leaves = i + 1 < count ? cosine(v[i], edge.direction) : last_cosine;
    const MisDeparture d(h, camera[i], v[i].pdf_to_light, v[i].pdf_to_camera, leaves, v[i].singular,
                         v[i].light_reaches);
    if (i + 1 < count) {
      camera[i + 1] = d.arrive(h, edge.distance, cosine(v[i + 1], edge.direction),
                               v[i + 1].light_crosses, v[i + 1].joins);
    } else {
      to_light = d;
    }
  }
  light[count - 1].pdf = emitted;
  light[count - 1].neighbour = path.joins ? h(end.pdf_sampled) : 0.0;
  light[count - 1].chain = end.hittable ? 1.0 : 0.0;
  if (path.merges) {
    light[count - 1].merges(h, last.merge_area);
  }
  for (size_t i = count - 1; i > 0; --i) {
    const Edge edge(v[i].p, v[i - 1].p);
    const MisDeparture d(h, light[i], v[i].pdf_to_camera, v[i].pdf_to_light,
                         cosine(v[i], edge.direction), v[i].singular, true);
    light[i - 1] = d.arrive(h, edge.distance, cosine(v[i - 1], edge.direction), true, v[i].joins);
    if (path.merges) {
      light[i - 1].merges(h, v[i - 1].merge_area);
    }
  }

  const SurfacePdfs pdfs = surface_pdfs(path);
  // The techniques with fewer vertices from the camera, where the light makes surface i too.
  const auto before = [&](size_t i, double by_light) {
    return v[i].light_reaches ? camera[i].sum(h, by_light, v[i].pdf_to_camera) : 0.0;
  };
  for (size_t s = 0; s < n; ++s) {
    if (!possible(s)) {
      continue;
    }
    const size_t t = n - s;
    double others = 0.0;
    if (s == 0) {
      const double sampled = last.singular || !path.joins ? 0.0 : end.pdf_sampled;
      others = h(sampled / to_light.pdf) + bounded_product(h(emitted / to_light.pdf), to_light.sum);
    } else if (s == 1) {
      others = (end.hittable ? h(last.pdf_to_light / end.pdf_sampled) : 0.0) +
               (emitted > 0.0 ? before(count - 1, emitted / end.pdf_sampled) : 0.0);
    } else {
      others = light[t - 1].sum(h, std::exp(pdfs.log_camera[t - 1]), v[t - 1].pdf_to_light) +
               (t > 1 ? before(t - 2, std::exp(pdfs.log_light[t - 2])) : 0.0);
      others /= t > 1 ? h(v[t - 1].joins) : 1.0;
    }
    weights[s] = 1.0 / (1.0 + others);
  }
  for (size_t i = 0; path.merges && i < count; ++i) {
    if (possible.merge(i) && camera[i].merge > 0.0 && light[i].merge > 0.0) {
      const double others = camera[i].beside_merge().sum(h, v[i].pdf_to_camera) +
                            light[i].beside_merge().sum(h, v[i].pdf_to_light);
      weights[n + i] = 1.0 / (1.0 + others);
    }
  }
  return weights;
}

}  // namespace vernier
