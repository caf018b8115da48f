#include "bidirectional/path_verifier.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>

#include "camera/camera.h"
#include "lights/light_sampler.h"
#include "paths/bounce_limits.h"
#include "paths/light_walk.h"
#include "paths/visibility.h"

namespace vernier {
namespace {

// Cosines below this are mostly rounding.
constexpr float kGrazing = 1e-5f;
// Normals whose cosine is this close to 1 are one, but for rounding.
constexpr float kFlat = 1e-6f;

double share_of_frame(const FilmDesc& film) {
  return static_cast<double>(film.crop[2] - film.crop[0]) *
         static_cast<double>(film.crop[3] - film.crop[1]) /
         (static_cast<double>(film.width) * static_cast<double>(film.height));
}

double largest(Color c) { return static_cast<double>(max_component(c)); }

bool same(Vec3f a, Vec3f b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

// Finds the vertex at p of a path from a light.
struct VertexFinder {
  const Subpath& path;
  Vec3f p;
  int bounces;
  uint32_t light = kNoIndex;
  uint32_t number = kNoIndex;

  void emitted(const EmissionSample& e) { light = e.light; }
  void reached(const Walk& walk, const PathVertex& v) {
    if (walk.depth.total == bounces && same(v.point.p, p)) {
      number = static_cast<uint32_t>(&v - path.data());
    }
  }
};

}  // namespace

// A surface of the path, as the walk made it and as it is seen anew.
struct PathVerifier::Vertex {
  const PathVertex* made = nullptr;
  bool by_camera = true;
  Vec3f to_camera, to_light;             // unit
  SurfacePoint near_camera, near_light;  // the same place, as either side meets it
  Bsdf from_camera, from_light;
  Color f;  // by the camera's side; singular: over the delta distribution
  BsdfEval camera_eval, light_eval;
  bool singular = false;
  double pdf_to_light = 0, pdf_to_camera = 0;
  double refraction = 1;  // importance's ratio at a delta over that of reflection
};

// The light, as the last surface meets it.
struct PathVerifier::End {
  Color radiance;
  Vec3f n;
  float distance = kInfinity;
  bool restricted = false;  // the light reaches some lobes only
};

PathVerifier::PathVerifier(const Scene& scene, const Settings& settings, const EmissionGuide& guide,
                           const BidirectionalMemory& memory, double tolerance,
                           const LightVertices* merged_with, const JoinGuide* joins,
                           double own_paths)
    : scene_(scene),
      techniques_(settings, scene.requirements),
      heuristic_(techniques_.heuristic(settings)),
      power_(static_cast<MisExponent>(settings.mis_heuristic) == MisExponent::kPower),
      guide_(guide),
      memory_(memory),
      tolerance_(tolerance),
      light_share_(own_paths * share_of_frame(scene.film)),
      settings_(settings),
      merged_with_(merged_with),
      joins_(joins),
      own_paths_(own_paths) {}

// Meets the vertex anew from both sides.
void PathVerifier::see(Vertex& v, bool scatters_by_chance) const {
  const SurfacePoint& made = v.made->point;
  const auto meet = [&](Vec3f w) {
    const float distance = made.ray_length;
    SurfacePoint point =
        scene_.surface_point(Ray{made.p + w * distance, -w, kInfinity},
                             Hit{distance, made.u, made.v, made.instance, made.triangle});
    point.wo = w;
    point.ray_length = distance;
    point.ray_flags = made.ray_flags;
    point.depth = made.depth;
    return point;
  };
  v.near_camera = meet(v.to_camera);
  v.near_light = meet(v.to_light);
  evaluate_bsdf(scene_, v.near_camera, v.from_camera);
  evaluate_bsdf(scene_, v.near_light, v.from_light);
  v.camera_eval = v.from_camera.eval(v.to_light, Transport::kRadiance);
  v.light_eval = v.from_light.eval(v.to_camera, Transport::kImportance);
  v.f = v.camera_eval.f;
  v.pdf_to_light = static_cast<double>(v.camera_eval.pdf);
  v.pdf_to_camera = static_cast<double>(v.light_eval.pdf);
  if (!scatters_by_chance) {
    return;
  }
  for (const uint8_t side : {kLobeReflection, kLobeTransmission}) {
    const auto lobe = static_cast<uint8_t>(kLobeGlossy | kLobeSingular | side);
    const auto event = v.from_camera.singular_toward(v.to_light, lobe);
    if (!event) {
      continue;  // smooth scattering meets a mirror's direction by a chance of 1e-6
    }
    const auto back = v.from_light.singular_toward(v.to_camera, lobe);
    v.singular = true;
    v.f = event->weight;
    v.pdf_to_light = static_cast<double>(event->pdf);
    v.pdf_to_camera = back ? static_cast<double>(back->pdf) : 0.0;
    // Of the delta distribution's change of variables (Veach 1997, sections 5.2 and 5.3) what the
    // cosines at ng leave: the cosines at the facet and the squared indices.
    if (event->eta != 1.0f) {
      const Vec3f facet = v.to_camera + v.to_light * event->eta;
      v.refraction = static_cast<double>(
          std::abs(dot(facet, v.to_light) / dot(facet, v.to_camera)) * square(event->eta));
    }
  }
}

// Makes the light's sub-path of a merge again. The merge is told its light, and what comes before
// the vertex that was merged; that vertex is returned, or null.
const PathVertex* PathVerifier::trace_again(FoundPath& merge) {
  const std::atomic<bool> cancelled{false};
  const SobolSampler numbers = merged_with_->sampler(merge.light_path);
  uint64_t rays = 0, non_finite = 0;
  light_again_.clear();
  VertexFinder finder{light_again_, merge.light_end, merge.s - 2};
  walk_from_light(
      {scene_, guide_, heuristic_, merged_with_->area()},
      WalkContext<SobolSampler>{scene_, numbers, cancelled, BounceLimits::of_both_sides(settings_),
                                Roulette(settings_), rays},
      light_again_, non_finite, finder);
  if (finder.number == kNoIndex) {
    return nullptr;
  }
  const PathVertex& end = light_again_[finder.number];
  merge.light = finder.light;
  merge.y_path = light_again_.data();
  merge.y = end.parent == kNoIndex ? nullptr : light_again_.data() + end.parent;
  return &end;
}

std::vector<PathVerifier::Vertex> PathVerifier::vertices_of(const FoundPath& found) const {
  std::vector<Vertex> vertices;
  const auto follow = [&](const PathVertex* path, const PathVertex* v, bool by_camera) {
    for (;; v = path + v->parent) {
      vertices.emplace_back();
      vertices.back().made = v;
      vertices.back().by_camera = by_camera;
      if (v->parent == kNoIndex) {
        return;
      }
    }
  };
  if (found.z != nullptr) {
    follow(memory_.camera.data(), found.z, true);
    std::reverse(vertices.begin(), vertices.end());
  }
  const size_t from_camera = vertices.size();
  if (found.y != nullptr) {
    follow(found.y_path, found.y, false);
  }
  for (size_t i = 0; i < vertices.size(); ++i) {
    Vertex& v = vertices[i];
    if (v.by_camera) {
      v.to_light = i + 1 < from_camera ? -vertices[i + 1].made->point.wo : found.wi;
      v.to_camera = v.made->point.wo;
    } else {
      v.to_light = v.made->point.wo;
      v.to_camera = i > from_camera ? -vertices[i - 1].made->point.wo
                                    : (from_camera > 0 ? -found.wi : found.wi);
    }
    const bool joined =
        v.by_camera ? found.s > 0 && i + 1 == from_camera : i == from_camera && !found.merged;
    see(v, !joined);
  }
  return vertices;
}

Receiver PathVerifier::receiver_at(const Vertex& v) const {
  const uint8_t lobes = lobes_of_both_sides(scene_, v.near_camera, v.from_camera);
  return {v.near_camera, (lobes & kLobeTransmission) != 0};
}

bool PathVerifier::meet_light(const FoundPath& found, const Vertex& last, End& end) const {
  const LightSampler& lights = *scene_.lights;
  const Receiver from = receiver_at(last);
  const Vec3f d = last.to_light;
  const uint32_t light = found.light;
  if (lights.is_delta(light)) {
    LightSample sample;
    if (!lights.sample_light(from, light, {0.5f, 0.5f}, sample)) {
      return false;
    }
    end = {sample.radiance, sample.n, sample.distance, lobes_lit(sample.visibility) != kLobeAny};
    return true;
  }
  bool met = false;
  const auto take = [&](const LightHit& hit) {
    if (hit.light == light) {
      met = true;
      end.radiance = hit.radiance;
      end.distance = hit.t;
    }
  };
  LightSample sample;
  if (lights.is_infinite(light)) {
    lights.for_each_escape(nullptr, d, kVisibleAll, 0, PathDepth{}, take);
    end.n = -d;
    end.restricted = lights.sample_light(from, light, {0.5f, 0.5f}, sample) &&
                     lobes_lit(sample.visibility) != kLobeAny;
    return met;
  }
  // A surface: what lies before it lets light through.
  Ray ray{offset_origin(from.p, last.near_camera.p_error, from.ng, d), d, kInfinity};
  Hit hit;
  float travelled = 0.0f;
  for (int i = 0; i < 64 && scene_.intersect(ray, kVisibleDiffuse, hit); ++i) {
    SurfacePoint point = scene_.surface_point(ray, hit);
    travelled += point.ray_length;
    if (lights.light_of_triangle(hit.instance, hit.triangle) == light) {
      point.ray_flags = 0;
      point.depth = PathDepth{};
      end.radiance = scene_.materials[point.material]->emission(point);
      end.n = point.ng;
      end.distance = travelled;
      return true;
    }
    ray.o = offset_origin(point.p, point.p_error, point.ng, d);
  }
  lights.for_each_lamp_hit(nullptr, Ray{from.p, d, kInfinity}, kVisibleAll, 0.0f, take);
  // Area lamps face along their axis; of spheres the density needs no normal.
  end.n = -d;
  end.restricted = met && lights.sample_light(from, light, {0.5f, 0.5f}, sample) &&
                   lobes_lit(sample.visibility) != kLobeAny;
  return met;
}

// Whether the surfaces on an edge let light's own walks through: that to `to`, or without it to the
// light at `distance`, or where that is 0 to the lens.
bool PathVerifier::crossed_by_light(const Vertex& from, const Vertex* to, float distance) const {
  if (!scene_.requirements.path_dependent || !scene_.requirements.transparent_shadows) {
    return true;
  }
  uint64_t rays = 0;
  bool blocked = false;
  const SegmentContext context{scene_, 1024, rays};
  if (to == nullptr && distance == 0.0f) {
    const float depth = dot(from.made->point.p - scene_.camera->position(), scene_.camera->axis());
    const float cosine = -dot(from.to_camera, scene_.camera->axis());
    camera_transmittance<true>(context,
                               spawn_segment(from.made->point.p + from.to_camera * (depth / cosine),
                                             from.made->point, from.to_camera),
                               &blocked);
  } else {
    Ray ray = to != nullptr ? spawn_segment(from.made->point, to->made->point, from.to_light)
                            : spawn_ray(from.made->point, from.to_light);
    if (to == nullptr && distance < kInfinity) {
      const Vec3f end = from.made->point.p + from.to_light * distance;
      ray = {ray.o, end - ray.o, kOneMinusEpsilon};
    }
    transmittance<true>(context, ray, from.made->point.depth, &blocked);
  }
  return !blocked;
}

void PathVerifier::compare(const FoundPath& found, PathCheck check, double a, double b,
                           bool relative) {
  PathReport::Check& result = report_.checks[static_cast<size_t>(check)];
  const double scale = relative ? std::max(std::abs(a), std::abs(b)) : 1.0;
  const double deviation = scale > 0.0 ? std::abs(a - b) / scale : 0.0;
  ++result.count;
  result.failures += deviation <= tolerance_ ? 0 : 1;  // not a number: a failure
  if (!(deviation <= result.worst)) {
    result.worst = std::isfinite(deviation) ? deviation : static_cast<double>(kInfinity);
    char text[160];
    std::snprintf(text, sizeof(text), "(%d, %d)%s of light %d: %.9g against %.9g", found.s, found.t,
                  found.merged ? " merged" : "", static_cast<int>(found.light), a, b);
    result.worst_path = text;
  }
}

// What the walk's own closures say of the vertex, against those seen anew from either side.
void PathVerifier::compare_scattering(const FoundPath& found, const Vertex& v) {
  if (v.singular || !v.made->bsdf.connectible()) {
    return;
  }
  const Vec3f wi = v.by_camera ? v.to_light : v.to_camera;
  const BsdfEval cached = scatter_eval(scene_, *v.made, wi);
  const double turned = static_cast<double>(abs_cosine(v.near_camera, v.to_camera) /
                                            abs_cosine(v.near_camera, v.to_light));
  compare(found, PathCheck::kScattering, largest(cached.f),
          largest(v.f) * (v.by_camera ? 1.0 : turned), true);
  const double own = v.by_camera ? v.pdf_to_light : v.pdf_to_camera;
  const double other = v.by_camera ? v.pdf_to_camera : v.pdf_to_light;
  compare(found, PathCheck::kScattering, static_cast<double>(cached.pdf), own, true);
  if (v.made->other_reaches) {
    compare(found, PathCheck::kScattering, static_cast<double>(cached.pdf_reverse), other, true);
  }
}

// The contribution is the product of what scatters and shines over the technique's density. That
// is of areas: the geometric factors and the camera's importance stand beside it.
void PathVerifier::compare_throughput(const FoundPath& found, const std::vector<Vertex>& vertices,
                                      const Path& path, const End& end, double log_pdf) {
  std::array<double, 3> product;
  for (int c = 0; c < 3; ++c) {
    product[static_cast<size_t>(c)] = static_cast<double>(end.radiance[c]);
  }
  double log_geometry =
      std::log(path.camera.pdf_across) +
      std::log(static_cast<double>(abs_cosine(vertices[0].near_camera, vertices[0].to_camera)));
  for (size_t i = 0; i < vertices.size(); ++i) {
    const Vertex& v = vertices[i];
    for (int c = 0; c < 3; ++c) {
      product[static_cast<size_t>(c)] *= static_cast<double>(v.f[c]);
    }
    if (!v.by_camera) {
      log_geometry += std::log(v.refraction);
    }
    if (i > 0) {
      const Vec3f d = path.surfaces[i].p - path.surfaces[i - 1].p;
      log_geometry += std::log(static_cast<double>(abs_cosine(v.near_camera, v.to_camera))) -
                      2.0 * std::log(static_cast<double>(length(d)));
    }
  }
  const double expected =
      *std::max_element(product.begin(), product.end()) * std::exp(log_geometry - log_pdf);
  compare(found, PathCheck::kThroughput,
          largest(found.contribution) * (1.0 + found.others) / found.share, expected, true);
}

void PathVerifier::found(const FoundPath& as_found) {
  if (is_black(as_found.contribution)) {
    return;  // joined, but something is in between
  }
  FoundPath found = as_found;
  ++(found.merged ? report_.merges : report_.techniques)[{found.s, found.t}];
  const PathVertex* light_end = found.merged ? trace_again(found) : nullptr;
  const std::vector<Vertex> vertices = vertices_of(found);
  if (vertices.empty() || found.light == kNoIndex) {
    // No other technique knows it.
    compare(found, PathCheck::kWeight, found.others, 0.0, false);
    return;
  }
  const LightSampler& lights = *scene_.lights;
  // The last surface, as the light meets it.
  Vertex there;
  Vec3f moved;  // the light's sub-path of a merge
  if (light_end != nullptr) {
    const Vertex& z = vertices[static_cast<size_t>(found.t) - 2];
    there.made = light_end;
    there.to_camera = z.to_camera;
    there.to_light = found.wi;
    see(there, false);
    moved = z.made->point.p - light_end->point.p;
    const float turned = std::abs(dot(there.near_light.ng, z.near_light.ng));
    if (!(turned > 1.0f - kFlat) || light_end->point.instance != z.made->point.instance ||
        merge_scale(*light_end) != merge_scale(*z.made)) {
      ++report_.uneven;
      return;
    }
  }
  const Vertex& last = light_end != nullptr && found.s == 2 ? there : vertices.back();
  End end;
  const bool grazing = std::any_of(vertices.begin(), vertices.end(), [](const Vertex& v) {
    return abs_cosine(v.near_camera, v.to_camera) < kGrazing ||
           abs_cosine(v.near_camera, v.to_light) < kGrazing;
  });
  if (grazing || !meet_light(found, last, end)) {
    ++report_.unseen;
    return;
  }

  Path path;
  path.camera.direction = vertices[0].to_camera;
  const float cos_lens = -dot(vertices[0].to_camera, scene_.camera->axis());
  const float depth =
      dot(vertices[0].made->point.p - scene_.camera->position(), scene_.camera->axis());
  path.camera.pdf_across =
      static_cast<double>(scene_.camera->pdf_across(cos_lens, depth / cos_lens)) / light_share_;
  bool straight = true;  // through no surface by chance
  for (size_t i = 0; i < vertices.size(); ++i) {
    const Vertex& v = vertices[i];
    const uint32_t visibility = scene_.instances[v.made->point.instance].visibility;
    PathSurface s;
    s.p = v.by_camera ? v.made->point.p : v.made->point.p + moved;
    s.ng = v.near_camera.ng;
    s.pdf_to_light = v.pdf_to_light;
    s.pdf_to_camera = v.pdf_to_camera;
    s.singular = v.singular;
    s.light_reaches = techniques_.light_paths &&
                      !scene_.materials[v.made->point.material]->traits().path_dependent &&
                      (visibility & kVisibleScattered) == kVisibleScattered;
    s.camera_sees = (visibility & kVisibleCamera) != 0;
    const bool by_merge = i > 0 && !v.by_camera && vertices[i - 1].by_camera && found.merged;
    s.light_crosses = i == 0 ? crossed_by_light(v, nullptr, 0.0f)
                             : crossed_by_light(by_merge ? there : vertices[i - 1], &v, 0.0f);
    if (merged_with_ != nullptr && v.made->bsdf.connectible()) {
      s.merge_area = merged_with_->area() * square(static_cast<double>(merge_scale(*v.made)));
    }
    if (i > 0) {
      s.joins = joins_ != nullptr ? joins_->joins(s.p, path.surfaces[i - 1].p) : own_paths_;
    }
    path.surfaces.push_back(s);
    straight = straight && v.made->point.depth.transparent == 0;
    compare_scattering(found, v);
  }
  path.joins = techniques_.joins;
  path.merges = techniques_.merges;
  const Receiver from = receiver_at(last);
  path.light.direction = last.to_light;
  path.light.hittable = lights.is_hittable(found.light);
  path.light.light_crosses = crossed_by_light(last, nullptr, end.distance);
  path.light.pdf_sampled = static_cast<double>(
      lights.is_delta(found.light)
          ? lights.pdf_selection(from, found.light)
          : lights.pdf_light(from, found.light, last.to_light, end.distance, end.n));
  path.light.pdf_emitted =
      static_cast<double>(lights.pdf_emission_ray(guide_, found.light, from.p, -last.to_light));
  if (lights.is_point(found.light)) {
    path.light.pdf_emitted /= square(static_cast<double>(end.distance));
  }

  const SurfacePdfs own = surface_pdfs(path);
  for (size_t i = 0; i < vertices.size(); ++i) {
    compare(found, PathCheck::kDensity, std::log(vertices[i].made->mis.pdf),
            vertices[i].by_camera ? own.log_camera[i] : own.log_light[i], false);
  }
  size_t technique = static_cast<size_t>(found.s);
  if (light_end != nullptr) {
    const size_t merged = static_cast<size_t>(found.t) - 2;
    technique = path.length() + merged;
    compare(found, PathCheck::kDensity, std::log(light_end->mis.pdf), own.log_light[merged], false);
  }
  if (end.restricted || !techniques_.weighted) {
    return;
  }
  const std::vector<double> log_pdfs = technique_log_pdfs(path);
  const std::vector<double> weights = technique_weights(log_pdfs, power_);
  const std::vector<double> recursive = recursive_weights(path, heuristic_);
  compare(found, PathCheck::kWeight, techniques_.weight(found.others), weights[technique], false);
  double sum = 0.0;
  for (size_t s = 0; s < weights.size(); ++s) {
    compare(found, PathCheck::kRecursion, recursive[s], weights[s], false);
    sum += recursive[s];
  }
  compare(found, PathCheck::kSum, sum, 1.0, false);
  if (straight && !scene_.requirements.transparent_shadows &&
      !scene_.requirements.hidden_from_rays) {
    compare_throughput(found, vertices, path, end, log_pdfs[technique]);
  }
}

}  // namespace vernier
