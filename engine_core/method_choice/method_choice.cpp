#include "method_choice/method_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <vector>

#include "accuracy/neighbourhood.h"
#include "accuracy/statement.h"
#include "camera/camera.h"
#include "method_choice/candidates.h"
#include "render/session.h"
#include "scene/compile.h"

namespace vernier {
namespace {

constexpr double kShare = 0.05;  // of the budget
constexpr int kSamples = 32;     // per pixel of a pilot
constexpr int kLeastSamples = 16;
constexpr double kMostPixels = 96.0 * 64.0, kLeastPixels = 20.0 * 20.0;
// What all candidates' samples cost together, in path tracing's: a guess on the safe side.
constexpr double kCostOfAll = 8.0;
// Above this many samples a render has no end in sight.
constexpr int kEndless = 1 << 20;
// A method that finds caustics is preferred while the pilot says that it takes no longer than this.
constexpr double kRobustFactor = 1.25;
// The same where pilots have fewer pixels than kSmallPilot, which may well have missed what
// matters.
constexpr double kRobustFactorOfSmall = 2.0, kSmallPilot = 40.0 * 40.0;
// Where rare bright pixels make another method look slower than one that finds caustics by this
// factor, they are what the pilot cannot tell.
constexpr double kRareFactor = 8.0;
// Where the better half of the picture, most of it, its tail, and all of it agree that a method
// which finds caustics is slower by this factor, the pilot tells clearly, if it has pixels enough.
constexpr double kClearFactor = 1.15;
// Chains are chosen where they are faster than all else by this factor...
constexpr double kChainFactor = 1.6;
// ...or where single batches of a method that finds caustics carry this part of the light, so that
// what pilots of independent samples say is of what they happened to meet, and the chains met more
// than all but those batches by this factor. Without it glossy scenes would go to them, too.
constexpr double kRareLight = 0.1, kFoundFactor = 1.25;
constexpr int kBlock = 8;  // pixels a side: what is compared between methods
constexpr double kTrim = 0.95;
constexpr double kDeviations = 4.0;

// What one candidate's small picture tells.
struct Pilot {
  const Candidate* candidate = nullptr;
  double cost = 0;  // of a sample of a pixel
  double samples = 0;
  double mean = 0;  // luminance
  int width = 0, height = 0;
  std::vector<PixelEstimate> pixels;
  std::vector<float> variances;  // relative, of neighbourhoods (accuracy/picture_error.h)
};

// Sums of pixels within a block.
struct Block {
  double mean = 0, variance = 0;
};

std::vector<Block> blocks(const Pilot& pilot) {
  const int columns = (pilot.width + kBlock - 1) / kBlock,
            rows = (pilot.height + kBlock - 1) / kBlock;
  std::vector<Block> sums(static_cast<size_t>(columns) * static_cast<size_t>(rows));
  std::vector<double> counts(sums.size());
  for (int y = 0; y < pilot.height; ++y) {
    for (int x = 0; x < pilot.width; ++x) {
      const auto i =
          static_cast<size_t>(y) * static_cast<size_t>(pilot.width) + static_cast<size_t>(x);
      const auto b = static_cast<size_t>(y / kBlock) * static_cast<size_t>(columns) +
                     static_cast<size_t>(x / kBlock);
      sums[b].mean += pilot.pixels[i].mean;
      sums[b].variance += pilot.pixels[i].variance;
      ++counts[b];
    }
  }
  for (size_t b = 0; b < sums.size(); ++b) {
    sums[b].mean /= counts[b];
    // Errors of a chain's pixels may be all alike.
    sums[b].variance /= pilot.candidate->chains ? counts[b] : counts[b] * counts[b];
  }
  return sums;
}

// Mean of all but the largest values, up to this share.
double mean_below(std::vector<float> values, double share) {
  const auto kept = static_cast<ptrdiff_t>(std::ceil(share * static_cast<double>(values.size())));
  if (kept == 0) {
    return 0.0;
  }
  std::nth_element(values.begin(), values.begin() + kept - 1, values.end());
  return std::accumulate(values.begin(), values.begin() + kept, 0.0) / static_cast<double>(kept);
}

// Squared relative light that `pilot` has not met and `other` has, beyond what noise explains.
double missed(const Pilot& pilot, const Pilot& other) {
  const std::vector<Block> own = blocks(pilot), others = blocks(other);
  std::vector<double> squares(own.size());
  for (size_t b = 0; b < own.size(); ++b) {
    const double noise = std::sqrt(own[b].variance + others[b].variance);
    const double gap = others[b].mean - own[b].mean - kDeviations * noise;
    const double scale = std::max(others[b].mean, kErrorFloor * other.mean);
    squares[b] = gap > 0.0 && scale > 0.0 ? (gap / scale) * (gap / scale) : 0.0;
  }
  double sum = 0.0;
  for (const double square : squares) {
    sum += square;
  }
  return squares.empty() ? 0.0 : sum / static_cast<double>(squares.size());
}

// Time to a relative standard deviation of 1, in units that all candidates share.
struct Needed {
  double half = 0;  // by the better half of the picture
  double usual =
      0;  // without the largest variances: single pixels of a small picture decide little
  double worst = 0;  // with them
  double tail = 0;   // by the neighbourhood that a picture's error is of (accuracy/statement.h)
};

Needed time_needed(const Pilot& pilot, const std::vector<Pilot>& all) {
  double lack = 0.0;
  for (const Pilot& other : all) {
    lack = std::max(lack, missed(pilot, other));
  }
  const double work = pilot.cost * pilot.samples;
  std::vector<float> variances = pilot.variances;
  const double percentile = error_percentile(variances, kErrorPercentile);
  return {work * (mean_below(pilot.variances, 0.5) + lack),
          work * (mean_below(pilot.variances, kTrim) + lack),
          work * (mean_below(pilot.variances, 1.0) + lack), work * (percentile + lack)};
}

// Pixels that each candidate's picture may have.
double pilot_pixels(const Scene& scene, const Settings& settings) {
  const std::array<int32_t, 4>& crop = scene.film.crop;
  const double pixels = static_cast<double>(crop[2] - crop[0]) * (crop[3] - crop[1]);
  if (settings.samples >= kEndless) {
    return kMostPixels;
  }
  return std::min(kMostPixels, pixels * settings.samples * kShare / (kSamples * kCostOfAll));
}

Pilot try_out(const Candidate& candidate, const std::shared_ptr<const Scene>& scene,
              const Settings& given, double seconds, const std::atomic<bool>& cancelled) {
  Settings settings = given;
  settings.integrator = static_cast<int>(candidate.kind);
  settings.samples = kSamples;
  settings.target_error = 0.0;
  settings.time_limit = seconds;
  Session session(scene, settings, PassSet());
  session.start();
  constexpr double kPoll = 0.02;
  while (!session.wait(kPoll)) {
    if (cancelled) {
      session.cancel();
    }
  }
  const Progress progress = session.poll(false);
  Pilot pilot;
  pilot.candidate = &candidate;
  pilot.width = session.film().width();
  pilot.height = session.film().height();
  // A picture with gaps cannot be compared with others.
  pilot.samples = session.film().least_batches() > 0 ? progress.samples : 0.0;
  pilot.pixels = session.film().estimates();
  pilot.variances = session.film().picture_errors().variances;
  const double taken = pilot.samples * static_cast<double>(pilot.pixels.size());
  pilot.cost =
      taken > 0.0 ? candidate.cost_per_ray * static_cast<double>(progress.rays) / taken : 0.0;
  for (const PixelEstimate& p : pilot.pixels) {
    pilot.mean += p.mean / static_cast<double>(pilot.pixels.size());
  }
  return pilot;
}

std::string capitalised(std::string_view text) {
  std::string result(text);
  result[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(result[0])));
  return result;
}

std::string ratio_text(double ratio) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), ratio < 10.0 ? "%.1f" : "%.0f", ratio);
  return text.data();
}

