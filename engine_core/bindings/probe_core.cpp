// Probes of the camera, the samplers, the pixel filter and triangulation.
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <stdexcept>

#include "bindings/bind.h"
#include "bindings/table.h"
#include "camera/camera.h"
#include "render/film.h"
#include "sampling/pixel_filter.h"
#include "sampling/sobol.h"
#include "scene/scene.h"
#include "scene/triangulate.h"

namespace nb = nanobind;

namespace vernier {
namespace {

Vec2f vec2(const Rows2& a, size_t i) { return {a(i, 0), a(i, 1)}; }
Vec3f vec3(const Rows3& a, size_t i) { return {a(i, 0), a(i, 1), a(i, 2)}; }

// Columns: lens point relative to the camera (3), direction (3), cosine to the axis,
// pdf_area, pdf_direction, importance.
Result camera_rays(nb::handle handle, const Rows2& raster, const Rows2& u_lens) {
  const auto scene = scene_of(handle);
  const Camera& camera = *scene->camera;
  const Table table(raster.shape(0), 10);
  for (size_t i = 0; i < table.rows(); ++i) {
    const CameraRay r = camera.generate_ray(vec2(raster, i), vec2(u_lens, i));
    float* out = table.row(i);
    write(camera.to_camera(r.ray.o - r.ray.d * r.start_distance - camera.position()), out);
    write(camera.to_camera(r.ray.d), out + 3);
    const float cosine = dot(r.ray.d, camera.axis());
    out[6] = cosine;
    out[7] = camera.pdf_area();
    out[8] = camera.pdf_direction(cosine);
    out[9] = camera.importance(cosine);
  }
  return table.release();
}

// Points are in camera space. Columns: valid, lens point (3, camera space), raster (2),
// distance, importance (We / pdf), pdf, pdf_across.
Result camera_connections(nb::handle handle, const Rows3& points, const Rows2& u_lens) {
  const auto scene = scene_of(handle);
  const Camera& camera = *scene->camera;
  const Table table(points.shape(0), 10);
  for (size_t i = 0; i < table.rows(); ++i) {
    const auto c =
        camera.connect(camera.position() + camera.from_camera(vec3(points, i)), vec2(u_lens, i));
    if (!c) {
      continue;
    }
    float* out = table.row(i);
    out[0] = 1.0f;
    write(camera.to_camera(c->p_lens - camera.position()), out + 1);
    out[4] = c->raster.x, out[5] = c->raster.y;
    out[6] = c->distance, out[7] = c->importance, out[8] = c->pdf;
    out[9] = camera.pdf_across(-dot(c->wi, camera.axis()), c->distance);
  }
  return table.release();
}

// Of points in camera space: the radius of the disk that a pixel covers there.
Result camera_footprints(nb::handle handle, const Rows3& points) {
  const auto scene = scene_of(handle);
  const Camera& camera = *scene->camera;
  const Table table(points.shape(0), 1);
  for (size_t i = 0; i < table.rows(); ++i) {
    *table.row(i) = camera.footprint(camera.position() + camera.from_camera(vec3(points, i)));
  }
  return table.release();
}

// The points of one dimension pair: a row per pixel and sample, pixels in rows of the frame.
Result sobol_points(uint32_t width, uint32_t height, uint32_t samples, uint64_t seed,
                    uint32_t dimension) {
  const Table table(size_t{width} * height * samples, 2);
  const int log2_samples = std::bit_width(samples - 1u);
  size_t i = 0;
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      for (uint32_t s = 0; s < samples; ++s, ++i) {
        const Vec2f u = SobolSampler(x, y, s, log2_samples, seed).get_2d(dimension);
        table.row(i)[0] = u.x, table.row(i)[1] = u.y;
      }
    }
  }
  return table.release();
}

FilterKind filter_kind(const std::string& name) {
  if (name == "BOX") {
    return FilterKind::kBox;
  }
  if (name == "GAUSSIAN") {
    return FilterKind::kGaussian;
  }
  if (name == "BLACKMAN_HARRIS") {
    return FilterKind::kBlackmanHarris;
  }
  throw std::invalid_argument("there is no filter named " + name);
}

Result filter_offsets(const std::string& kind, float width, const Rows2& u) {
  const PixelFilter2d filter(filter_kind(kind), width);
  const Table table(u.shape(0), 2);
  for (size_t i = 0; i < table.rows(); ++i) {
    const Vec2f offset = filter.sample(vec2(u, i));
    table.row(i)[0] = offset.x, table.row(i)[1] = offset.y;
  }
  return table.release();
}

// Densities of offsets along one axis, per pixel.
std::vector<float> filter_densities(const std::string& kind, float width,
                                    const std::vector<float>& offsets) {
  const PixelFilter2d filter(filter_kind(kind), width);
  std::vector<float> densities;
  for (const float offset : offsets) {
    densities.push_back(filter.pdf_1d(offset));
  }
  return densities;
}

std::vector<std::array<uint32_t, 3>> triangulate_polygon(const Rows3& polygon) {
  std::vector<Vec3f> points;
  for (size_t i = 0; i < polygon.shape(0); ++i) {
    points.push_back(vec3(polygon, i));
  }
  std::vector<std::array<uint32_t, 3>> triangles;
  triangulate(points, triangles);
  return triangles;
}

// What a film of one pixel shows after `batches` batches of `samples` samples of one value each:
// red of the picture and of its emission pass, and the number of samples.
std::array<float, 3> accumulated(float value, uint32_t samples, uint64_t batches) {
  PassSet passes;
  for (const Pass pass : {Pass::kCombined, Pass::kEmission, Pass::kSampleCount}) {
    passes.add(pass);
  }
  Film film(1, 1, passes, 1.0f);
  PassSample sample;
  sample.emission = splat(value);
  Batch batch;
  batch.samples = samples;
  for (uint64_t number = 0; number < batches; ++number) {
    TileBuffer buffer = film.buffer(0, number, batch);
    for (uint32_t i = 0; i < samples; ++i) {
      buffer.pixel(0, 0).add(splat(value), 1.0f);
      buffer.add_passes(0, 0, sample, false);
    }
    film.merge(0, number, std::move(buffer));
  }
  std::array<float, 4> combined{};
  std::array<float, 3> emission{};
  std::array<float, 1> count{};
  film.read(Pass::kCombined, {0, 0, 1, 1}, combined);
  film.read(Pass::kEmission, {0, 0, 1, 1}, emission);
  film.read(Pass::kSampleCount, {0, 0, 1, 1}, count);
  return {combined[0], emission[0], count[0]};
}

}  // namespace

void bind_core_probes(nb::module_& m) {
  m.def("camera_rays", &camera_rays);
  m.def("camera_connections", &camera_connections);
  m.def("camera_footprints", &camera_footprints);
  m.def("sobol_points", &sobol_points);
  m.def("filter_offsets", &filter_offsets);
  m.def("filter_densities", &filter_densities);
  m.def("triangulate", &triangulate_polygon);
  m.def("accumulated", &accumulated, nb::call_guard<nb::gil_scoped_release>());
}

}  // namespace vernier
