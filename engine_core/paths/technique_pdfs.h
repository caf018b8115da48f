// The techniques that make one path, and the density of each: the plain form.
//
// A path of n vertices v_0 (on the lens) to v_{n-1} (on a light) is made by technique (s, t) when
// its first t vertices come from the camera and its last s from the light (Veach 1997, section
// 10.2). What is here looks at a whole path at once and at nothing else. It works in logarithms, so
// that no scale, no roughness and no length leaves float64. The tracers carry the same sums along
// instead (mis.h); methods that hold whole paths, and proofs, ask here.
//
// Measures. Surface vertices count by area, given the lens point, which all techniques choose
// alike. The last edge counts by solid angle at the last surface v_{n-2} (lights at one point, or
// of one direction: by that delta), so that lights far and near need no cases. Singular scattering
// counts by the probability of its choice: its delta distributions are common to all techniques.
#pragma once

#include <cstddef>
#include <vector>

#include "math/vec.h"
#include "paths/mis.h"

namespace vernier {

// A vertex where light scatters: v_1 to v_{n-2}.
struct PathSurface {
  Vec3f p;                    // render space, metres
  Vec3f ng;                   // unit geometric normal, either side
  double pdf_to_light = 0;    // of the direction to the next vertex, drawn by the camera's walk
  double pdf_to_camera = 0;   // of the direction to the previous vertex, by the light's walk
  bool singular = false;      // both are probabilities of a delta distribution
  bool light_reaches = true;  // walks from lights may contain the vertex
  bool camera_sees = true;    // the camera's own rays may end here
  bool light_crosses = true;  // joins, and walks from lights, may contain the edge before it
  // Paths from lights times the area within which each is gathered, m^2; 0: nothing merges here.
  double merge_area = 0;
  // How often a join has the surface before it for the camera's end, for each path from a light
  // that ends here.
  double joins = 1;
};

// Where the path ends on the camera.
struct CameraEnd {
  Vec3f direction;        // unit, from v_1 to the lens
  double pdf_across = 0;  // of v_1, over area across the ray, given the lens point
};

// Where it ends on a light.
struct LightEnd {
  Vec3f direction;         // unit, from the last surface to the light
  double pdf_sampled = 0;  // of that direction by light sampling; delta lights: of the choice
  double pdf_emitted = 0;  // of the arriving ray by emission, over area across it and solid angle
                           // (or one of the two, where the other is a delta); 0: none starts here
  bool hittable = false;   // walks from the camera may meet the light by chance
  bool light_crosses = true;  // walks from lights may contain the last edge
};

// A path as a value. With no surfaces it is a light that the camera sees.
struct Path {
  CameraEnd camera;
  std::vector<PathSurface> surfaces;
  LightEnd light;
  bool joins = true;    // there are techniques that join two vertices
  bool merges = false;  // and such as merge two, where merge_area says so

  // Its number of vertices: n = s + t.
  size_t length() const { return surfaces.size() + 2; }
};

// Area densities of the path's surfaces, as logarithms, by number of the surface: as the camera's
// walk makes them, and the light's. The light's last one includes the direction of emission.
struct SurfacePdfs {
  std::vector<double> log_camera, log_light;
};
SurfacePdfs surface_pdfs(const Path& path);

// The logarithm of the density with which technique (s, n - s) makes the path, for s from 0 to
// n - 1; minus infinity where it cannot. For n = 2 there is (0, 2) alone: lights that the camera
// sees are left to its rays. Where the path merges, the densities of the techniques follow that
// merge at each surface in turn, from the camera on.
std::vector<double> technique_log_pdfs(const Path& path);

// The weights of the techniques by the balance or the power heuristic: they sum to 1, or are all 0
// where no technique makes the path (Veach 1997, section 9.2).
std::vector<double> technique_weights(const std::vector<double>& log_pdfs, bool power);

// The weights that the recursive form of mis.h gives to the path, as each technique in turn finds
// it; 0 where it cannot.
std::vector<double> recursive_weights(const Path& path, const MisHeuristic& heuristic);

}  // namespace vernier