// The film of the whole frame with about this many pixels.
FilmDesc small_film(const FilmDesc& film, double pixels) {
  const double share = static_cast<double>(film.crop[2] - film.crop[0]) *
                       (film.crop[3] - film.crop[1]) /
                       (static_cast<double>(film.width) * film.height);
  const double scale =
      std::min(1.0, std::sqrt(pixels / (share * static_cast<double>(film.width) * film.height)));
  FilmDesc small = film;
  small.width = std::max(1, static_cast<int32_t>(std::lround(film.width * scale)));
  small.height = std::max(1, static_cast<int32_t>(std::lround(film.height * scale)));
  const auto place = [](int32_t at, int32_t from, int32_t to) {
    return static_cast<int32_t>(static_cast<int64_t>(at) * to / from);
  };
  const int32_t x0 = place(film.crop[0], film.width, small.width);
  const int32_t y0 = place(film.crop[1], film.height, small.height);
  small.crop = {x0, y0, std::max(x0 + 1, place(film.crop[2], film.width, small.width)),
                std::max(y0 + 1, place(film.crop[3], film.height, small.height))};
  return small;
}

std::vector<const Candidate*> fitting_candidates(const Settings& settings,
                                                 const Requirements& requirements, PassSet passes) {
  std::vector<const Candidate*> fitting;
  for (const Candidate& c : candidates()) {
    if (c.fits(settings, requirements, passes)) {
      fitting.push_back(&c);
    }
  }
  return fitting;
}

