// How chains of whole paths make surfaces, and join them.
#include <algorithm>
#include <limits>

#include "metropolis/chain_path.h"
#include "paths/spawn.h"
#include "paths/visibility.h"

namespace vernier {
namespace {

// The probability that a walk passes a surface of this transparency and goes straight on. Where
// nothing else can happen it goes on nearly always: what lies behind must stay in reach of walks,
// and so must the surface itself, of which transparency does not tell how it scatters.
double pass_probability(Color transparency) {
  constexpr double kMost = 0.98;
  return std::clamp(static_cast<double>(average(transparency)), 0.0, kMost);
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
      light_share_(share_of_frame(c.scene.film)),
      transparent_(c.scene.requirements.transparent_shadows),
      lobes_(static_cast<uint8_t>(transparent_ ? kLobeAny & ~kLobeTransparent : kLobeAny)) {}

void PathSpace::load(const SurfacePoint& point, Transport mode, PathVertex& v) const {
  v.point = point;
  v.mode = mode;
  v.traits = &scene_.materials[point.material]->traits();
  evaluate_bsdf(scene_, v.point, v.bsdf);
}

double PathSpace::log_stop(const SurfacePoint& seen_from_camera) const {
  const Material& material = *scene_.materials[seen_from_camera.material];
  return std::log1p(-pass_probability(material.transparency(seen_from_camera)));
}

// Finds where a ray ends that chance lets through surfaces, by their transparency as the camera's
// side sees them: so the way back has the same chances. Without chance it passes `light`: what of a
// lamp's own triangles is before it. The result's ray_length is the whole way.
bool PathSpace::trace(Ray ray, Transport mode, SurfacePoint& point, Passage& passed,
                      uint32_t light) {
  constexpr int kOfTheLight = 4;
  passed = Passage{};
  float travelled = 0.0f;
  for (int own = 0;;) {
    Hit hit;
    ++stats_.rays;
    if (!scene_.intersect(ray, kVisibleDiffuse, hit)) {
      return false;
    }
    point = scene_.surface_point(ray, hit);
    point.ray_flags = 0;
    point.ray_length = travelled += point.ray_length;
    if (light != kNoIndex && lights_.light_of_triangle(point.instance, point.triangle) == light) {
      if (++own == kOfTheLight) {
        return false;
      }
    } else if (may_pass(point)) {
      const bool radiance = mode == Transport::kRadiance;
      const Color transparency = scene_.materials[point.material]->transparency(
          radiance ? point : seen_from(point, -point.wo));
      const double probability = pass_probability(transparency);
      if (!(static_cast<double>(random()) < probability)) {
        return true;
      }
      passed.transmittance *= transparency;
      passed.log_pdf += std::log(probability);
    } else {
      return true;
    }
    ray = spawn_ray(point, -point.wo);
  }
}

// What a segment from the camera's side passes. False: all is black behind it.
bool PathSpace::see_through(const Ray& segment, Passage& passed) const {
  passed = Passage{};
  ++stats_.rays;
  if (scene_.occluded_by_opaque(segment)) {
    return false;
  }
  if (transparent_) {
    passed.transmittance = pass_surfaces(
        {scene_, std::numeric_limits<int>::max(), stats_.rays}, segment, PathDepth{}, kRayShadow,
        nullptr, [&](const Ray& r, Hit& hit) { return scene_.intersect_transparent(r, hit); },
        [&](Color transparency) { passed.log_pdf += std::log(pass_probability(transparency)); });
  }
  return !is_black(passed.transmittance);
}

Receiver PathSpace::receiver(const SurfacePoint& point) {
  load(point, Transport::kRadiance, scratch_);
  return receiver_of(scene_, scratch_);
}

bool PathSpace::begin_at_lens(Vec2f raster, PathState& path) {
  const CameraRay ray =
      scene_.camera->generate_ray(raster, scene_.camera->is_pinhole() ? Vec2f{} : random_2d());
  ChainVertex v;
  if (!trace(ray.ray, Transport::kRadiance, v.point, v.before)) {
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

bool PathSpace::draw_direction(ChainVertex& v) {
  load(v.point, Transport::kRadiance, scratch_);
  const float u = random();
  const auto sample = scratch_.bsdf.sample_forward(u, random_2d(), scratch_.mode, lobes_);
  if (!sample) {
    return false;
  }
  v.to_light = sample->wi;
  v.event = (sample->lobe & kLobeSingular) != 0 ? sample->lobe : uint8_t{0};
  return true;
}

bool PathSpace::extend(PathState& path) { return draw_direction(path.v.back()) && follow(path); }

bool PathSpace::follow(PathState& path) {
  ChainVertex next;
  const ChainVertex& last = path.v.back();
  if (!trace(spawn_ray(last.point, last.to_light), Transport::kRadiance, next.point, next.before)) {
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
  if (!trace(ray, Transport::kImportance, first.point, end.before) ||
      !(first.point.ray_length > e.lit_from)) {
    return false;
  }
  if (transparent_ && e.behind > 0.0f) {
    // See lit_through() (paths/light_walk.h).
    const Ray to_lamp{e.p, -e.direction, e.behind / first.point.ray_length};
    Passage passed;
    if (!see_through(to_lamp, passed) ||
        !(static_cast<double>(random()) < std::exp(passed.log_pdf))) {
      return false;
    }
  }
  first.to_light = first.point.wo;
  end.light = e.light;
  return true;
}

bool PathSpace::extend_from_light(ChainVertex& from, ChainVertex& next) {
  load(seen_from(from.point, from.to_light), Transport::kImportance, scratch_);
  const float u = random();
  const auto sample = scratch_.bsdf.sample_forward(u, random_2d(), scratch_.mode, lobes_);
  if (!sample) {
    return false;
  }
  from.event = (sample->lobe & kLobeSingular) != 0 ? sample->lobe : uint8_t{0};
  from.point = seen_from(from.point, sample->wi);
  return follow_from_light(from, sample->wi, next);
}

bool PathSpace::follow_from_light(ChainVertex& from, Vec3f direction, ChainVertex& next) {
  if (!trace(spawn_ray(from.point, direction), Transport::kImportance, next.point, from.before)) {
    return false;
  }
  next.to_light = next.point.wo;
  return true;
}

bool PathSpace::trace_from(const Ray& ray, uint32_t light, ChainVertex& first) {
  Passage passed;  // see_light() finds it again
  if (!trace(ray, Transport::kImportance, first.point, passed, light)) {
    return false;
  }
  first.to_light = first.point.wo;
  return true;
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
  return see_between(path, i);
}

bool PathSpace::see_between(PathState& path, size_t i) const {
  const ChainVertex& a = path.v[i];
  ChainVertex& b = path.v[i + 1];
  return see_through(spawn_segment(a.point, b.point, a.to_light), b.before);
}

bool PathSpace::see_to_lens(PathState& path) const {
  ChainVertex& v = path.v.front();
  const Camera& camera = *scene_.camera;
  const float depth = dot(v.point.p - camera.position(), camera.axis());
  const float cosine = -dot(v.point.wo, camera.axis());
  const Vec3f start = v.point.p + v.point.wo * ((depth - camera.desc().clip_start) / cosine);
  return cosine > 0.0f && see_through(spawn_segment(start, v.point, v.point.wo), v.before);
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
  return see_through(spawn_segment(c->p_lens - c->wi * c->clip_begin, v.point, c->wi), v.before);
}

// Traces from the last surface along its to_light, through all that is not opaque: of the lights
// there `wanted` (kNoIndex: any, by chance) becomes the path's end.
bool PathSpace::look(PathState& path, uint32_t wanted) {
  const ChainVertex& last = path.v.back();
  Ray ray = spawn_ray(last.point, last.to_light);
  Passage passed;
  float travelled = 0.0f;
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
      path.end.before = passed;
      chosen = true;
    }
  };
  for (bool further = true; further;) {
    Hit hit;
    ++stats_.rays;
    further = scene_.intersect(ray, kVisibleDiffuse, hit);
    if (further) {
      ray.t_max = hit.t;
    }
    if (lights_.has_lamp_hits(kVisibleDiffuse)) {
      lights_.for_each_lamp_hit(nullptr, ray, kVisibleDiffuse, travelled,
                                [&](const LightHit& lamp) {
                                  take(lamp.light, travelled + lamp.t, -ray.d, lamp.radiance);
                                });
    }
    if (!further) {
      if (lights_.has_escapes(kVisibleDiffuse)) {
        lights_.for_each_escape(
            nullptr, ray.d, kVisibleDiffuse, 0, PathDepth{},
            [&](const LightHit& light) { take(light.light, kInfinity, -ray.d, light.radiance); });
      }
      break;
    }
    SurfacePoint point = scene_.surface_point(ray, hit);
    const Material& material = *scene_.materials[point.material];
    const uint32_t light = lights_.light_of_triangle(hit.instance, hit.triangle);
    point.ray_flags = 0;
    travelled += point.ray_length;
    if (light != kNoIndex) {
      take(light, travelled, point.ng, material.emission(point));
    }
    further = may_pass(point);
    if (further) {
      const Color transparency = material.transparency(point);
      passed.transmittance *= transparency;
      passed.log_pdf += std::log(pass_probability(transparency));
      further = !is_black(passed.transmittance);
      ray = spawn_ray(point, ray.d);
    }
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
  return (!draw || draw_direction(path.v.back())) && look(path, kNoIndex) && see_light(path);
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
    if (!see_through(spawn_shadow_ray(last.point, sample), end.before)) {
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
    end.pdf_emitted /= std::max(square(static_cast<double>(end.distance)), kLeastSquare);
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

}  // namespace vernier
