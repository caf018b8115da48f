#include "metropolis/metropolis_plan.h"

#include <algorithm>
#include <cmath>

#include "math/float_environment.h"
#include "math/parallel.h"
#include "metropolis/primary_explorer.h"

namespace vernier {
namespace {

// The part of the choice of lengths that goes by a geometric series: a pilot has not seen all.
constexpr double kUnseen = 0.25;

// Samples of the pilot: this part of the render's, within these powers of two; and of one that has
// found no light.
constexpr double kPilotPart = 1.0 / 32.0;
constexpr int kLeastLog2 = 10, kMostLog2 = 14, kPatientLog2 = 18;
// The guide's paths: this part of the render's samples, within these limits.
constexpr double kGuidePart = 1.0 / 16.0, kLeastGuide = 1 << 14, kMostGuide = 1 << 18;
// What is darker than this part of the picture's mean is worth no more.
constexpr double kDark = 0.2;

// What a pilot finds.
struct Findings {
  int least;
  std::array<double, LengthChoice::kTable> by_length{};
  std::vector<double> by_cell = std::vector<double>(WorthMap::kSide * WorthMap::kSide);
  double total = 0;
  RenderStats stats;

  explicit Findings(int least_) : least(least_) {}
  void add(const FilmDesc& film, const Contribution& contribution) {
    for (const Splat& splat : contribution.splats) {
      const int at = std::min(splat.s + splat.t - least, LengthChoice::kTable - 1);
      by_length[static_cast<size_t>(at)] += splat.target;
      by_cell[WorthMap::cell(film, splat.raster)] += splat.target;
    }
    total += contribution.target;
  }
  void add(const Findings& other) {
    for (size_t i = 0; i < by_length.size(); ++i) {
      by_length[i] += other.by_length[i];
    }
    for (size_t i = 0; i < by_cell.size(); ++i) {
      by_cell[i] += other.by_cell[i];
    }
    total += other.total;
    stats.rays += other.stats.rays;
    stats.non_finite += other.stats.non_finite;
  }
};

// Samples `first` to `last`, on all threads; parts are added in their order.
Findings run_pilot(const RenderContext& context, uint64_t seed, uint32_t first, uint32_t last) {
  constexpr uint32_t kParts = 16;
  const int least = least_chain_vertices(context.settings);
  std::vector<Findings> parts(kParts, Findings(least));
  parallel_for(kParts, context.settings.threads, [&](size_t part) {
    const FlushDenormals flush;
    PrimaryEvaluator evaluator(context, parts[part].stats);
    Contribution contribution;
    const auto bound = [&](size_t i) {
      return first + static_cast<uint32_t>((last - first) * i / kParts);
    };
    for (uint32_t i = bound(part); i < bound(part + 1) && !context.cancelled; ++i) {
      evaluator.sample(SobolSampler(0, 0, i, kPatientLog2, seed), contribution);
      parts[part].add(context.scene.film, contribution);
    }
  });
  Findings all(least);
  for (const Findings& part : parts) {
    all.add(part);
  }
  return all;
}

// Each value with those around it.
std::vector<double> blurred(const std::vector<double>& cells) {
  constexpr int n = WorthMap::kSide, kReach = 2;
  std::vector<double> rows(cells.size()), result(cells.size());
  const auto at = [](int x, int y) { return static_cast<size_t>(y * n + x); };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int d = -kReach; d <= kReach; ++d) {
        rows[at(j, i)] += cells[at(std::clamp(j + d, 0, n - 1), i)] / (2 * kReach + 1);
      }
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int d = -kReach; d <= kReach; ++d) {
        result[at(j, i)] += rows[at(j, std::clamp(i + d, 0, n - 1))] / (2 * kReach + 1);
      }
    }
  }
  return result;
}

// Whether a direction may be drawn at a rough surface without a lobe: what comes after must not
// depend on which one it was.
bool may_guide(const RenderContext& context) {
  const Requirements& scene = context.scene.requirements;
  return scene.singular_lobes && !scene.path_dependent && !scene.uneven_visibility &&
         !BounceLimits::by_kind(context.settings);
}

}  // namespace

int least_chain_vertices(const Settings& settings) { return settings.separate_direct != 0 ? 4 : 3; }

LengthChoice::LengthChoice(const std::array<double, kTable>& amounts, int least, int most)
    : least_(least), tail_(most >= least + kTable) {
  double total = 0.0;
  for (const double amount : amounts) {
    total += amount;
  }
  double geometric = 1.0;
  for (size_t i = 0; i < kTable; ++i) {
    const bool last = i + 1 == kTable;
    const double series = geometric * (last && tail_ ? 1.0 : 1.0 - kFall);
    double p = (1.0 - kUnseen) * (total > 0.0 ? amounts[i] / total : 0.0) + kUnseen * series;
    geometric *= kFall;
    if (least + static_cast<int>(i) > most) {
      p = 0.0;
    }
    cdf_[i + 1] = cdf_[i] + p;
  }
  for (double& c : cdf_) {
    c /= cdf_[kTable];
  }
}