MethodChoice chosen(const Candidate& candidate, const std::string& why) {
  return {candidate.kind, capitalised(candidate.name) + ": " + why};
}

// What is known of a scene where nothing was tried.
std::string untried(bool caustics) {
  return caustics ? "the scene may have caustics" : "the scene has no caustics";
}

// The choice where nothing could be tried.
const Candidate& robust(const std::vector<const Candidate*>& fitting, bool caustics) {
  for (const Candidate* c : fitting) {
    if (caustics && c->finds_caustics) {
      return *c;
    }
  }
  return *fitting.front();
}

// What all pilots tell, in their order. Times are relative to each other.
struct Trial {
  std::vector<Pilot> pilots;
  std::vector<double> half, times, worst, tail;  // Needed
};

std::string compare(const Trial& trial, size_t best) {
  std::string text;
  for (size_t i = 0; i < trial.pilots.size(); ++i) {
    if (i != best && trial.times[best] > 0.0) {
      text += (text.empty() ? "" : ", ") + ratio_text(trial.times[i] / trial.times[best]) +
              " times " + std::string(trial.pilots[i].candidate->name);
    }
  }
  return text;
}

size_t fastest_without_chains(const Trial& trial) {
  size_t fastest = 0;  // path tracing
  for (size_t i = 1; i < trial.pilots.size(); ++i) {
    if (!trial.pilots[i].candidate->chains && trial.times[i] < trial.times[fastest]) {
      fastest = i;
    }
  }
  return fastest;
}

// Chains that are clearly faster than `fastest`, for most pixels and for all.
std::optional<size_t> faster_chains(const Trial& trial, size_t fastest) {
  for (size_t i = 0; i < trial.pilots.size(); ++i) {
    if (trial.pilots[i].candidate->chains && kChainFactor * trial.times[i] < trial.times[fastest] &&
        kChainFactor * trial.worst[i] < trial.worst[fastest]) {
      return i;
    }
  }
  return std::nullopt;
}

// The part of the light that single batches brought, without edges of what is bright: those are
// rare in a pixel and sure in the picture.
double rare_light(const Pilot& pilot) {
  const std::vector<double> excess = shared_excess(pilot.pixels, pilot.width, pilot.height);
  const double rare = std::accumulate(excess.begin(), excess.end(), 0.0);
  const double all = pilot.mean * static_cast<double>(pilot.pixels.size());
  return all > 0.0 ? rare / all : 0.0;
}

// Chains, where independent samples that should find caustics find them by luck.
std::optional<size_t> chains_for_rare_light(const Trial& trial) {
  std::optional<size_t> chains;
  double met = std::numeric_limits<double>::infinity();  // often, where much is met rarely
  for (size_t i = 0; i < trial.pilots.size(); ++i) {
    const Pilot& pilot = trial.pilots[i];
    if (pilot.candidate->chains) {
      chains = i;
    } else if (pilot.candidate->finds_caustics) {
      const double rare = rare_light(pilot);
      met = rare > kRareLight ? std::min(met, (1.0 - rare) * pilot.mean) : met;
    }
  }
  return chains && trial.pilots[*chains].mean > kFoundFactor * met ? chains : std::nullopt;
}

