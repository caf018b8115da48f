// Whole paths as the points of a chain (Veach and Guibas 1997, "Metropolis Light Transport").
//
// Surfaces are numbered from the camera. The measure is that of technique_pdfs.h: area at surfaces,
// the solid angle at the last surface for the light, 1 for each singular event. Importance is
// changed by refraction between that delta's two sides, which light's own steps account for.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "metropolis/contribution.h"
#include "metropolis/metropolis_plan.h"
#include "metropolis/primary_explorer.h"
#include "paths/path_vertex.h"

namespace vernier {

// What two vertices see each other through: surfaces that let light straight through are no
// vertices of a path.
struct Passage {
  Color transmittance = splat(1.0f);
  double log_pdf = 0;  // logarithm of the probability that a walk passes them all
};

struct ChainVertex {
  SurfacePoint point;  // wo: to the camera
  Passage before;      // toward the camera
  Vec3f to_light;      // unit, to the next vertex
  uint8_t event = 0;   // LobeBits of a singular event; 0: smooth scattering
  // What PathSpace::evaluate() finds.
  Color f;
  double pdf_to_light = 0, pdf_to_camera = 0;  // of either direction; singular: of the choice
  double log_refraction = 0;
  // Logarithms of the probabilities that the walk of either side does not pass the surface.
  double log_stop_camera = 0, log_stop_light = 0;
  bool matte = false;  // smooth and rough enough to be joined to others
  bool stops = false;  // some lobe is smooth: replace_lens_subpath() goes no further
};

// The end on a light, which the last surface sees along its to_light.
struct ChainLight {
  uint32_t light = kNoIndex;
  float distance = kInfinity;
  Vec3f n;
  Color radiance;          // delta lights: what arrives
  double pdf_sampled = 0;  // by light sampling
  double pdf_emitted = 0;  // of the ray by emission
  double pdf_met = 0;      // the part of rays that meet the light, where a ray meets several
  Passage before;          // toward the last surface
};

// A path, its splat and its target. What of its density is geometry stands apart, as a logarithm.
struct PathState : Contribution {
  std::vector<ChainVertex> v;
  Vec2f raster;
  double pdf_across =
      0;  // of the first surface, over area across the ray, over the pixels rendered
  ChainLight end;
  double log_geometry = 0;
};

// What mutations are made of.
class PathSpace {
 public:
  PathSpace(const RenderContext& context, RenderStats& stats);

  // ---- Steps. Each returns false where there is nothing. `random()` gives numbers in [0,1).

  // Appends the surface that the camera sees at a raster position.
  bool begin_at_lens(Vec2f raster, PathState& path);
  // Appends the surface that the last one scatters to.
  bool extend(PathState& path);
  // Appends the surface in the direction that the last one has been given.
  bool follow(PathState& path);
  // The direction of the singular event of these bits at a surface seen along wo.
  bool singular_direction(const SurfacePoint& point, uint8_t event, Vec3f& wi);
  // Makes the surface that a ray from a light meets, or which surface `from`, as met from its
  // light, scatters to. The result's to_light is set, and its point as seen from there.
  bool emit(ChainVertex& first, ChainLight& end);
  bool extend_from_light(ChainVertex& from, ChainVertex& next);
  bool follow_from_light(ChainVertex& from, Vec3f direction, ChainVertex& next);
  // The surface that a ray of a light meets; what of the light itself is in the way is passed.
  bool trace_from(const Ray& ray, uint32_t light, ChainVertex& first);
  // Whether some lobe of the last surface is smooth.
  bool stops(const PathState& path);

  // ---- Joins.

  // Joins surfaces i and i + 1 by smooth scattering. False: something is in between.
  bool join(PathState& path, size_t i) const;
  // Finds what lies between surfaces i and i + 1, which are as they are; and, where they have been
  // given their light, between the first surface and the lens. False: it lets nothing through.
  bool see_between(PathState& path, size_t i) const;
  bool see_to_lens(PathState& path) const;
  // Joins the first surface to the lens.
  bool join_lens(PathState& path);
  // Joins the last surface to a light that is sampled for it.
  bool join_light(PathState& path);
  // Meets a light from the last surface, whose direction has been given or (`draw`) is drawn.
  bool meet_light(PathState& path, bool draw);
  // The same light seen from the last surface along its to_light, with what depends on both.
  bool see_light(PathState& path);

  // The camera's end of a path whose first surface has been given its direction to the lens.
  bool see_lens(Vec2f raster, PathState& path) const;
  // The bits of the singular event that scatters to wi; 0: there is none.
  uint8_t event_toward(const SurfacePoint& point, Vec3f wi);

  // ---- The whole path.

  // Everything that depends on the path. False: it carries no light.
  bool evaluate(PathState& path);
  // Logarithms of the area densities with which the camera's and the light's walk make surface i.
  double log_camera(const PathState& path, size_t i) const;
  double log_light(const PathState& path, size_t i) const;
  // The logarithm of the density with which all but the first `a` and last `b` surfaces are grown
  // from both sides in every way that can make them, each as probable as the others.
  double log_grown(const PathState& path, size_t a, size_t b) const;
  // |cos| and squared distance over the edge between surfaces i and i + 1.
  double log_distance2(const PathState& path, size_t i) const;

  // Whether surfaces may let light straight through.
  bool passes() const { return transparent_; }

  float random() { return rng_.next_float(); }
  Vec2f random_2d() {
    const float x = random();
    return {x, random()};
  }
  void seed(Pcg32 rng) { rng_ = rng; }

  const RenderContext& context;
  const MetropolisPlan& plan;
  const FilmSpace film;
  const size_t least, most;  // surfaces of a path

 private:
  void load(const SurfacePoint& point, Transport mode, PathVertex& v) const;
  bool may_pass(const SurfacePoint& point) const {
    return transparent_ && scene_.materials[point.material]->traits().maybe_transparent;
  }
  double log_stop(const SurfacePoint& seen_from_camera) const;
  bool trace(Ray ray, Transport mode, SurfacePoint& point, Passage& passed,
             uint32_t light = kNoIndex);
  bool see_through(const Ray& segment, Passage& passed) const;
  Receiver receiver(const SurfacePoint& point);
  bool look(PathState& path, uint32_t wanted);
  // Draws where light comes from at v, seen from the camera's side. False: nowhere.
  bool draw_direction(ChainVertex& v);
  void evaluate(ChainVertex& v);

  const Scene& scene_;
  const LightSampler& lights_;
  RenderStats& stats_;
  const double light_share_;
  const bool transparent_;  // surfaces may let light straight through
  // Of these walks choose, after having chosen not to pass straight through.
  const uint8_t lobes_;
  Pcg32 rng_{0};
  PathVertex scratch_;
  mutable std::vector<double> scratch_logs_;
};

}  // namespace vernier
