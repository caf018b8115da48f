#include "metropolis/chain_path.h"

#include <algorithm>
#include <limits>

#include "paths/spawn.h"
#include "paths/visibility.h"

namespace vernier {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();
// Surfaces whose mean squared roughness is less are as good as mirrors: joined to others they would
// hardly ever scatter there.
constexpr float kSharp = 0.01f;

double log_of(double x) { return x > 0.0 ? std::log(x) : kNever; }
double log_cosine(const SurfacePoint& point, Vec3f w) {
  return std::log(static_cast<double>(abs_cosine(point, w)));
}

size_t most_surfaces(const Settings& settings) {
  return settings.max_bounces < 0 ? std::numeric_limits<size_t>::max()
                                  : static_cast<size_t>(settings.max_bounces) + 1;
}

double share_of_frame(const FilmDesc& film) {
  return static_cast<double>(film.crop[2] - film.crop[0]) *
         static_cast<double>(film.crop[3] - film.crop[1]) /
         (static_cast<double>(film.width) * static_cast<double>(film.height));
}

}  // namespace

PathSpace::PathSpace(const RenderContext& c, RenderStats& stats)
    : context(c),
      plan(static_cast<const MetropolisPlan&>(*c.plan)),
      film(c.scene.film, c.filter),
      least(static_cast<size_t>(least_chain_vertices(c.settings)) - 2),
      most(most_surfaces(c.settings)),
      scene_(c.scene),
      lights_(*c.scene.lights),
      stats_(stats),
      light_share_(share_of_frame(c.scene.film)) {}

void PathSpace::load(const SurfacePoint& point, Transport mode, PathVertex& v) const {
  v.point = point;
  v.mode = mode;
  v.traits = &scene_.materials[point.material]->traits();
  evaluate_bsdf(scene_, v.point, v.bsdf);
}

bool PathSpace::trace(const Ray& ray, SurfacePoint& point) const {
  Hit hit;
  ++stats_.rays;
  if (!scene_.intersect(ray, kVisibleDiffuse, hit)) {
    return false;
  }
  point = scene_.surface_point(ray, hit);
  point.ray_flags = 0;
  return true;
}

Receiver PathSpace::receiver(const SurfacePoint& point) {
  load(point, Transport::kRadiance, scratch_);
  return receiver_of(scene_, scratch_);
}

bool PathSpace::begin_at_lens(Vec2f raster, PathState& path) {
  const CameraRay ray =
      scene_.camera->generate_ray(raster, scene_.camera->is_pinhole() ? Vec2f{} : random_2d());
  ChainVertex v;
  if (!trace(ray.ray, v.point)) {
    return false;
  }
  path.raster = raster;
  path.pdf_across =
      static_cast<double>(scene_.camera->pdf_across(-dot(v.point.wo, scene_.camera->axis()),
                                                    ray.start_distance + v.point.ray_length)) /
      light_share_;
  path.v.push_back(v);
  return true;
}

bool PathSpace::extend(PathState& path) {
  ChainVertex& from = path.v.back();
  load(from.point, Transport::kRadiance, scratch_);
  const float u = random();
  const auto sample = scatter_sample(scene_, scratch_, u, random_2d());
  if (!sample) {
    return false;
  }
  from.to_light = sample->wi;
  from.event = (sample->lobe & kLobeSingular) != 0 ? sample->lobe : uint8_t{0};
  return follow(path);
}

bool PathSpace::follow(PathState& path) const {
  ChainVertex next;
  if (!trace(spawn_ray(path.v.back().point, path.v.back().to_light), next.point)) {
    return false;
  }
  path.v.push_back(next);
  return true;
}

bool PathSpace::singular_direction(const SurfacePoint& point, uint8_t event, Vec3f& wi) {
  load(point, Transport::kRadiance, scratch_);
  std::array<BsdfSample, Bsdf::kMaxSingularEvents> events;
  const int count = scratch_.bsdf.singular_events(events);
  for (int i = 0; i < count; ++i) {
    if (events[static_cast<size_t>(i)].lobe == event) {
      wi = events[static_cast<size_t>(i)].wi;
      return true;
    }
  }
  return false;
}

bool PathSpace::emit(ChainVertex& first, ChainLight& end) {
  EmissionSample e;
  const float u = random();
  const Vec2f u_position = random_2d();
  if (!lights_.sample_emission(plan.guide, u, u_position, random_2d(), e) ||
      !holds_paths(lights_, e.light)) {
    return false;
  }
  const Ray ray{e.infinite ? e.p : offset_origin(e.p, e.p_error, e.n, e.direction), e.direction,
                kInfinity};
  if (!trace(ray, first.point) || !(first.point.ray_length > e.lit_from)) {
    return false;
  }
  first.to_light = first.point.wo;
  end.light = e.light;
  return true;
}

