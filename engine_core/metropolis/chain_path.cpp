#include "metropolis/chain_path.h"

#include <algorithm>
#include <limits>

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

// The part of the choices among the lobes of a vertex that is not to pass straight through.
double scattered(const PathVertex& v) {
  const auto straight = v.bsdf.singular_toward(-v.point.wo, kLobeSingular | kLobeTransparent);
  return straight ? 1.0 - static_cast<double>(straight->pdf) : 1.0;
}

}  // namespace

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
  v.log_stop_camera = v.log_stop_light = 0.0;
  if (may_pass(v.point)) {
    v.log_stop_camera = log_stop(v.point);
    v.log_stop_light = log_stop(seen_from(v.point, -v.to_light));
  }
  v.stops = scratch_.bsdf.connectible();
  if (v.event == 0) {
    const BsdfEval eval = scatter_eval(scene_, scratch_, v.to_light, lobes_);
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
  v.pdf_to_light = static_cast<double>(event->pdf) / scattered(scratch_);
  const Vec3f wo = v.point.wo;
  load(seen_from(v.point, v.to_light), Transport::kImportance, scratch_);
  const auto back = scratch_.bsdf.singular_toward(wo, v.event);
  v.pdf_to_camera = back ? static_cast<double>(back->pdf) / scattered(scratch_) : 0.0;
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
  Color color = path.end.radiance * path.end.before.transmittance;
  path.log_geometry = log_of(path.pdf_across) + log_cosine(path.v[0].point, path.v[0].point.wo);
  for (size_t i = 0; i < path.v.size(); ++i) {
    ChainVertex& v = path.v[i];
    evaluate(v);
    color *= v.f * v.before.transmittance;
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
  const ChainVertex& v = path.v[i];
  const double here = log_cosine(v.point, v.point.wo) + v.before.log_pdf + v.log_stop_camera;
  return i == 0 ? log_of(path.pdf_across) + here - std::log(film.share())
                : log_of(path.v[i - 1].pdf_to_light) + here - log_distance2(path, i - 1);
}

double PathSpace::log_light(const PathState& path, size_t i) const {
  const ChainVertex& v = path.v[i];
  const double here = log_cosine(v.point, v.to_light) - v.log_refraction + v.log_stop_light;
  if (i + 1 == path.v.size()) {
    return log_of(path.end.pdf_emitted) + here + path.end.before.log_pdf;
  }
  return log_of(path.v[i + 1].pdf_to_camera) + here + path.v[i + 1].before.log_pdf -
         log_distance2(path, i);
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
