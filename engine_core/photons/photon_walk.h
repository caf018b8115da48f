// The walk of photons: from the lights, by chance from surface to surface, until they are absorbed
// or escape.
#pragma once

#include <cstdint>
#include <vector>

#include "integrators/integrator.h"
#include "paths/light_walk.h"
#include "photons/lobe_split.h"
#include "photons/photon.h"

namespace vernier {

// Where the power of photons went: watts (average of RGB) times paths. What was emitted was
// absorbed or escaped: exactly, but for the rounding of the float64 sums.
struct PhotonTally {
  uint64_t paths = 0;
  double emitted = 0, absorbed = 0, escaped = 0;
  double arrived = 0;  // at surfaces that scatter, at each of a path's: what maps may store

  void add(const PhotonTally& other) {
    paths += other.paths;
    emitted += other.emitted;
    absorbed += other.absorbed;
    escaped += other.escaped;
    arrived += other.arrived;
  }
};

// Photons as one job found them.
struct PhotonChunk {
  std::vector<Vec3f> positions;
  std::vector<Photon> photons;
  PhotonTally tally;
};

// Photons keep their power and are absorbed by chance instead (Jensen 2001, section 5.3): paths
// carry on with the probability of what they still carry.
inline Roulette photon_roulette(const Settings& settings) { return {settings, 1.0f, 0}; }

// Follows one photon and stores it wherever it meets a surface that scatters other than
// singularly, as `kinds` says. Without kIndirect it ends where it is no caustic any more.
class PhotonVisitor {
 public:
  PhotonVisitor(const EmissionSample& emission, const SegmentContext& segments, Walk& walk,
                uint8_t kinds, PhotonChunk& chunk)
      : emission_(emission), segments_(segments), walk_(walk), kinds_(kinds), chunk_(chunk) {}

  bool segment(const Walk& walk, const Ray&, bool found) {
    const double power = carried(walk);
    chunk_.tally.absorbed += before_ - power;
    before_ = power;
    if (!found) {
      chunk_.tally.escaped += power;
      before_ = 0.0;
    }
    return true;
  }

  PathVertex& vertex() { return vertex_; }

  bool arrive(const Walk& walk, PathVertex& v) {
    if (walk.depth.total == 0) {
      from_lamp_ = lit_through(emission_, segments_, walk.travelled);
      v.beta *= from_lamp_;
      if (is_black(from_lamp_) && is_black(v.bsdf.transparency)) {
        return false;  // the light does not shine there
      }
    }
    const bool indirect_wanted = (kinds_ & kind_bit(PhotonKind::kIndirect)) != 0;
    if (v.bsdf.connectible() && !is_black(v.beta)) {
      chunk_.tally.arrived += static_cast<double>(average(v.beta)) * medium_;
      const PhotonKind kind = kind_of(walk);
      if (kind == PhotonKind::kIndirect && !indirect_wanted) {
        return false;
      }
      if ((kinds_ & kind_bit(kind)) != 0) {
        chunk_.positions.push_back(v.point.p);
        chunk_.photons.emplace_back(v.beta, v.point.wo, v.point.ng, kind, walk.depth.total);
      }
    }
    gathered_ = gathered_lobes(v.bsdf);
    if (walk.depth.total == 0 && walk.depth.transparent == 0) {
      meets_specular_ = gathered_ == 0 || (v.bsdf.lobes() & ~gathered_) != 0;
      first_ = v.point.p;
    }
    // Nothing but specular lobes leads to caustics.
    return indirect_wanted || (v.bsdf.lobes() & (kLobeGlossy | kLobeSingular)) != 0;
  }

  void pass(const PathVertex&) {}
  void leave(const PathVertex& v, const BsdfSample& sample) {
    if (v.point.depth.total == 0) {
      walk_.beta *= from_lamp_;
    }
    medium_ *= static_cast<double>(square(sample.eta));
    const uint8_t followed = followed_lobes(gathered_);
    all_specular_ = all_specular_ && permits(followed, sample.lobe);
  }

  // Watts: basic radiance's share of the index undone.
  double carried(const Walk& walk) const {
    return static_cast<double>(average(walk.beta)) * medium_;
  }
  // To be called when the walk begins and when it has ended.
  void begin() {
    started_with_ = before_ = carried(walk_);
    chunk_.tally.emitted += before_;
  }
  void end() { chunk_.tally.absorbed += before_; }

  double started_with() const { return started_with_; }
  // Whether the first surface has specular lobes, and where it is.
  bool meets_specular() const { return meets_specular_; }
  Vec3f first() const { return first_; }

 private:
  PhotonKind kind_of(const Walk& walk) const {
    if (walk.depth.total == 0) {
      return PhotonKind::kDirect;
    }
    return all_specular_ ? PhotonKind::kCaustic : PhotonKind::kIndirect;
  }

  const EmissionSample& emission_;
  const SegmentContext segments_;
  Walk& walk_;
  const uint8_t kinds_;
  PhotonChunk& chunk_;
  PathVertex vertex_;
  double started_with_ = 0.0;
  double before_ = 0.0;  // the power that arrived at the last surface
  double medium_ = 1.0;  // squared index of where the walk is, over that of where it began
  Color from_lamp_ = splat(1.0f);  // what of the lamp's light reaches the ray's start
  uint8_t gathered_ = 0;           // at the last surface
  bool all_specular_ = true;
  bool meets_specular_ = false;
  Vec3f first_;
};

// Follows path number `index` of 2^log2_paths, of the sequence `seed`. `found(emission, visitor)`
// is called when it has ended.
template <class Found>
void trace_photon(const RenderContext& context, const EmissionGuide& guide, uint64_t seed,
                  uint32_t index, int log2_paths, uint8_t kinds, PhotonChunk& chunk,
                  RenderStats& stats, const Found& found) {
  const SobolSampler sampler(0, 0, index, log2_paths, seed);
  ++chunk.tally.paths;
  EmissionSample e;
  Walk walk;
  if (!start_at_light(context.scene, guide, sampler, e, walk, stats.non_finite)) {
    return;
  }
  const WalkContext<> walks{context.scene,
                            sampler,
                            context.cancelled,
                            BounceLimits(context.settings),
                            photon_roulette(context.settings),
                            stats.rays};
  PhotonVisitor visitor(e, {context.scene, walks.limits.transparent, stats.rays}, walk, kinds,
                        chunk);
  walk.most_bounces = walks.limits.total - 1;  // where it is gathered it scatters once more
  visitor.begin();
  random_walk(walks, walk, visitor);
  visitor.end();
  found(e, visitor);
}

}  // namespace vernier
