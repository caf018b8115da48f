// Multiple importance sampling over the techniques that make one path: the recursive form.
//
// A path of n vertices v_0 (on the lens) to v_{n-1} (on the light) is made by technique (s, t)
// when its first t vertices come from the camera and its last s from the light. Two neighbouring
// techniques differ in one vertex alone: (s+1, t-1) makes v_{t-1} from the light's side, with area
// density P_L, where (s, t) makes it from the camera's, with P_C, so their densities stand as
// P_L / P_C. All others follow as products of such ratios (Veach 1997, section 10.2.1), and a
// weight needs only the sum of them over the techniques to either side. That sum has a short
// recursion along each sub-path (van Antwerpen 2011, "Recursive MIS Computation for Streaming BDPT
// on the GPU"), which is what is carried here. technique_pdfs.h has the plain form.
//
// The end on the light has a measure of its own. The last edge is told by its receiver v_{n-2} and
// the solid angle there, for all lights alike: lamps far and near, disks that turn to whom they
// light, and points. With p_b the density of the BSDF's sample there, p_l that of the light's and
// e the density over (area of v_{n-2}, solid angle at it) of a ray that starts at the light:
//   (0, n) : (1, n-1) : (2, n-2)  =  p_b P_C : p_l P_C : e.
//
// Shared light paths. Where camera vertices are joined to vertices of many light paths (see
// join_guide.h), joins have that number for a factor, which depends on the light's vertex.
//
// Merging. A vertex v_i may also come from both sides at once: the camera's walk makes it, and one
// of N walks from lights ends within r of it. That technique has the density of the join between
// v_i and v_{i+1} times P_L of v_i and the area N pi r^2, the number of walks that would end there
// for each unit of density (Georgiev et al. 2012, equations 7 and 9; Hachisuka et al. 2012,
// equation 8). In the sums it stands beside the join of v_{i-1} and v_i, and nothing else changes.
#pragma once

#include <algorithm>

#include "math/vec.h"

namespace vernier {

// The power heuristic with exponent 2 (Veach 1997, equation 9.13) where only two techniques
// compete: for densities a (used) and b, by their ratio so that the squares cannot overflow.
inline float power_heuristic(float a, float b) {
  if (!(a < kInfinity)) {
    return 1.0f;
  }
  const float ratio = b / a;
  return 1.0f / (1.0f + ratio * ratio);
}

// Sums of ratios live in float64 and stay within this, so that times a zero they are zero.
inline constexpr double kLargestRatio = 1e300;
// The square of the least distance that float32 holds.
inline constexpr double kLeastSquare = 1e-76;

// The heuristic's exponent is 1 (balance) or 2 (power). Without `joins`, sub-paths are merged only:
// no vertex is joined to another, to a light or to the camera.
class MisHeuristic {
 public:
  explicit MisHeuristic(bool power, bool joins = true) : power_(power), joins_(joins) {}
  // Whether there are techniques that join vertices.
  bool joins() const { return joins_; }
  // A ratio of densities as it enters the sums.
  double operator()(double ratio) const {
    return std::min(power_ ? ratio * ratio : ratio, kLargestRatio);
  }

 private:
  bool power_, joins_;
};

inline double bounded_product(double a, double b) { return std::min(a * b, kLargestRatio); }

// The same as MisState::neighbour and chain, relative to the technique that merges at the vertex.
struct MergeRatios {
  double neighbour, chain;

  double sum(const MisHeuristic& h, double reverse) const {
    return neighbour + bounded_product(h(reverse), chain);
  }
};

// What a vertex v_i knows of the techniques that have fewer vertices on its own side, but not yet
// of the directions in which its own path goes on. "Own" and "other" are the two sides.
struct MisState {
  double pdf = 1;        // P_own: area density of the vertex (after the light: e)
  double neighbour = 0;  // the technique that joins v_{i-1} and v_i, relative to what is next to it
  double merge = 0;      // likewise the one that merges at v_i
  double chain = 0;      // those beyond, but for the solid-angle density of v_i to v_{i-1}

  // The sum over all techniques with fewer vertices on this side, where the other side makes this
  // vertex with area density `other`, and from here the previous one with `reverse` (solid angle).
  double sum(const MisHeuristic& h, double other, double reverse) const {
    return bounded_product(h(other / pdf), neighbour + merge + bounded_product(h(reverse), chain));
  }

  // The vertex may be merged with those of so many paths from lights, each within an area (m^2).
  void merges(const MisHeuristic& h, double paths_times_area) { merge = h(paths_times_area * pdf); }
  // To be asked only where it does.
  MergeRatios beside_merge() const {
    return {std::min(neighbour / merge, kLargestRatio), std::min(chain / merge, kLargestRatio)};
  }
};

// A vertex as its sub-path leaves it: everything but the distance to the next vertex.
struct MisDeparture {
  double pdf = 0;     // of the direction: solid angle; singular: of the choice
  double cosine = 1;  // |cos| of the direction with the geometric normal
  double sum = 0;     // so far, before the vertex's own P_other
  bool singular = false;

  MisDeparture() = default;
  // `other_reaches`: whether sub-paths from the other side may contain the vertex.
  MisDeparture(const MisHeuristic& h, const MisState& at, double pdf_, double reverse,
               double cosine_, bool singular_, bool other_reaches)
      : pdf(pdf_), cosine(cosine_), singular(singular_) {
    if (other_reaches) {
      const double joined = singular ? 0.0 : at.neighbour + at.merge;
      sum = bounded_product(h(1.0 / at.pdf), joined + bounded_product(h(reverse), at.chain));
    }
  }

  // The next vertex, at `distance`, with `cosine_there` at it. `other_crosses`: whether the other
  // side's sub-paths may contain the edge. `joins`: how often it is made by joining its ends, for
  // each path from a light.
  MisState arrive(const MisHeuristic& h, double distance, double cosine_there, bool other_crosses,
                  double joins = 1.0) const {
    const double inverse_d2 = 1.0 / std::max(distance * distance, kLeastSquare);
    MisState next;
    next.pdf = pdf * cosine_there * inverse_d2;
    next.neighbour = h.joins() && !singular && other_crosses ? h(joins) : 0.0;
    next.chain = other_crosses ? bounded_product(h(cosine * inverse_d2), sum) : 0.0;
    return next;
  }
};

}  // namespace vernier
