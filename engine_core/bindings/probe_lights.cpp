// Probes of lights, their choice and the tabulated distributions. Rows in, rows out.
#include <nanobind/ndarray.h>

#include <cmath>

#include "bindings/bind.h"
#include "bindings/table.h"
#include "lights/environment.h"
#include "lights/light_sampler.h"
#include "math/distribution.h"
#include "math/octahedral.h"
#include "nodes/material.h"
#include "scene/scene.h"

namespace nb = nanobind;

namespace vernier {
namespace {

using Floats = nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Numbers = nb::ndarray<const uint32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

Vec3f vec3(const Floats& a, size_t i, size_t column = 0) {
  return {a(i, column), a(i, column + 1), a(i, column + 2)};
}
Vec2f vec2(const Floats& a, size_t i, size_t column = 0) {
  return {a(i, column), a(i, column + 1)};
}

// Rows of world position (3), ng (3), ns (3), transmits and, where there are more, complemented and
// narrow.
Receiver receiver(const Scene& scene, const Floats& a, size_t i) {
  const std::array<double, 3>& o = scene.origin();
  const Vec3f p{static_cast<float>(static_cast<double>(a(i, 0)) - o[0]),
                static_cast<float>(static_cast<double>(a(i, 1)) - o[1]),
                static_cast<float>(static_cast<double>(a(i, 2)) - o[2])};
  Receiver from(p, vec3(a, i, 3), vec3(a, i, 6), a(i, 9) != 0.0f);
  from.complemented = a.shape(1) > 10 && a(i, 10) != 0.0f;
  from.narrow = a.shape(1) > 11 && a(i, 11) != 0.0f;
  return from;
}

// Columns: valid, wi (3), distance, radiance (3), pdf, pdf_selection, point (3, world), normal (3),
// light, delta, hittable.
constexpr size_t kSampleColumns = 19;
void write_sample(const Scene& scene, const LightSample& s, float* out) {
  out[0] = 1.0f;
  write(s.wi, out + 1);
  out[4] = s.distance;
  write(s.radiance, out + 5);
  out[8] = s.pdf;
  out[9] = s.pdf_selection;
  write(scene.to_world(s.p), out + 10);
  write(s.n, out + 13);
  out[16] = static_cast<float>(s.light);
  out[17] = s.delta ? 1.0f : 0.0f;
  out[18] = s.hittable ? 1.0f : 0.0f;
}

// `u` has rows of the choice and the point.
Result sample_lights(nb::handle handle, const Floats& receivers, const Floats& u) {
  const auto scene = scene_of(handle);
  const Table table(u.shape(0), kSampleColumns);
  const bool one = receivers.shape(0) == 1;
  for (size_t i = 0; i < table.rows(); ++i) {
    LightSample s;
    if (scene->lights->sample(receiver(*scene, receivers, one ? 0 : i), u(i, 0), vec2(u, i, 1),
                              s)) {
      write_sample(*scene, s, table.row(i));
    }
  }
  return table.release();
}

// The same for given lights; `u` has rows of the point. The density is without the selection.
Result sample_given_lights(nb::handle handle, const Floats& receivers, const Numbers& lights,
                           const Floats& u) {
  const auto scene = scene_of(handle);
  const Table table(u.shape(0), kSampleColumns);
  const bool one = receivers.shape(0) == 1;
  for (size_t i = 0; i < table.rows(); ++i) {
    LightSample s;
    if (scene->lights->sample_light(receiver(*scene, receivers, one ? 0 : i), lights(i), vec2(u, i),
                                    s)) {
      write_sample(*scene, s, table.row(i));
    }
  }
  return table.release();
}

// Where a direction meets light number `light`: columns met, distance, radiance (3), pdf.
struct Meeting {
  float met = 0, distance = 0, pdf = 0;
  Color radiance;
};

Meeting meet_triangle(const Scene& scene, const Receiver& from, uint32_t instance,
                      uint32_t triangle, Vec3f d) {
  // In float64: this is the reference that samples are held against.
  const auto corners = scene.triangle(instance, triangle);
  double e1[3], e2[3], s[3], h[3], q[3];
  for (int c = 0; c < 3; ++c) {
    e1[c] = static_cast<double>(corners[1][c]) - static_cast<double>(corners[0][c]);
    e2[c] = static_cast<double>(corners[2][c]) - static_cast<double>(corners[0][c]);
    s[c] = static_cast<double>(from.p[c]) - static_cast<double>(corners[0][c]);
  }
  const double w[3] = {static_cast<double>(d.x), static_cast<double>(d.y),
                       static_cast<double>(d.z)};
  const auto cross3 = [](const double* a, const double* b, double* r) {
    r[0] = a[1] * b[2] - a[2] * b[1];
    r[1] = a[2] * b[0] - a[0] * b[2];
    r[2] = a[0] * b[1] - a[1] * b[0];
  };
  const auto dot3 = [](const double* a, const double* b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  };
  cross3(w, e2, h);
  const double det = dot3(e1, h);
  Meeting m;
  if (det == 0.0) {
    return m;
  }
  const double b1 = dot3(s, h) / det;
  cross3(s, e1, q);
  const double b2 = dot3(w, q) / det;
  const double t = dot3(e2, q) / det;
  if (b1 < 0.0 || b2 < 0.0 || b1 + b2 > 1.0 || t <= 0.0) {
    return m;
  }
  m.met = 1.0f;
  m.distance = static_cast<float>(t);
  const SurfacePoint point = scene.surface_point(
      Ray{from.p, d, kInfinity},
      Hit{m.distance, static_cast<float>(b1), static_cast<float>(b2), instance, triangle});
  m.radiance = scene.materials[point.material]->emission(point);
  double n[3];
  cross3(e1, e2, n);
  const double cosine = std::abs(dot3(n, w)) / std::sqrt(dot3(n, n));
  m.pdf = scene.lights->pdf_triangle(from, instance, triangle, d, m.distance,
                                     static_cast<float>(cosine));
  return m;
}

// The sum over all lights that the directions meet, occlusion aside: columns number of lights met,
// distance of the last, radiance (3), pdf. `kinds` has the Visibility bits of the rays.
Result meet_lights(nb::handle handle, const Floats& receivers, const Floats& directions,
                   uint32_t kinds) {
  const auto scene = scene_of(handle);
  const LightSampler& lights = *scene->lights;
  const Table table(directions.shape(0), 6);
  const bool one = receivers.shape(0) == 1;
  for (size_t i = 0; i < table.rows(); ++i) {
    const Receiver from = receiver(*scene, receivers, one ? 0 : i);
    const Vec3f d = vec3(directions, i);
    Meeting sum;
    const auto add = [&sum](float distance, Color radiance, float pdf) {
      sum.met += 1.0f;
      sum.distance = distance;
      sum.radiance += radiance;
      sum.pdf += pdf;
    };
    const auto add_hit = [&add](const LightHit& hit) { add(hit.t, hit.radiance, hit.pdf); };
    if (lights.has_lamp_hits(kinds)) {
      lights.for_each_lamp_hit(&from, Ray{from.p, d, kInfinity}, kinds, 0.0f, add_hit);
    }
    if (lights.has_escapes(kinds)) {
      lights.for_each_escape(&from, d, kinds, 0, PathDepth{}, add_hit);
    }
    for (uint32_t instance = 0; instance < scene->instances.size(); ++instance) {
      const size_t triangles = scene->meshes[scene->instances[instance].mesh].triangles.size();
      for (uint32_t t = 0; t < triangles; ++t) {
        if (lights.light_of_triangle(instance, t) != kNoIndex) {
          const Meeting m = meet_triangle(*scene, from, instance, t, d);
          if (m.met > 0.0f) {
            add(m.distance, m.radiance, m.pdf);
          }
        }
      }
    }
    float* out = table.row(i);
    out[0] = sum.met;
    out[1] = sum.distance;
    write(sum.radiance, out + 2);
    out[5] = sum.pdf;
  }
  return table.release();
}

// One column.
Result selection_pdf(nb::handle handle, const Floats& receivers, const Numbers& lights) {
  const auto scene = scene_of(handle);
  const Table table(lights.shape(0), 1);
  const bool one = receivers.shape(0) == 1;
  for (size_t i = 0; i < table.rows(); ++i) {
    table.row(i)[0] =
        scene->lights->pdf_selection(receiver(*scene, receivers, one ? 0 : i), lights(i));
  }
  return table.release();
}

// The density of samples with the given light, direction, distance and normal (columns wi (3),
// distance, n (3)).
Result light_pdf(nb::handle handle, const Floats& receivers, const Numbers& lights,
                 const Floats& samples) {
  const auto scene = scene_of(handle);
  const Table table(lights.shape(0), 1);
  const bool one = receivers.shape(0) == 1;
  for (size_t i = 0; i < table.rows(); ++i) {
    table.row(i)[0] =
        scene->lights->pdf_light(receiver(*scene, receivers, one ? 0 : i), lights(i),
                                 vec3(samples, i), samples(i, 3), vec3(samples, i, 4));
  }
  return table.release();
}

// `u` has rows of the choice, the position (2) and the direction (2). Columns: valid, origin (3,
// world), direction (3), normal (3), cosine, radiance (3), pdf_position, pdf_direction,
// pdf_selection, lit_from, light, delta_position, delta_direction.
Result sample_emission(nb::handle handle, const Floats& u) {
  const auto scene = scene_of(handle);
  const Table table(u.shape(0), 21);
  for (size_t i = 0; i < table.rows(); ++i) {
    EmissionSample s;
    if (!scene->lights->sample_emission(scene->lights->guide_by_power(), u(i, 0), vec2(u, i, 1),
                                        vec2(u, i, 3), s)) {
      continue;
    }
    float* out = table.row(i);
    out[0] = 1.0f;
    write(scene->to_world(s.p), out + 1);
    write(s.direction, out + 4);
    write(s.n, out + 7);
    out[10] = s.cosine;
    write(s.radiance, out + 11);
    out[14] = s.pdf_position;
    out[15] = s.pdf_direction;
    out[16] = s.pdf_selection;
    out[17] = s.lit_from;
    out[18] = static_cast<float>(s.light);
    out[19] = s.delta_position ? 1.0f : 0.0f;
    out[20] = s.delta_direction ? 1.0f : 0.0f;
  }
  return table.release();
}

// Columns of `samples`: normal (3), direction (3). Result: pdf_position, pdf_direction,
// pdf_selection.
Result emission_pdf(nb::handle handle, const Numbers& lights, const Floats& samples) {
  const auto scene = scene_of(handle);
  const Table table(lights.shape(0), 3);
  for (size_t i = 0; i < table.rows(); ++i) {
    const EmissionPdf pdf =
        scene->lights->pdf_emission(lights(i), Vec3f{}, vec3(samples, i), vec3(samples, i, 3));
    float* out = table.row(i);
    out[0] = pdf.position;
    out[1] = pdf.direction;
    out[2] = scene->lights->guide_by_power().lights.probability(lights(i));
  }
  return table.release();
}

// Points of the piecewise-constant density with these weights: columns x, y, pdf.
Result sample_grid(const Floats& weights, const Floats& u) {
  const PiecewiseConstant2D grid({weights.data(), weights.size()},
                                 static_cast<int>(weights.shape(1)),
                                 static_cast<int>(weights.shape(0)));
  const Table table(u.shape(0), 3);
  for (size_t i = 0; i < table.rows(); ++i) {
    float* out = table.row(i);
    const Vec2f p = grid.sample(vec2(u, i), out[2]);
    out[0] = p.x;
    out[1] = p.y;
  }
  return table.release();
}

// Density at each of the points (2 columns).
Result grid_pdf(const Floats& weights, const Floats& points) {
  const PiecewiseConstant2D grid({weights.data(), weights.size()},
                                 static_cast<int>(weights.shape(1)),
                                 static_cast<int>(weights.shape(0)));
  const Table table(points.shape(0), 1);
  for (size_t i = 0; i < table.rows(); ++i) {
    table.row(i)[0] = grid.pdf(vec2(points, i));
  }
  return table.release();
}

// Items chosen by an alias table over `weights` (one row), and their probabilities.
Result sample_alias(const Floats& weights, const Floats& u) {
  const std::vector<double> w(weights.data(), weights.data() + weights.size());
  const AliasTable alias(w);
  const Table table(u.shape(0), 2);
  for (size_t i = 0; i < table.rows(); ++i) {
    const uint32_t item = alias.sample(u(i, 0));
    table.row(i)[0] = static_cast<float>(item);
    table.row(i)[1] = alias.probability(item);
  }
  return table.release();
}

// Directions of points of the equal-area square (3 columns), and the points they map back to (2).
Result octahedral_map(const Floats& points) {
  const Table table(points.shape(0), 5);
  for (size_t i = 0; i < table.rows(); ++i) {
    const Vec3f d = square_to_sphere_equal_area(vec2(points, i));
    const Vec2f back = sphere_to_square_equal_area(d);
    write(d, table.row(i));
    table.row(i)[3] = back.x;
    table.row(i)[4] = back.y;
  }
  return table.release();
}

// Directions sampled from the map of a world whose radiance at direction d is the sum over
// `lobes`, rows of axis (3), sharpness s and strength a, of a exp(s (d.axis - 1)); and the
// densities. `directions` are evaluated instead where they are given (no sampling).
Result environment_map(int resolution, const Floats& lobes, const Floats& u,
                       const Floats& directions) {
  const EnvironmentMap map(resolution, 2, false, [&](Vec3f d) {
    float sum = 0.0f;
    for (size_t i = 0; i < lobes.shape(0); ++i) {
      sum += lobes(i, 4) * std::exp(lobes(i, 3) * (dot(d, vec3(lobes, i)) - 1.0f));
    }
    return splat(sum);
  });
  const bool sampling = directions.shape(0) == 0;
  const Table table(sampling ? u.shape(0) : directions.shape(0), 4);
  for (size_t i = 0; i < table.rows(); ++i) {
    float* out = table.row(i);
    if (sampling) {
      write(map.sample_direction(vec2(u, i), out[3]), out);
    } else {
      write(vec3(directions, i), out);
      out[3] = map.pdf_direction(vec3(directions, i));
    }
  }
  return table.release();
}

nb::dict light_summary(nb::handle handle) {
  const auto scene = scene_of(handle);
  const LightSampler& lights = *scene->lights;
  nb::dict d;
  d["count"] = lights.count();
  d["triangles"] = lights.emissive_triangle_count();
  d["total_power"] = lights.total_power();
  d["environment"] = static_cast<int64_t>(
      lights.light_of_environment() == kNoIndex ? -1 : int64_t{lights.light_of_environment()});
  return d;
}

}  // namespace

void bind_lights_probes(nb::module_& m) {
  m.def("sample_lights", &sample_lights);
  m.def("sample_given_lights", &sample_given_lights);
  m.def("meet_lights", &meet_lights);
  m.def("selection_pdf", &selection_pdf);
  m.def("light_pdf", &light_pdf);
  m.def("sample_emission", &sample_emission);
  m.def("emission_pdf", &emission_pdf);
  m.def("sample_grid", &sample_grid);
  m.def("grid_pdf", &grid_pdf);
  m.def("sample_alias", &sample_alias);
  m.def("octahedral_map", &octahedral_map);
  m.def("environment_map", &environment_map);
  m.def("light_summary", &light_summary);
}

}  // namespace vernier