bool PathSpace::extend_from_light(ChainVertex& from, ChainVertex& next) {
  load(seen_from(from.point, from.to_light), Transport::kImportance, scratch_);
  const float u = random();
  const auto sample = scatter_sample(scene_, scratch_, u, random_2d());
  if (!sample) {
    return false;
  }
  from.event = (sample->lobe & kLobeSingular) != 0 ? sample->lobe : uint8_t{0};
  from.point = seen_from(from.point, sample->wi);
  return follow_from_light(from.point, sample->wi, next);
}

bool PathSpace::follow_from_light(const SurfacePoint& from, Vec3f direction,
                                  ChainVertex& next) const {
  if (!trace(spawn_ray(from, direction), next.point)) {
    return false;
  }
  next.to_light = next.point.wo;
  return true;
}

bool PathSpace::trace_from(Ray ray, uint32_t light, ChainVertex& first) const {
  constexpr int kOfTheLight = 4;
  for (int i = 0; i < kOfTheLight; ++i) {
    if (!trace(ray, first.point)) {
      return false;
    }
    if (lights_.light_of_triangle(first.point.instance, first.point.triangle) != light) {
      first.to_light = first.point.wo;
      return true;
    }
    ray = spawn_ray(first.point, ray.d);
  }
  return false;
}

bool PathSpace::stops(const PathState& path) {
  load(path.v.back().point, Transport::kRadiance, scratch_);
  return scratch_.bsdf.connectible();
}

bool PathSpace::join(PathState& path, size_t i) const {
  ChainVertex &a = path.v[i], &b = path.v[i + 1];
  const Vec3f d = b.point.p - a.point.p;
  const float d2 = length_squared(d);
  if (!(d2 > 0.0f)) {
    return false;
  }
  a.to_light = d * (1.0f / std::sqrt(d2));
  a.event = b.event = 0;
  b.point = seen_from(b.point, -a.to_light);
  ++stats_.rays;
  return !scene_.occluded_by_opaque(spawn_segment(a.point, b.point, a.to_light));
}

bool PathSpace::join_lens(PathState& path) {
  ChainVertex& v = path.v.front();
  const Camera& camera = *scene_.camera;
  const auto c = camera.connect(v.point.p, camera.is_pinhole() ? Vec2f{} : random_2d(),
                                context.filter.radius());
  if (!c || !film.contains(c->raster)) {
    return false;
  }
  path.raster = c->raster;
  path.pdf_across =
      static_cast<double>(camera.pdf_across(-dot(c->wi, camera.axis()), c->distance)) /
      light_share_;
  v.event = 0;
  v.point = seen_from(v.point, c->wi);
  ++stats_.rays;
  return !scene_.occluded_by_opaque(
      spawn_segment(c->p_lens - c->wi * c->clip_begin, v.point, c->wi));
}

// Traces from the last surface along its to_light: the lights there, among them `wanted` (kNoIndex:
// any, by chance), becomes the path's end.
bool PathSpace::look(PathState& path, uint32_t wanted) {
  const ChainVertex& last = path.v.back();
  Ray ray = spawn_ray(last.point, last.to_light);
  Hit hit;
  ++stats_.rays;
  const bool found = scene_.intersect(ray, kVisibleDiffuse, hit);
  if (found) {
    ray.t_max = hit.t;
  }
  int count = 0;
  bool chosen = false;
  const auto take = [&](uint32_t light, float distance, Vec3f n, Color radiance) {
    if (light == kNoIndex || !holds_paths(lights_, light)) {
      return;
    }
    ++count;
    // Of several each is chosen with the same probability.
    if (wanted == kNoIndex ? !(random() * static_cast<float>(count) >= 1.0f) : light == wanted) {
      path.end.light = light;
      path.end.distance = distance;
      path.end.n = n;
      path.end.radiance = radiance;
      chosen = true;
    }
  };
  if (lights_.has_lamp_hits(kVisibleDiffuse)) {
    lights_.for_each_lamp_hit(nullptr, ray, kVisibleDiffuse, 0.0f, [&](const LightHit& lamp) {
      take(lamp.light, lamp.t, -ray.d, lamp.radiance);
    });
  }
  if (found) {
    SurfacePoint point = scene_.surface_point(ray, hit);
    const uint32_t light = lights_.light_of_triangle(hit.instance, hit.triangle);
    if (light != kNoIndex) {
      point.ray_flags = 0;
      take(light, point.ray_length, point.ng, scene_.materials[point.material]->emission(point));
    }
  } else if (lights_.has_escapes(kVisibleDiffuse)) {
    lights_.for_each_escape(
        nullptr, ray.d, kVisibleDiffuse, 0, PathDepth{},
        [&](const LightHit& light) { take(light.light, kInfinity, -ray.d, light.radiance); });
  }
  path.end.pdf_met = chosen ? 1.0 / count : 0.0;
  return chosen && !is_black(path.end.radiance);
}

