// How the tracer of bidirectional paths joins a light's sub-path: to the camera, and to the
// vertices of the camera's; and how it merges them. Part of tracer.h.
#pragma once

#include <bit>

#include "bidirectional/tracer.h"

namespace vernier {

// Joins a light vertex to the camera: technique (s, 1).
template <BidirectionalFeatures F, class Observer, class Sampler>
void BidirectionalTracer<F, Observer, Sampler>::splat_vertex(const Walk& walk,
                                                             const PathVertex& v) {
  const int s = walk.depth.total + 2;
  if (!techniques_.show(s, 1) || walk.depth.total >= walks_.limits.total ||
      (scene_.instances[v.point.instance].visibility & kVisibleCamera) == 0) {
    return;
  }
  const Vec2f u_lens = camera_.is_pinhole() ? Vec2f{} : walk.draw(BounceDim::kLightPoint);
  const auto c = camera_.connect(v.point.p, u_lens, filter_.radius());
  if (!c) {
    return;
  }
  const BsdfEval eval = scatter_eval(scene_, v, c->wi);
  Color flux = v.beta * eval.f * c->importance;
  if (is_black(flux)) {
    return;
  }
  if (walks_.limits.kinds_from_lights) {
    flux *= chance_within(walks_.limits, PathDepth{}, v.point.depth,
                          kind_chances_from_light(scene_, v, c->wi), kNotCounted);
  }
  const float cos_lens = -dot(c->wi, camera_.axis());
  const double camera_pdf = static_cast<double>(camera_.pdf_across(cos_lens, c->distance)) *
                            static_cast<double>(abs_cosine(v.point, c->wi)) / light_share_;
  const double others = v.mis.sum(heuristic_, camera_pdf, static_cast<double>(eval.pdf_reverse));
  flux *= static_cast<float>(techniques_.weight(others) / light_paths_);
  // A splat of all paths is a pixel's value as often as there are pixels.
  const float u = walk.draw(BounceDim::kLightChoice).x;
  if (!plan_.worthwhile(flux, 1.0, u)) {
    return;
  }
  bool blocked = false;
  flux *= camera_transmittance<F.transparent>(
      segments(), spawn_segment(c->p_lens - c->wi * c->clip_begin, v.point, c->wi), &blocked);
  if (blocked || is_black(flux)) {
    return;
  }
  if (!is_finite(flux)) {
    ++stats_.non_finite;
    return;
  }
  flux = clamp(flux, walk.depth.total == 0);
  observer_.found({s, 1, light_number_, &v, light_.data(), nullptr, c->wi, c->distance, others,
                   flux, c->raster});
  if constexpr (F.passes) {
    splats_.add(c->raster, flux, shares_toward_camera(scene_, v, c->wi), walk.depth.total == 0);
  } else {
    splats_.add(c->raster, flux);
  }
}

// A join that is to be made.
template <BidirectionalFeatures F, class Observer, class Sampler>
struct BidirectionalTracer<F, Observer, Sampler>::Join {
  SharedPaths::Choice end;
  Vec3f wi;  // from the camera's vertex
  float distance, distance_squared;
  float scale;  // of what it brings
};

// Whether the join of vertex v, of such brightness, to y is to be made. It is seen as if both
// surfaces were matte or, the glossier they are, brighter: what is then far from worthwhile is let
// go.
template <BidirectionalFeatures F, class Observer, class Sampler>
bool BidirectionalTracer<F, Observer, Sampler>::choose_join(const Walk& walk, const PathVertex& v,
                                                            Color brightness, const JoinEnd& y,
                                                            double joins, float u,
                                                            Join& join) const {
  if (!techniques_.show(y.bounces + 2, walk.depth.total + 2) ||
      !walks_.limits.allow_joined(walk.depth.total, y.bounces)) {
    return false;
  }
  const Vec3f d = y.p - v.point.p;
  const float d2 = length_squared(d);
  if (!(d2 > 0.0f)) {
    return false;
  }
  join.distance_squared = d2;
  join.distance = std::sqrt(d2);
  join.wi = d * (1.0f / join.distance);
  const auto part = static_cast<float>(1.0 / joins);
  Color c = brightness * y.brightness *
            (abs_cosine(v.point, join.wi) * abs_cosine(y.ng, join.wi) / d2 * part);
  const float guess = max_component(c);
  if (!plan_.worthwhile(c, 1.0, u)) {
    return false;
  }
  const float raised = guess < kInfinity ? max_component(c) / guess : 1.0f;
  join.scale = raised / d2 * part;
  return true;
}

// Joins the two sub-paths: technique (s, t) with both at least 2.
template <BidirectionalFeatures F, class Observer, class Sampler>
void BidirectionalTracer<F, Observer, Sampler>::connect(const Walk& walk, const PathVertex& v,
                                                        const Join& join, float u) {
  const PathVertex& y = *join.end.vertex;
  const Vec3f wi = join.wi;
  const BsdfEval at_v = scatter_eval(scene_, v, wi);
  if (is_black(at_v.f)) {
    return;
  }
  const BsdfEval at_y = scatter_eval(scene_, y, -wi);
  Color c = v.beta * at_v.f * at_y.f * y.beta * join.scale;
  if (walks_.limits.kinds_from_lights) {
    c *= chance_within(walks_.limits, walk.depth, y.point.depth, kind_chances(scene_, v, wi),
                       kind_chances_from_light(scene_, y, -wi));
  }
  if (is_black(c)) {
    return;
  }
  const double inverse_d2 = 1.0 / static_cast<double>(join.distance_squared);
  const double from_light =
      static_cast<double>(at_y.pdf) * static_cast<double>(abs_cosine(v.point, wi)) * inverse_d2;
  const double from_camera =
      static_cast<double>(at_v.pdf) * static_cast<double>(abs_cosine(y.point, wi)) * inverse_d2;
  double others = y.mis.sum(heuristic_, from_camera, static_cast<double>(at_y.pdf_reverse));
  if (v.other_reaches) {
    others += v.mis.sum(heuristic_, from_light, static_cast<double>(at_v.pdf_reverse));
  }
  const double joins = light_ends().joins_of(y.point.p, v.point.p);
  others /= heuristic_(joins);
  if (!plan_.worthwhile(c, techniques_.weight(others), u)) {
    return;
  }
  bool blocked = false;
  c *= transmittance<F.transparent>(segments(), spawn_segment(v.point, y.point, wi), walk.depth,
                                    &blocked);
  if (!blocked) {
    add_reaching(walk, kLobeAny, false,
                 {y.point.depth.total + 2,
                  walk.depth.total + 2,
                  join.end.light,
                  &y,
                  join.end.path,
                  &v,
                  wi,
                  join.distance,
                  others,
                  c,
                  {},
                  joins / join.end.joins});
  }
}

// Joins a camera vertex to those of light paths: techniques (s, t) with both at least 2.
template <BidirectionalFeatures F, class Observer, class Sampler>
void BidirectionalTracer<F, Observer, Sampler>::connect_all(const Walk& walk, const PathVertex& v) {
  const Vec2f u = walks_.sampler.get_2d(dimension(walk.index, BounceDim::kJoin));
  const Color bright = v.beta * brightness(v);
  Join join;
  if (shared_ != nullptr) {
    Pcg32 rng(std::bit_cast<uint64_t>(u));  // roulette needs no stratification
    const uint32_t count = shared_->empty(v.point.p) ? 0 : plan_.joins.count();
    for (uint32_t i = 0; i < count; ++i) {
      const JoinEnd* y;
      join.end = shared_->choose(v.point.p, {rotate(u.x, i), rotate(u.y, i)}, y);
      const float u_guess = rng.next_float(), u_join = rng.next_float();
      if (choose_join(walk, v, bright, *y, join.end.joins, u_guess, join)) {
        connect(walk, v, join, u_join);
      }
    }
    return;
  }
  const CountedRays counted(*this);
  for (const JoinEnd& y : ends_) {
    if (choose_join(walk, v, bright, y, plan_.own_paths, rotate(u.x, y.number), join)) {
      join.end = {&light_[y.number], light_.data(), light_number_, plan_.own_paths};
      connect(walk, v, join, rotate(u.y, y.number));
    }
  }
}

// Merges a vertex of the camera's sub-path with those of all light's sub-paths that lie nearby:
// technique (s, t) for paths of s + t - 1 vertices. The light that they bring counts as spread
// evenly over the disk about the vertex.
template <BidirectionalFeatures F, class Observer, class Sampler>
void BidirectionalTracer<F, Observer, Sampler>::merge(const Walk& walk, const PathVertex& v) {
  if (!(v.mis.merge > 0.0)) {
    return;
  }
  // Light would leak to where others of its vertices cannot be: round corners and edges, to the
  // next layer of what lies close, and through what is thin. So the surface must face about the
  // same way there (cosine), and lie about in the plane of this one (in radii).
  constexpr float kLeastCosine = 0.5f, kMostOffset = 0.5f;
  const float radius = light_vertices_->radius() * merge_scale(v);
  const float radius_squared = square(radius);
  const double area = merge_area_ * square(static_cast<double>(merge_scale(v)));
  const auto density = static_cast<float>(1.0 / area);
  light_vertices_->for_each(
      v.point.p, [&](const LightVertex& y, Vec3f position, float distance_squared) {
        const float facing = dot(v.point.ng, y.ng);
        if (distance_squared <= radius_squared && std::abs(facing) >= kLeastCosine &&
            std::abs(dot(v.point.ng, position - v.point.p)) <= kMostOffset * radius &&
            facing * dot(v.point.ng, y.wi) > 0.0f &&
            walk.depth.total + y.depth.total < walks_.limits.total &&
            techniques_.show(y.depth.total + 2, walk.depth.total + 2)) {
          merge(walk, v, y, position, density);
        }
      });
}

template <BidirectionalFeatures F, class Observer, class Sampler>
void BidirectionalTracer<F, Observer, Sampler>::merge(const Walk& walk, const PathVertex& v,
                                                      const LightVertex& y, Vec3f position,
                                                      float density) {
  const BsdfEval eval = scatter_eval(scene_, v, y.wi);
  const float cosine = flux_cosine(v.point, y.wi, std::abs(dot(y.ng, y.wi)));
  Color c = v.beta * eval.f * y.beta * (density / cosine);
  if (walks_.limits.kinds_from_lights) {
    c *= chance_within(walks_.limits, walk.depth, y.depth,
                       y.depth.total == 0 ? kNotCounted : kind_chances(scene_, v, y.wi),
                       kNotCounted);
  }
  if (is_black(c)) {
    return;
  }
  const double others =
      v.mis.beside_merge().sum(heuristic_, static_cast<double>(eval.pdf_reverse)) +
      y.ratios().sum(heuristic_, static_cast<double>(eval.pdf));
  FoundPath path{y.depth.total + 2,
                 walk.depth.total + 2,
                 kNoIndex,
                 nullptr,
                 nullptr,
                 &v,
                 y.wi,
                 0.0f,
                 others,
                 c};
  path.merged = true;
  path.light_path = y.path;
  path.light_end = position;
  add_reaching(walk, kLobeAny, walk.depth.total == 0 && y.depth.total == 0, std::move(path));
}

}  // namespace vernier
