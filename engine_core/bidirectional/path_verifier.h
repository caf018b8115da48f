// Proves the tracer's bookkeeping: every path that it finds is made anew from its vertices, and
// what the sub-paths carry along is compared with what the path as a whole says.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bidirectional/light_vertices.h"
#include "bidirectional/technique_set.h"
#include "lights/emission_guide.h"
#include "lights/light_sample.h"
#include "paths/join_guide.h"
#include "paths/technique_pdfs.h"
#include "render/settings.h"
#include "scene/scene.h"

namespace vernier {

// What is compared. Values that agree differ by rounding.
enum class PathCheck : size_t {
  kDensity,     // a vertex's area density by its own walk; relative
  kScattering,  // a BSDF's value and both densities, as either side of a vertex sees them; relative
  kWeight,      // the weight as found, and of the plain form; absolute
  kRecursion,   // the recursive form over the whole path, and the plain form; absolute
  kSum,         // of the recursive form's weights over all techniques, and 1; absolute
  kThroughput,  // the contribution without its weight; relative
  kCount,
};
inline constexpr std::array<const char*, static_cast<size_t>(PathCheck::kCount)> kPathCheckNames{
    "density", "scattering", "weight", "recursion", "sum", "throughput"};

struct PathReport {
  struct Check {
    uint64_t count = 0;
    uint64_t failures = 0;  // beyond the tolerance that was given
    double worst = 0;
    std::string worst_path;  // in words
  };
  std::array<Check, static_cast<size_t>(PathCheck::kCount)> checks;
  std::map<std::pair<int, int>, uint64_t> techniques;  // paths found by (s, t)
  std::map<std::pair<int, int>, uint64_t> merges;      // likewise, of s + t - 1 vertices
  // Of these such as have no weights that could sum to 1: the surface is not the same at the two
  // places that were merged, or curved between them.
  uint64_t uneven = 0;
  // Paths along surfaces, or whose end on the light could not be met again: on rims, by rounding.
  uint64_t unseen = 0;
};

// An observer of BidirectionalTracer. Roulette, clamping and everything else that ends paths by
// chance must be off for kThroughput. It is left out where paths pass through surfaces by chance,
// and where lights reach some lobes only, which also have no weights that could sum to 1.
class PathVerifier {
 public:
  // `merged_with`: of sub-paths that are merged, the light's; null: none are. A merge is the path
  // that it stands for: the light's sub-path, made again by its number, moved as a whole so that it
  // ends where the camera's does.
  PathVerifier(const Scene& scene, const Settings& settings, const EmissionGuide& guide,
               const BidirectionalMemory& memory, double tolerance,
               const LightVertices* merged_with, const JoinGuide* joins, double own_paths);

  void emitted(const EmissionSample&) {}
  void found(const FoundPath& found);

  const PathReport& report() const { return report_; }

 private:
  struct Vertex;
  struct End;

  const PathVertex* trace_again(FoundPath& merge);
  std::vector<Vertex> vertices_of(const FoundPath& found) const;
  bool meet_light(const FoundPath& found, const Vertex& last, End& end) const;
  Receiver receiver_at(const Vertex& v) const;
  void see(Vertex& v, bool scatters_by_chance) const;
  void compare(const FoundPath& found, PathCheck check, double a, double b, bool relative);
  void compare_scattering(const FoundPath& found, const Vertex& v);
  void compare_throughput(const FoundPath& found, const std::vector<Vertex>& vertices,
                          const Path& path, const End& end, double log_pdf);
  bool crossed_by_light(const Vertex& from, const Vertex* to, float distance) const;

  const Scene& scene_;
  const TechniqueSet techniques_;
  const MisHeuristic heuristic_;
  const bool power_;
  const EmissionGuide& guide_;
  const BidirectionalMemory& memory_;
  const double tolerance_;
  const double light_share_;
  const Settings& settings_;
  const LightVertices* merged_with_;
  Subpath light_again_;     // of the path that was merged
  const JoinGuide* joins_;  // null: light paths are not shared
  const double own_paths_;  // BidirectionalPlan
  PathReport report_;
};

}  // namespace vernier
