#include <algorithm>
#include <cmath>
#include <limits>

#include "metropolis/mutators.h"

namespace vernier {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();

// A distance between `least` and `most` whose logarithm is uniform (Veach 1997, section 11.4.3).
float log_uniform(float least, float most, float u) {
  return most * std::exp(-std::log(most / least) * u);
}

// A direction at a small angle to w, symmetric in both.
Vec3f moved(Vec3f w, float angle, float u) {
  const float phi = kTwoPi * u;
  const Vec3f local{std::sin(angle) * std::cos(phi), std::sin(angle) * std::sin(phi),
                    std::cos(angle)};
  return normalize(Frame(w).to_world(local));
}

// Angles of moved directions, radians.
constexpr float kLeastAngle = 1e-4f, kMostAngle = 0.3f;

Vec3f moved(PathSpace& space, Vec3f w) {
  const float angle = log_uniform(kLeastAngle, kMostAngle, space.random());
  return moved(w, angle, space.random());
}

// The number of surfaces from the camera up to the first rough one whose next is rough too, or
// which is the last before the light; all, where there is none.
size_t camera_part(const PathState& path) {
  for (size_t i = 0; i < path.v.size(); ++i) {
    if (path.v[i].matte && (i + 1 == path.v.size() || path.v[i + 1].matte)) {
      return i + 1;
    }
  }
  return path.v.size();
}

// The number of surfaces up to the first rough one after the first.
size_t light_part(const PathState& path) {
  size_t m = 1;
  while (m < path.v.size() && !path.v[m].matte) {
    ++m;
  }
  return m;
}

bool same_events(const PathState& x, const PathState& y, size_t first, size_t end) {
  for (size_t i = first; i < end; ++i) {
    if (x.v[i].event != y.v[i].event || x.v[i].matte != y.v[i].matte) {
      return false;
    }
  }
  return true;
}

double log_cosine(const SurfacePoint& point, Vec3f w) {
  return std::log(static_cast<double>(abs_cosine(point, w)));
}

// What turns the density of a perturbation of the camera's part, symmetric in raster and angles,
// into one over areas, and over what is passed.
double log_camera_areas(const PathSpace& space, const PathState& path, size_t c) {
  double sum = std::log(path.pdf_across);
  for (size_t i = 0; i < c; ++i) {
    const ChainVertex& v = path.v[i];
    sum += log_cosine(v.point, v.point.wo) + v.before.log_pdf + v.log_stop_camera;
    sum -= i > 0 ? space.log_distance2(path, i - 1) : 0.0;
  }
  if (c == path.v.size()) {
    sum += std::log(path.v[c - 1].matte ? path.end.pdf_sampled : path.end.pdf_met);
  }
  return sum;
}

// The same from the light.
double log_light_areas(const PathSpace& space, const PathState& path, size_t m) {
  double sum = 0.0;
  for (size_t i = 0; i < m; ++i) {
    const ChainVertex& v = path.v[i];
    sum += log_cosine(v.point, v.to_light) - v.log_refraction + v.log_stop_light;
    sum += (i + 1 < path.v.size() ? path.v[i + 1].before : path.end.before).log_pdf;
    if (i + 1 < path.v.size()) {
      sum -= space.log_distance2(path, i);
    } else if (space.context.scene.lights->is_point(path.end.light)) {
      sum -= 2.0 * std::log(static_cast<double>(path.end.distance));
    }
  }
  return sum;
}

// A ray of the same light, moved rigidly: turned about the light, or shifted, where the direction
// is fixed or the light is far.
Ray moved_ray(PathSpace& space, const PathState& path) {
  const LightSampler& lights = *space.context.scene.lights;
  const ChainVertex& last = path.v.back();
  const uint32_t light = path.end.light;
  const Vec3f d = -last.to_light;
  const float angle = log_uniform(kLeastAngle, kMostAngle, space.random());
  const bool far = lights.is_infinite(light);
  if (far || (lights.is_delta(light) && !lights.is_point(light))) {
    const float back =
        far ? 2.0f * space.context.scene.radius + length(last.point.p - space.context.scene.center)
            : path.end.distance;
    const float phi = kTwoPi * space.random();
    const float shift = angle * space.context.scene.radius;
    const Frame frame(d);
    const Vec3f across = frame.s * (shift * std::cos(phi)) + frame.t * (shift * std::sin(phi));
    return {last.point.p - d * back + across, d, kInfinity};
  }
  // A rotation by `angle` about an axis that is uniform over the sphere: its inverse is as
  // probable.
  const float z = 1.0f - 2.0f * space.random();
  const float phi = kTwoPi * space.random();
  const float r = safe_sqrt(1.0f - z * z);
  const Vec3f axis{r * std::cos(phi), r * std::sin(phi), z};
  const auto turned = [&](Vec3f v) {
    const float c = std::cos(angle), s = std::sin(angle);
    return v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1.0f - c));
  };
  const Vec3f center = lights.center(light);
  const Vec3f on_light = last.point.p + last.to_light * path.end.distance;
  return {center + turned(on_light - center), normalize(turned(d)), kInfinity};
}

}  // namespace

