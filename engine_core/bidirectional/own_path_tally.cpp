#include "bidirectional/own_path_tally.h"

#include <algorithm>
#include <cmath>

#include "math/variance.h"

namespace vernier {
namespace {

// No fewer samples than this have one: a pilot does not see what is rare.
constexpr double kLeastPart = 0.25, kLeastPartBesideShared = 0.125;

}  // namespace

void OwnPathTally::add(const OwnPathTally& other) {
  picture_.add(other.picture_);
  splats_.insert(splats_.end(), other.splats_.begin(), other.splats_.end());
  samples_.insert(samples_.end(), other.samples_.begin(), other.samples_.end());
  light_rays_ += other.light_rays_;
}

// With a part q of the samples, a sample costs C + q c and has the variance V + v / q, where c and
// v are of what light paths take and bring. The product is least for q^2 = (C v) / (c V). That the
// weights move to the other techniques as q falls is left out: it makes the loss smaller.
double OwnPathTally::part(uint64_t rays, bool shared) const {
  if (samples_.empty() || light_rays_ == 0) {
    return 1.0;
  }
  const auto brightness = picture_.brightness();
  const double count = picture_.samples();
  Variance met, joined;
  for (const Sample& s : samples_) {
    const double scale = 1.0 / brightness[s.pixel];
    const double own = static_cast<double>(s.joined) * scale;
    met.add(static_cast<double>(s.met) * scale + (shared ? own : 0.0));
    joined.add(shared ? 0.0 : own);
  }
  // A pixel has as many splats as others: their number varies as well.
  double splatted = 0.0;
  for (const Splat& s : splats_) {
    const double relative = static_cast<double>(s.amount) / brightness[s.pixel];
    splatted += relative * relative / count;
  }
  const double least = shared ? kLeastPartBesideShared : kLeastPart;
  const double of_light = joined.value() + splatted, of_camera = met.value();
  const double light_rays = static_cast<double>(light_rays_);
  const double camera_rays = std::max(static_cast<double>(rays) - light_rays, 0.0);
  const double best = std::sqrt(camera_rays / light_rays * (of_light / of_camera));
  return std::isfinite(best) ? std::clamp(best, least, 1.0) : 1.0;
}

}  // namespace vernier