bool PathSpace::join_light(PathState& path) {
  ChainVertex& last = path.v.back();
  LightSample light;
  const float u = random();
  if (!lights_.sample(receiver(last.point), u, random_2d(), light) ||
      !holds_paths(lights_, light.light)) {
    return false;
  }
  last.to_light = light.wi;
  last.event = 0;
  path.end.light = light.light;
  return see_light(path);
}

bool PathSpace::meet_light(PathState& path, bool draw) {
  ChainVertex& last = path.v.back();
  if (draw) {
    load(last.point, Transport::kRadiance, scratch_);
    const float u = random();
    const auto sample = scatter_sample(scene_, scratch_, u, random_2d());
    if (!sample) {
      return false;
    }
    last.to_light = sample->wi;
    last.event = (sample->lobe & kLobeSingular) != 0 ? sample->lobe : uint8_t{0};
  }
  return look(path, kNoIndex) && see_light(path);
}

bool PathSpace::see_light(PathState& path) {
  ChainVertex& last = path.v.back();
  ChainLight& end = path.end;
  const Receiver from = receiver(last.point);
  if (lights_.is_delta(end.light)) {
    LightSample sample;
    if (!lights_.sample_light(from, end.light, {0.5f, 0.5f}, sample)) {
      return false;
    }
    last.to_light = sample.wi;
    end.distance = sample.distance;
    end.n = sample.n;
    end.radiance = sample.radiance;
    end.pdf_met = 0.0;
    end.pdf_sampled = static_cast<double>(lights_.pdf_selection(from, end.light));
    ++stats_.rays;
    if (scene_.occluded_by_opaque(spawn_shadow_ray(last.point, sample))) {
      return false;
    }
  } else {
    if (!look(path, end.light)) {
      return false;
    }
    end.pdf_sampled =
        static_cast<double>(lights_.pdf_light(from, end.light, last.to_light, end.distance, end.n));
  }
  end.pdf_emitted = static_cast<double>(
      lights_.pdf_emission_ray(plan.guide, end.light, last.point.p, -last.to_light));
  if (lights_.is_point(end.light)) {
    end.pdf_emitted /= std::max(
        static_cast<double>(end.distance) * static_cast<double>(end.distance), kLeastSquare);
  }
  return true;
}

bool PathSpace::see_lens(Vec2f raster, PathState& path) const {
  const Camera& camera = *scene_.camera;
  const SurfacePoint& point = path.v.front().point;
  const float cos_lens = -dot(point.wo, camera.axis());
  const float depth = dot(point.p - camera.position(), camera.axis());
  path.raster = raster;
  path.pdf_across =
      static_cast<double>(camera.pdf_across(cos_lens, depth / cos_lens)) / light_share_;
  return cos_lens > 0.0f;
}

uint8_t PathSpace::event_toward(const SurfacePoint& point, Vec3f wi) {
  load(point, Transport::kRadiance, scratch_);
  for (const uint8_t side : {kLobeReflection, kLobeTransmission}) {
    const auto event = static_cast<uint8_t>(kLobeGlossy | kLobeSingular | side);
    // Smooth scattering meets a mirror's direction by a chance of 1e-6.
    if (scratch_.bsdf.singular_toward(wi, event)) {
      return event;
    }
  }
  return 0;
}

