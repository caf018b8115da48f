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
// Of what divides a lobe's density: 0 only where there is no lobe.
constexpr float kLeastSpread = 1e-12f;
// Cosine between normals of surfaces that share photons.
constexpr float kSameSide = 0.5f;

}  // namespace

void DirectionLobes::add(Vec3f axis, float weight) {
  x_[count_] = axis.x, y_[count_] = axis.y, z_[count_] = axis.z;
  weight_[count_++] = weight;
}

void DirectionLobes::finish() {
  float total = 0.0f;
  for (const float weight : weight_) {
    total += weight;
  }
  if (!(total > 0.0f)) {
    count_ = 0;
    return;
  }
  // Squared distances to the nearest, which is the lobe itself, and to the next two. The width is
  // that to the second neighbour: two photons may be close by chance.
  std::array<float, kMost> nearest, second, third;
  nearest.fill(kInfinity), second.fill(kInfinity), third.fill(kInfinity);
  for (size_t j = 0; j < count_; ++j) {
    const float x = x_[j], y = y_[j], z = z_[j];
    for (size_t i = 0; i < kMost; ++i) {
      const float d2 = square(x_[i] - x) + square(y_[i] - y) + square(z_[i] - z);
      third[i] = std::min(third[i], std::max(second[i], d2));
      second[i] = std::min(second[i], std::max(nearest[i], d2));
      nearest[i] = std::min(nearest[i], d2);
    }
  }
  for (size_t i = 0; i < kMost; ++i) {
    alpha2_[i] = third[i] < kInfinity ? std::max(third[i], kLeastWidth) : kLoneWidth;
    weight_[i] /= total;
  }
}

// The density of the lobes is that of GGX's normals times their cosine (Walter et al. 2007,
// equations 33 and 35), with tan(theta)^2 in place of the cosine where that would cancel.
Vec3f DirectionLobes::sample(float u_lobe, Vec2f u) const {
  size_t i = 0;
  for (; i + 1 < count_ && !(u_lobe < weight_[i]); ++i) {
    u_lobe -= weight_[i];
  }
  const float tan2 = alpha2_[i] * u.x / (1.0f - u.x);
  const float cosine = 1.0f / std::sqrt(1.0f + tan2);
  const float sine = cosine * std::sqrt(tan2);
  const float phi = kTwoPi * u.y;
  return normalize(Frame(Vec3f{x_[i], y_[i], z_[i]})
                       .to_world({sine * std::cos(phi), sine * std::sin(phi), cosine}));
}

double DirectionLobes::pdf(Vec3f w) const {
  if (count_ == 0) {
    return 0.0;
  }
  std::array<float, kMost> terms;
  for (size_t i = 0; i < kMost; ++i) {
    const Vec3f axis{x_[i], y_[i], z_[i]};
    const float cosine = std::max(dot(axis, w), 0.0f);
    // Widths are at least kLeastWidth: nothing here is too small or too large for a float.
    const float spread = alpha2_[i] * cosine * cosine + length_squared(cross(axis, w));
    terms[i] = weight_[i] * alpha2_[i] * cosine / square(std::max(spread, kLeastSpread));
  }
  double sum = 0.0;
  for (const float term : terms) {
    sum += static_cast<double>(term);
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
