// Mutations of whole paths (Veach and Guibas 1997, section 5.3; Veach 1997, section 11.4).
//
// Each proposes `to` from `from` and returns the logarithm of the ratio of the densities of the way
// back and of the way there, with the geometry of both paths: what an acceptance needs beside their
// targets. Minus infinity: the mutation does not suit the path, or has found nothing.
#pragma once

#include "metropolis/chain_path.h"

namespace vernier {

// Deletes some surfaces and grows any number in their place, from both sides.
double mutate_bidirectionally(PathSpace& space, const PathState& from, PathState& to);
// A new path, whatever the last one was.
double propose_new_path(PathSpace& space, const PathState& from, PathState& to);
// Moves the raster position, follows mirrors and glass as before, and joins what is rough to the
// rest. Where several chains of mirrors part rough surfaces, the directions at these are moved too:
// lens and multi-chain perturbation in one.
double perturb_from_camera(PathSpace& space, const PathState& from, PathState& to);
// The same from the light, to a rough surface that the camera sees: caustic perturbation.
double perturb_from_light(PathSpace& space, const PathState& from, PathState& to);
// Draws the part from the lens to the first rough surface anew, for the raster position given by
// the caller: lens sub-path mutation.
double replace_lens_subpath(PathSpace& space, Vec2f raster, const PathState& from, PathState& to);

}  // namespace vernier