void PathSpace::evaluate(ChainVertex& v) {
  load(v.point, Transport::kRadiance, scratch_);
  v.log_refraction = 0.0;
  v.stops = scratch_.bsdf.connectible();
  if (v.event == 0) {
    const BsdfEval eval = scatter_eval(scene_, scratch_, v.to_light);
    v.f = eval.f;
    v.pdf_to_light = static_cast<double>(eval.pdf);
    v.pdf_to_camera = static_cast<double>(eval.pdf_reverse);
    v.matte = scratch_.bsdf.connectible() && scratch_.bsdf.mean_squared_roughness() > kSharp;
    return;
  }
  v.matte = false;
  v.f = {};
  const auto event = scratch_.bsdf.singular_toward(v.to_light, v.event);
  if (!event) {
    return;  // by rounding
  }
  const float eta = event->eta;
  v.f = event->weight;
  v.pdf_to_light = static_cast<double>(event->pdf);
  const Vec3f wo = v.point.wo;
  load(seen_from(v.point, v.to_light), Transport::kImportance, scratch_);
  const auto back = scratch_.bsdf.singular_toward(wo, v.event);
  v.pdf_to_camera = back ? static_cast<double>(back->pdf) : 0.0;
  if (eta != 1.0f) {
    // Of the delta distribution's change of variables (Veach 1997, sections 5.2 and 5.3) what the
    // cosines at ng leave: the cosines at the facet and the squared indices.
    const Vec3f facet = wo + v.to_light * eta;
    v.log_refraction = std::log(
        static_cast<double>(std::abs(dot(facet, v.to_light) / dot(facet, wo)) * square(eta)));
  }
}

double PathSpace::log_distance2(const PathState& path, size_t i) const {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = static_cast<double>(path.v[i + 1].point.p[axis]) -
                     static_cast<double>(path.v[i].point.p[axis]);
    sum += d * d;
  }
  return std::log(std::max(sum, kLeastSquare));
}

bool PathSpace::evaluate(PathState& path) {
  path.clear();
  path.independent_target = static_cast<double>(kInfinity);
  if (path.v.size() < least || path.v.size() > most) {
    return false;
  }
  Color color = path.end.radiance;
  path.log_geometry = log_of(path.pdf_across) + log_cosine(path.v[0].point, path.v[0].point.wo);
  for (size_t i = 0; i < path.v.size(); ++i) {
    ChainVertex& v = path.v[i];
    evaluate(v);
    color *= v.f;
    if (i > 0) {
      path.log_geometry += log_cosine(v.point, v.point.wo) - log_distance2(path, i - 1);
    }
  }
  if (is_black(color) || !std::isfinite(path.log_geometry)) {
    return false;
  }
  if (!is_finite(color)) {
    ++stats_.non_finite;
    return false;
  }
  path.add(path.raster, color, plan.worth(path.raster), 0, 0);
  return path.target > 0.0;
}

double PathSpace::log_camera(const PathState& path, size_t i) const {
  const SurfacePoint& point = path.v[i].point;
  if (i == 0) {
    return log_of(path.pdf_across) + log_cosine(point, point.wo) - std::log(film.share());
  }
  return log_of(path.v[i - 1].pdf_to_light) + log_cosine(point, point.wo) -
         log_distance2(path, i - 1);
}

double PathSpace::log_light(const PathState& path, size_t i) const {
  const ChainVertex& v = path.v[i];
  const double cosine = log_cosine(v.point, v.to_light) - v.log_refraction;
  if (i + 1 == path.v.size()) {
    return log_of(path.end.pdf_emitted) + cosine;
  }
  return log_of(path.v[i + 1].pdf_to_camera) + cosine - log_distance2(path, i);
}

double PathSpace::log_grown(const PathState& path, size_t a, size_t b) const {
  const size_t k = path.v.size(), c = k - a - b;
  // Vertices from the light: surfaces and, where none is kept, the light itself; s = 0 meets it.
  const size_t techniques = b > 0 ? c + 1 : c + 2;
  double sum = 0.0, largest = kNever;
  const auto add = [&](double log) {
    if (log > largest) {
      sum = sum * std::exp(largest - log) + 1.0;
      largest = log;
    } else if (log > kNever) {
      sum += std::exp(log - largest);
    }
  };
  double camera = 0.0;  // of the surfaces before i
  std::vector<double>& light = scratch_logs_;
  light.assign(c + 1, 0.0);  // of the surfaces from a + i on
  for (size_t i = c; i-- > 0;) {
    light[i] = light[i + 1] + log_light(path, a + i);
  }
  for (size_t i = 0; i <= c; ++i) {
    // The first a + i from the camera.
    const size_t at = a + i;
    const bool from_camera = at == 0 || path.v[at - 1].event == 0;
    if (at < k) {
      if (from_camera && path.v[at].event == 0) {
        add(camera + light[i]);
      }
      camera += i < c ? log_camera(path, at) : 0.0;
    } else {
      if (at > 0 && from_camera) {
        add(camera + log_of(path.end.pdf_sampled));
      }
      if (at > 0) {
        add(camera + log_of(path.v[at - 1].pdf_to_light) + log_of(path.end.pdf_met));
      }
    }
  }
  return largest == kNever ? kNever
                           : largest + std::log(sum) - std::log(static_cast<double>(techniques));
}

}  // namespace vernier
