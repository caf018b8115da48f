// Which techniques a bidirectional method uses, and what one of them has found.
#pragma once

#include <limits>
#include <vector>

#include "bidirectional/join_end.h"
#include "lights/light_sample.h"
#include "paths/bounce_limits.h"
#include "paths/subpath.h"
#include "render/settings.h"
#include "scene/requirements.h"

namespace vernier {

// What a tracer is compiled for.
struct BidirectionalFeatures {
  bool passes;           // more than the picture is asked for
  bool transparent;      // segments may pass surfaces
  bool merging = false;  // sub-paths are merged with all of the batch's
};

// Which techniques make the picture.
struct TechniqueSet {
  bool camera_paths;  // any with t >= 2, but for lights that the camera sees directly
  bool light_paths;   // any that start paths at lights
  bool joins;         // any that join two vertices, or sample a light
  bool merges;        // any that merge two
  bool weighted;
  int only_s, only_t;  // -1: all
  int least = 0;       // only paths of at least this many vertices
  // How often the walks may bounce; below 0: there is none.
  int most_light_bounces = std::numeric_limits<int>::max();
  int most_camera_bounces = std::numeric_limits<int>::max();

  TechniqueSet(const Settings& settings, const Requirements& requirements)
      : camera_paths(static_cast<IntegratorKind>(settings.integrator) != IntegratorKind::kLight),
        light_paths(!requirements.uneven_visibility &&
                    (counts_kinds(settings) || !BounceLimits::by_kind(settings))),
        joins(!vcm(settings) || settings.vcm_connections != 0),
        merges(vcm(settings) && settings.vcm_merging != 0 && settings.merge_radius > 0.0 &&
               light_paths),
        weighted(camera_paths && settings.unweighted == 0),
        only_s(settings.only_light_vertices),
        only_t(settings.only_camera_vertices) {}

  static bool vcm(const Settings& settings) {
    return static_cast<IntegratorKind>(settings.integrator) == IntegratorKind::kVcm;
  }
  // Whether paths that lights have a part in keep limits on single kinds of bounces.
  static bool counts_kinds(const Settings& settings) {
    const auto kind = static_cast<IntegratorKind>(settings.integrator);
    return kind == IntegratorKind::kBdpt || kind == IntegratorKind::kLight || vcm(settings);
  }
  MisHeuristic heuristic(const Settings& settings) const {
    return MisHeuristic(static_cast<MisExponent>(settings.mis_heuristic) == MisExponent::kPower,
                        joins);
  }

  bool show(int s, int t) const {
    return (only_s < 0 || only_s == s) && (only_t < 0 || only_t == t) && s + t >= least;
  }
  double weight(double others) const { return weighted ? 1.0 / (1.0 + others) : 1.0; }
};

// What a thread keeps from sample to sample.
struct BidirectionalMemory {
  Subpath light, camera;
  std::vector<JoinEnd> ends;  // of the light's that can be joined
};

// One way of making a path, as it is found: what an observer is told.
struct FoundPath {
  int s, t;                  // vertices from the light, from the camera; merged: one is of both
  uint32_t light;            // kNoIndex: merged, or emission that no light stands for
  const PathVertex* y;       // the light's sub-path ends here; null: s < 2
  const PathVertex* y_path;  // the vertices that y's parents are numbered among
  const PathVertex* z;       // the camera's sub-path ends here; null: t = 1, or t = 2 and s = 0
  Vec3f wi;                  // s < 2: from z to the light, unit
  float distance;            // s < 2: to the light, from z; infinite beyond the scene
  double others;       // densities of the other techniques, to the heuristic's power, over this
  Color contribution;  // weighted
  Vec2f raster = {};   // t = 1: where it was splatted, pixels of the full frame
  double share = 1;    // of what the technique's density says, that it counts: see SharedPaths
  bool merged = false;
  uint32_t light_path = kNoIndex;  // merged: which of the batch...
  Vec3f light_end = {};            // ...and where that one's vertex lies
};

// An observer that looks away.
struct NoObserver {
  void emitted(const EmissionSample&) {}  // a light's sub-path begins
  void found(const FoundPath&) {}
};

}  // namespace vernier