double perturb_from_camera(PathSpace& space, const PathState& from, PathState& to) {
  const size_t k = from.v.size(), c = camera_part(from);
  const FilmDesc& film = space.context.scene.film;
  const float pixels = static_cast<float>(film.crop[2] - film.crop[0]) *
                       static_cast<float>(film.crop[3] - film.crop[1]);
  // Up to a disk of 5 % of the picture (Veach 1997, section 11.4.3.1).
  const float most = std::max(std::sqrt(0.05f * pixels / kPi), 1.0f);
  const float r = log_uniform(0.1f, most, space.random());
  const float phi = kTwoPi * space.random();
  const Vec2f raster{from.raster.x + r * std::cos(phi), from.raster.y + r * std::sin(phi)};
  to.v.clear();
  to.end = from.end;
  if (!space.film.contains(raster) || !space.begin_at_lens(raster, to)) {
    return kNever;
  }
  const bool met = c == k && !from.v[c - 1].matte;  // the light is at the end of the last chain
  for (size_t i = 0; i + 1 < c || (met && i + 1 == c); ++i) {
    ChainVertex& v = to.v.back();
    v.event = from.v[i].event;
    if (v.event != 0) {
      if (!space.singular_direction(v.point, v.event, v.to_light)) {
        return kNever;
      }
    } else {
      v.to_light = moved(space, from.v[i].to_light);
    }
    if (i + 1 < c && !space.follow(to)) {
      return kNever;
    }
  }
  to.v.insert(to.v.end(), from.v.begin() + static_cast<ptrdiff_t>(c), from.v.end());
  const bool joined =
      c < k ? space.join(to, c - 1) : (met ? space.meet_light(to, false) : space.join_light(to));
  if (!joined || !space.evaluate(to) || camera_part(to) != c || !same_events(from, to, 0, c)) {
    return kNever;
  }
  return to.log_geometry - from.log_geometry + log_camera_areas(space, from, c) -
         log_camera_areas(space, to, c);
}

double perturb_from_light(PathSpace& space, const PathState& from, PathState& to) {
  const size_t k = from.v.size(), m = light_part(from);
  if (!from.v[0].matte) {
    return kNever;
  }
  std::vector<ChainVertex> grown;  // from the light on
  to.end = from.end;
  ChainVertex kept;
  if (m == k) {
    if (!(from.end.pdf_emitted > 0.0)) {
      return kNever;
    }
    const Ray ray = moved_ray(space, from);
    ChainVertex first;
    if (!space.trace_from(ray, from.end.light, first)) {
      return kNever;
    }
    grown.push_back(first);
  } else {
    kept = from.v[m];
    kept.event = 0;
    const Vec3f w = moved(space, kept.point.wo);
    kept.point = seen_from(kept.point, w);
    ChainVertex first;
    if (!space.follow_from_light(kept, w, first)) {
      return kNever;
    }
    grown.push_back(first);
  }
  while (grown.size() < m) {
    const ChainVertex& before = from.v[m - grown.size()];
    ChainVertex& v = grown.back();
    v.event = before.event;
    Vec3f w;
    if (v.event != 0) {
      if (!space.singular_direction(v.point, v.event, w)) {
        return kNever;
      }
    } else {
      w = moved(space, before.point.wo);
    }
    v.point = seen_from(v.point, w);
    ChainVertex next;
    if (!space.follow_from_light(v, w, next)) {
      return kNever;
    }
    grown.push_back(next);
  }
  to.v.assign(grown.rbegin(), grown.rend());
  to.v.insert(to.v.end(), from.v.begin() + static_cast<ptrdiff_t>(m), from.v.end());
  if (m < k) {
    to.v[m] = kept;
  }
  if (!space.join_lens(to) || (m == k && !space.see_light(to)) || !space.evaluate(to) ||
      light_part(to) != m || !same_events(from, to, 0, std::min(m + 1, k))) {
    return kNever;
  }
  if (m == k && !(to.end.pdf_emitted > 0.0)) {
    return kNever;
  }
  return to.log_geometry - from.log_geometry + log_light_areas(space, from, m) -
         log_light_areas(space, to, m);
}

double replace_lens_subpath(PathSpace& space, Vec2f raster, const PathState& from, PathState& to) {
  const auto part = [](const PathState& path) {
    size_t c = 1;
    while (c <= path.v.size() && path.v[c - 1].event != 0) {
      ++c;
    }
    return c;
  };
  // Within a body that lets no light out, mirror follows upon mirror without end. Paths of more
  // surfaces than this are neither proposed nor left: what never goes there need not come back.
  constexpr size_t kMostReplaced = 256;
  const size_t most = std::min(space.most, kMostReplaced);
  const size_t k = from.v.size(), c = part(from);
  if (k > most || c >= k || from.v[c].event != 0) {
    return kNever;
  }
  to.v.clear();
  to.end = from.end;
  if (!space.begin_at_lens(raster, to)) {
    return kNever;
  }
  while (!space.stops(to)) {
    if (to.v.size() + k - c >= most || !space.extend(to)) {
      return kNever;
    }
  }
  const size_t grown = to.v.size();
  to.v.insert(to.v.end(), from.v.begin() + static_cast<ptrdiff_t>(c), from.v.end());
  if (!space.join(to, grown - 1) || !space.evaluate(to) || part(to) != grown) {
    return kNever;
  }
  const auto walked_on = [](const PathState& path, size_t count) {
    return std::none_of(path.v.begin(), path.v.begin() + static_cast<ptrdiff_t>(count - 1),
                        [](const ChainVertex& v) { return v.stops; });
  };
  if (!walked_on(from, c) || !walked_on(to, grown)) {
    return kNever;
  }
  const auto log_density = [&](const PathState& path, size_t count) {
    double sum = 0.0;
    for (size_t i = 0; i < count; ++i) {
      sum += space.log_camera(path, i);
    }
    return sum;
  };
  return to.log_geometry - from.log_geometry + log_density(from, c) - log_density(to, grown);
}

}  // namespace vernier
