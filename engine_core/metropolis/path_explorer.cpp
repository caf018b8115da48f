#include "metropolis/path_explorer.h"

#include <algorithm>
#include <cmath>

namespace vernier {
namespace {

// How often each mutation is tried, of those that are no large steps. They are the same for all
// paths: what does not suit one is a rejection that costs nothing.
constexpr float kBidirectional = 0.3f, kFromCamera = 0.4f, kFromLight = 0.1f;

}  // namespace

bool take_path(PathSpace& space, const FoundPath& found, const BidirectionalMemory& memory,
               Vec2f raster, PathState& path) {
  path.v.clear();
  const auto follow = [&](const Subpath& subpath, const PathVertex* v) {
    const size_t first = path.v.size();
    for (;; v = &subpath[v->parent]) {
      ChainVertex made;
      made.point = v->point;
      made.point.ray_flags = 0;
      made.point.depth = PathDepth{};
      path.v.push_back(made);
      if (v->parent == kNoIndex) {
        return first;
      }
    }
  };
  if (found.z != nullptr) {
    follow(memory.camera, found.z);
    std::reverse(path.v.begin(), path.v.end());
  }
  const size_t from_camera = path.v.size();
  if (found.y != nullptr) {
    follow(memory.light, found.y);
  }
  const size_t k = path.v.size();
  if (k < space.least) {
    return false;
  }
  std::vector<Vec3f> to_camera(k), to_light(k);
  for (size_t i = 0; i < k; ++i) {
    const bool by_camera = i < from_camera;
    const Vec3f wo = path.v[i].point.wo;
    if (by_camera) {
      to_camera[i] = wo;
      to_light[i] = i + 1 < from_camera ? -path.v[i + 1].point.wo : found.wi;
    } else {
      to_light[i] = wo;
      to_camera[i] =
          i > from_camera ? -path.v[i - 1].point.wo : (from_camera > 0 ? -found.wi : found.wi);
    }
  }
  for (size_t i = 0; i < k; ++i) {
    ChainVertex& v = path.v[i];
    v.to_light = to_light[i];
    v.point = seen_from(v.point, to_camera[i]);
    const bool joined = i < from_camera ? found.s > 0 && i + 1 == from_camera : i == from_camera;
    v.event = joined ? uint8_t{0} : space.event_toward(v.point, v.to_light);
  }
  path.end.light = found.light;
  for (size_t i = 0; space.passes() && i < k; ++i) {
    if (!(i > 0 ? space.see_between(path, i - 1) : space.see_to_lens(path))) {
      return false;
    }
  }
  return space.see_lens(raster, path) && space.see_light(path) && space.evaluate(path);
}

double PathExplorer::start(const SobolSampler& source, Pcg32& rng, MarkovChain<State>& chain) {
  evaluator_.sample(source, sample_);
  space_.seed(Pcg32(rng.next()));
  PathState& at = chain.current;
  at.v.clear();
  at.clear();
  if (!(sample_.target > 0.0)) {
    return 0.0;  // the render was cancelled before the sample had found the light it has
  }
  const size_t chosen = sample_.choose(rng.next_float());
  size_t count = 0;
  bool taken = false;
  Contribution again;
  evaluator_.sample(source, again, [&](const FoundPath& found) {
    if (count++ == chosen) {
      taken = take_path(space_, found, evaluator_.memory(), sample_.splats[chosen].raster, at);
    }
  });
  if (!taken) {
    // On a rim or at grazing angles, by rounding: the chain stays where it is.
    at.v.clear();
    at.clear();
    at.splats.push_back(sample_.splats[chosen]);
    at.target = sample_.splats[chosen].target;
    at.independent_target = static_cast<double>(kInfinity);
  }
  return sample_.target;
}

Vec2f PathExplorer::stratified_raster() {
  // Roberts's sequence, turned at random at every step.
  const uint64_t turn = hash64(frame_seed_ + step_);
  const auto at = [&](double multiplier, uint32_t bits) {
    const double u = static_cast<double>(number_) * multiplier + to_unit_float(bits);
    return std::min(static_cast<float>(u - std::floor(u)), kOneMinusEpsilon);
  };
  return space_.film.raster({at(0.7548776662466927, static_cast<uint32_t>(turn)),
                             at(0.5698402909980532, static_cast<uint32_t>(turn >> 32))});
}

double PathExplorer::propose(MarkovChain<State>& chain, bool large) {
  ++step_;
  ++stats_.camera_paths;
  const PathState& from = chain.current;
  PathState& to = chain.proposed;
  const float u = space_.random();
  double log_ratio;
  if (from.v.empty()) {
    to.clear();
    return 0.0;
  }
  if (large) {
    log_ratio = propose_new_path(space_, from, to);
  } else if (u < kBidirectional) {
    log_ratio = mutate_bidirectionally(space_, from, to);
  } else if (u < kBidirectional + kFromCamera) {
    log_ratio = perturb_from_camera(space_, from, to);
  } else if (u < kBidirectional + kFromCamera + kFromLight) {
    log_ratio = perturb_from_light(space_, from, to);
  } else {
    log_ratio = replace_lens_subpath(space_, stratified_raster(), from, to);
  }
  if (!std::isfinite(log_ratio)) {
    to.clear();
    return 0.0;
  }
  return std::exp(std::min(log_ratio, 700.0));
}

}  // namespace vernier