// A method that finds caustics, where `fastest` does not and the pilots do not tell clearly.
std::optional<size_t> preferred_for_caustics(const Trial& trial, size_t fastest) {
  const Pilot& best = trial.pilots[fastest];
  if (best.candidate->finds_caustics) {
    return std::nullopt;
  }
  const bool small = static_cast<double>(best.pixels.size()) < kSmallPilot;
  const double factor = small ? kRobustFactorOfSmall : kRobustFactor;
  for (size_t i = 0; i < trial.pilots.size(); ++i) {
    const Candidate& candidate = *trial.pilots[i].candidate;
    const auto slower = [&](const std::vector<double>& times, double than) {
      return times[i] > than * times[fastest];
    };
    if (!small && slower(trial.half, kClearFactor) && slower(trial.times, kClearFactor) &&
        slower(trial.tail, kClearFactor) && slower(trial.worst, kClearFactor)) {
      continue;
    }
    const bool unclear = !slower(trial.times, factor) || !slower(trial.half, factor) ||
                         !slower(trial.tail, factor) ||
                         kRareFactor * trial.worst[i] <= trial.worst[fastest];
    if (candidate.finds_caustics && !candidate.chains && unclear) {
      return i;
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<MethodChoice> choose_untried(const Scene& scene, const Settings& settings,
                                           PassSet passes, bool interactive) {
  const auto named = static_cast<IntegratorKind>(settings.integrator);
  if (named != IntegratorKind::kAuto) {
    return MethodChoice{named, ""};
  }
  const std::vector<const Candidate*> fitting =
      fitting_candidates(settings, scene.requirements, passes);
  if (interactive) {
    return chosen(*fitting.front(), "the first picture comes soonest");
  }
  if (fitting.size() == 1) {
    return chosen(*fitting.front(), "the only method for this scene");
  }
  if (pilot_pixels(scene, settings) < kLeastPixels) {
    const bool caustics = scene.requirements.caustics;
    return chosen(robust(fitting, caustics),
                  untried(caustics) + ", and the render is too short to try others");
  }
  return std::nullopt;
}

MethodChoice choose_by_trial(const std::shared_ptr<const Scene>& scene, const Settings& settings,
                             PassSet passes, const std::atomic<bool>& cancelled) {
  const std::vector<const Candidate*> fitting =
      fitting_candidates(settings, scene->requirements, passes);
  const bool caustics = scene->requirements.caustics;
  const auto small = with_view(scene, scene->camera->desc(),
                               small_film(scene->film, pilot_pixels(*scene, settings)));
  const double seconds = settings.time_limit * kShare / static_cast<double>(fitting.size());
  std::vector<Pilot> pilots;
  for (const Candidate* c : fitting) {
    Pilot pilot = try_out(*c, small, settings, seconds, cancelled);
    if (pilot.samples >= kLeastSamples) {
      pilots.push_back(std::move(pilot));
    } else if (!c->chains) {
      return chosen(robust(fitting, caustics),
                    untried(caustics) + ", and there is too little time to try others");
    }
  }
  Trial trial{std::move(pilots), {}, {}, {}, {}};
  for (const Pilot& pilot : trial.pilots) {
    const Needed needed = time_needed(pilot, trial.pilots);
    trial.half.push_back(needed.half);
    trial.times.push_back(needed.usual);
    trial.worst.push_back(needed.worst);
    trial.tail.push_back(needed.tail);
  }
  const size_t fastest = fastest_without_chains(trial);
  if (const std::optional<size_t> chain = faster_chains(trial, fastest)) {
    return chosen(*trial.pilots[*chain].candidate, compare(trial, *chain));
  }
  if (caustics) {
    if (const std::optional<size_t> chain = chains_for_rare_light(trial)) {
      return chosen(*trial.pilots[*chain].candidate,
                    "it looks for caustics first, of which others meet single paths by chance");
    }
    if (const std::optional<size_t> safe = preferred_for_caustics(trial, fastest)) {
      return chosen(*trial.pilots[*safe].candidate,
                    compare(trial, *safe) + "; preferred because the scene may have caustics");
    }
  }
  return chosen(*trial.pilots[fastest].candidate, compare(trial, fastest));
}

}  // namespace vernier