int LengthChoice::sample(float u) const {
  const double v = extend_bits(u);
  const auto next = std::upper_bound(cdf_.begin() + 1, cdf_.end() - 1, v);
  const auto i = static_cast<size_t>(next - cdf_.begin()) - 1;
  int length = least_ + static_cast<int>(i);
  if (tail_ && i + 1 == kTable) {
    const double left = (cdf_[kTable] - v) / (cdf_[kTable] - cdf_[kTable - 1]);
    length += std::max(static_cast<int>(std::log(left) / std::log(kTailFall)), 0);
  }
  return length;
}

double LengthChoice::probability(int length) const {
  const int i = length - least_;
  if (i < 0) {
    return 0.0;
  }
  if (i < kTable - 1 || !tail_) {
    return i < kTable ? cdf_[static_cast<size_t>(i) + 1] - cdf_[static_cast<size_t>(i)] : 0.0;
  }
  return (cdf_[kTable] - cdf_[kTable - 1]) * std::pow(kTailFall, i - kTable + 1) *
         (1.0 - kTailFall);
}

size_t WorthMap::cell(const FilmDesc& film, Vec2f raster) {
  const auto index = [](float at, int first, int end) {
    const float u = (at - static_cast<float>(first)) / static_cast<float>(end - first);
    return std::clamp(static_cast<int>(u * static_cast<float>(kSide)), 0, kSide - 1);
  };
  return static_cast<size_t>(index(raster.y, film.crop[1], film.crop[3]) * kSide +
                             index(raster.x, film.crop[0], film.crop[2]));
}

WorthMap::WorthMap(const FilmDesc& film, const std::vector<double>& light)
    : first_{static_cast<float>(film.crop[0]), static_cast<float>(film.crop[1])},
      inverse_size_{kSide / static_cast<float>(film.crop[2] - film.crop[0]),
                    kSide / static_cast<float>(film.crop[3] - film.crop[1])} {
  double mean = 0.0;
  for (const double cell : light) {
    mean += cell / static_cast<double>(light.size());
  }
  if (!(mean > 0.0)) {
    return;
  }
  for (const double cell : blurred(light)) {
    cells_.push_back(static_cast<float>(1.0 / (cell / mean + kDark)));
  }
}

float WorthMap::operator()(Vec2f raster) const {
  if (cells_.empty()) {
    return 1.0f;
  }
  const auto index = [](float at) {
    return static_cast<size_t>(clamp(at, 0.0f, static_cast<float>(kSide - 1)));
  };
  return cells_[index((raster.y - first_.y) * inverse_size_.y) * kSide +
                index((raster.x - first_.x) * inverse_size_.x)];
}

std::string MetropolisPlan::nothing() const {
  return black
             ? "No light reaches the camera: " + std::to_string(pilot_samples) + " paths found none"
             : std::string();
}

std::unique_ptr<const Plan> make_metropolis_plan(const RenderContext& context, uint64_t seed,
                                                 RenderStats& stats) {
  auto plan = std::make_unique<MetropolisPlan>();
  static_cast<BidirectionalPlan&>(*plan) =
      static_cast<const BidirectionalPlan&>(*make_bidirectional_plan(context, seed, stats));
  const int most = context.settings.max_bounces < 0 ? std::numeric_limits<int>::max()
                                                    : context.settings.max_bounces + 3;
  const int least = least_chain_vertices(context.settings);
  if (most < least) {
    plan->chains = false;
    return plan;
  }
  RenderContext pilot = context;
  pilot.plan = plan.get();
  const FilmDesc& film = context.scene.film;
  const double samples = static_cast<double>(film.crop[2] - film.crop[0]) *
                         static_cast<double>(film.crop[3] - film.crop[1]) *
                         context.settings.samples;
  const uint64_t own_seed = hash64(seed ^ 0x6d6c74u);
  if (may_guide(context)) {
    plan->caustics = CausticGuide(
        pilot, plan->guide, hash64(own_seed ^ 0x67756964u),
        static_cast<uint32_t>(std::clamp(samples * kGuidePart, kLeastGuide, kMostGuide)), stats);
  }
  Findings found(least);
  uint32_t done = 0;
  for (int log2 =
           std::clamp(std::ilogb(std::max(samples * kPilotPart, 1.0)), kLeastLog2, kMostLog2);
       log2 <= kPatientLog2 && !(found.total > 0.0); log2 += 2) {
    found.add(run_pilot(pilot, own_seed, done, 1u << log2));
    done = 1u << log2;
  }
  plan->pilot_samples = done;
  plan->black = !(found.total > 0.0) && !(plan->inverse_threshold < kInfinity);
  plan->chains = !plan->black;
  stats.rays += found.stats.rays;
  stats.non_finite += found.stats.non_finite;
  plan->worth = WorthMap(film, found.by_cell);
  for (size_t i = 0; i < found.by_cell.size(); ++i) {
    const int x = static_cast<int>(i) % WorthMap::kSide, y = static_cast<int>(i) / WorthMap::kSide;
    plan->scale += found.by_cell[i] / done * static_cast<double>(plan->worth.at(x, y));
  }
  plan->lengths = LengthChoice(found.by_length, least, most);
  return plan;
}

}  // namespace vernier
