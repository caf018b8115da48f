#include "metropolis/caustic_guide.h"

#include <bit>
#include <cmath>

#include "math/float_environment.h"
#include "math/frame.h"
#include "math/parallel.h"
#include "photons/photon_walk.h"

namespace vernier {
namespace {

// The first paths: if they find no caustic there is none worth guiding to.
constexpr uint32_t kTrial = 1u << 12;
// Squared angles: of lobes without neighbours, and the least of all.
constexpr float kLoneWidth = 2.5e-3f, kLeastWidth = 1e-5f;
// Cosine between normals of surfaces that share photons.
constexpr float kSameSide = 0.5f;

}  // namespace

void DirectionLobes::add(Vec3f axis, float weight) { lobes_[count_++] = {axis, weight, 0.0f}; }

void DirectionLobes::finish() {
  float total = 0.0f;
  for (size_t i = 0; i < count_; ++i) {
    total += lobes_[i].weight;
    // To the second nearest: two photons may be close by chance.
    float nearest = kInfinity, second = kInfinity;
    for (size_t j = 0; j < count_; ++j) {
      if (j != i) {
        const float d2 = length_squared(lobes_[i].axis - lobes_[j].axis);
        second = std::min(second, std::max(nearest, d2));
        nearest = std::min(nearest, d2);
      }
    }
    lobes_[i].alpha2 = second < kInfinity ? std::max(second, kLeastWidth) : kLoneWidth;
  }
  if (!(total > 0.0f)) {
    count_ = 0;
  }
  for (size_t i = 0; i < count_; ++i) {
    lobes_[i].weight /= total;
  }
}

// The density of the lobes is that of GGX's normals times their cosine (Walter et al. 2007,
// equations 33 and 35), with tan(theta)^2 in place of the cosine where that would cancel.
Vec3f DirectionLobes::sample(float u_lobe, Vec2f u) const {
  size_t i = 0;
  for (; i + 1 < count_ && !(u_lobe < lobes_[i].weight); ++i) {
    u_lobe -= lobes_[i].weight;
  }
  const float tan2 = lobes_[i].alpha2 * u.x / (1.0f - u.x);
  const float cosine = 1.0f / std::sqrt(1.0f + tan2);
  const float sine = cosine * std::sqrt(tan2);
  const float phi = kTwoPi * u.y;
  return normalize(
      Frame(lobes_[i].axis).to_world({sine * std::cos(phi), sine * std::sin(phi), cosine}));
}

double DirectionLobes::pdf(Vec3f w) const {
  double sum = 0.0;
  for (size_t i = 0; i < count_; ++i) {
    const Lobe& lobe = lobes_[i];
    const auto cosine = static_cast<double>(dot(lobe.axis, w));
    if (cosine > 0.0) {
      const auto alpha2 = static_cast<double>(lobe.alpha2);
      const double spread =
          alpha2 * cosine * cosine + static_cast<double>(length_squared(cross(lobe.axis, w)));
      sum += static_cast<double>(lobe.weight) * alpha2 * cosine / (spread * spread);
    }
  }
  return sum * static_cast<double>(kInvPi);
}

CausticGuide::CausticGuide(const RenderContext& context, const EmissionGuide& guide, uint64_t seed,
                           uint32_t paths, RenderStats& stats) {
  std::vector<Vec3f> positions;
  const uint32_t trial = std::min(kTrial, paths);
  trace(context, guide, seed, 0, trial, positions, stats);
  if (positions.empty()) {
    return;
  }
  trace(context, guide, seed, trial, paths, positions, stats);
  tree_ = KdTree(positions, context.settings.threads);
  std::vector<Photon> ordered;
  ordered.reserve(photons_.size());
  for (uint32_t place = 0; place < tree_.size(); ++place) {
    ordered.push_back(photons_[tree_.index(place)]);
  }
  photons_ = std::move(ordered);
}

void CausticGuide::trace(const RenderContext& context, const EmissionGuide& guide, uint64_t seed,
                         uint32_t first, uint32_t last, std::vector<Vec3f>& positions,
                         RenderStats& stats) {
  constexpr uint32_t kParts = 16;
  std::vector<PhotonChunk> chunks(kParts);
  std::vector<RenderStats> done(kParts);
  parallel_for(kParts, context.settings.threads, [&](size_t part) {
    const FlushDenormals flush;
    const auto bound = [&](size_t i) {
      return first + static_cast<uint32_t>(static_cast<uint64_t>(last - first) * i / kParts);
    };
    for (uint32_t i = bound(part); i < bound(part + 1) && !context.cancelled; ++i) {
      trace_photon(context, guide, seed, i, 31, kind_bit(PhotonKind::kCaustic), chunks[part],
                   done[part], [](const EmissionSample&, const PhotonVisitor&) {});
    }
  });
  for (uint32_t part = 0; part < kParts; ++part) {
    const PhotonChunk& chunk = chunks[part];
    positions.insert(positions.end(), chunk.positions.begin(), chunk.positions.end());
    photons_.insert(photons_.end(), chunk.photons.begin(), chunk.photons.end());
    stats.rays += done[part].rays;
    stats.non_finite += done[part].non_finite;
  }
}

DirectionLobes CausticGuide::at(const SurfacePoint& point) const {
  DirectionLobes lobes;
  std::array<KdNeighbour, DirectionLobes::kMost> found;
  const size_t count = tree_.nearest(point.p, found.size(), kInfinity, found);
  for (size_t i = 0; i < count; ++i) {
    const Photon& photon = photons_[found[i].place];
    if (dot(photon.ng(), point.ng) > kSameSide) {
      lobes.add(photon.wi(), luminance(photon.power));
    }
  }
  lobes.finish();
  return lobes;
}

}  // namespace vernier
