#include "integrators/photon_plan.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "bidirectional/emission_learning.h"
#include "bidirectional/plan.h"
#include "math/float_environment.h"
#include "math/parallel.h"
#include "photons/photon_walk.h"

namespace vernier {
namespace {

// Paths of a pilot: first so many, then ever twice as many until some are found that were looked
// for, up to the bound that says that there are none.
constexpr uint32_t kFirstPaths = 1u << 13, kMostPaths = 1u << 18;
// What is found in fewer paths than these is not known well enough.
constexpr uint64_t kEnough = 64;
// A map takes no more paths than these for each photon that is asked for.
constexpr uint64_t kPathsOfPhoton = 16;
// Standard deviations that the number of photons may stay below its mean without a second round.
constexpr double kDeviations = 4.0;

struct Findings {
  EmissionTally tally;                // of paths whose first surface is specular
  std::vector<Vec3f> first;           // those surfaces
  std::array<uint64_t, 3> photons{};  // by kind
  uint64_t paths = 0;
  RenderStats stats;

  explicit Findings(uint32_t lights) : tally(lights) {}

  uint64_t count(uint8_t kinds) const {
    uint64_t sum = 0;
    for (size_t kind = 0; kind < photons.size(); ++kind) {
      sum += (kinds >> kind & 1u) != 0 ? photons[kind] : 0;
    }
    return sum;
  }
  void add(Findings& other) {
    tally.add(other.tally);
    first.insert(first.end(), other.first.begin(), other.first.end());
    for (size_t kind = 0; kind < photons.size(); ++kind) {
      photons[kind] += other.photons[kind];
    }
    paths += other.paths;
    stats.rays += other.stats.rays;
    stats.non_finite += other.stats.non_finite;
  }
};

void run_pilot(const RenderContext& context, const EmissionGuide& guide, uint64_t seed,
               int log2_paths, uint32_t first, uint32_t last, uint8_t kinds, Findings& found) {
  const FlushDenormals flush;
  PhotonChunk chunk;
  for (uint32_t i = first; i < last && !context.cancelled; ++i) {
    ++found.paths;
    trace_photon(context, guide, seed, i, log2_paths, kinds, chunk, found.stats,
                 [&](const EmissionSample& e, const PhotonVisitor& visitor) {
                   if (visitor.meets_specular()) {
                     const auto power = visitor.started_with();
                     found.tally.by_light[e.light] += power;
                     found.tally.credit(EmissionOrigin(guide, e), e.light, power);
                     found.first.push_back(visitor.first());
                   }
                 });
    for (const Photon& photon : chunk.photons) {
      ++found.photons[static_cast<size_t>(photon.kind)];
    }
    chunk.photons.clear();
    chunk.positions.clear();
  }
}

// Paths until `wanted` finds enough. Parts are added in their order: threads do not matter.
template <class Wanted>
Findings run_pilot(const RenderContext& context, const EmissionGuide& guide, uint64_t seed,
                   uint8_t kinds, const Wanted& wanted) {
  constexpr uint32_t kParts = 16;
  const uint32_t lights = context.scene.lights->count();
  Findings all(lights);
  for (uint32_t paths = kFirstPaths; all.paths < kMostPaths && wanted(all) < kEnough; paths *= 2) {
    std::vector<Findings> parts(kParts, Findings(lights));
    const int log2_paths = std::bit_width(paths - 1);
    const uint64_t own = hash64(hash64(~seed) + paths + kinds);
    parallel_for(kParts, context.settings.threads, [&](size_t i) {
      run_pilot(context, guide, own, log2_paths, static_cast<uint32_t>(paths * i / kParts),
                static_cast<uint32_t>(paths * (i + 1) / kParts), kinds, parts[i]);
    });
    for (Findings& part : parts) {
      all.add(part);
    }
    if (context.cancelled) {
      break;
    }
  }
  return all;
}

// A map of `least` photons of `kinds`, of which the pilot found so many.
PhotonOrder order_of(const EmissionGuide& guide, uint8_t kinds, int least, const Findings& pilot) {
  PhotonOrder order;
  order.guide = &guide;
  order.kinds = kinds;
  order.least = static_cast<uint64_t>(least);
  order.most_paths = order.least * kPathsOfPhoton;
  const auto found = static_cast<double>(pilot.count(kinds));
  const auto wanted = static_cast<double>(least);
  const double each = found / static_cast<double>(pilot.paths);
  const double paths =
      std::ceil(wanted / each * (1.0 + kDeviations * std::sqrt(1.0 / found + 1.0 / wanted)));
  order.paths = paths < static_cast<double>(order.most_paths) ? static_cast<uint64_t>(paths)
                                                              : order.most_paths;
  return order;
}

// What the user should know of a map of `least` photons that was ordered so; empty: it will hold
// them. `kept`: which photons it keeps.
std::string shortage_of(const std::string& map, const std::string& kept, uint64_t found, int least,
                        const Findings& pilot, const PhotonOrder& order) {
  const std::string paths = std::to_string(pilot.paths);
  if (found == 0) {
    return "No " + map + " map: none of " + paths + " paths from the lights left a photon " + kept;
  }
  const double expected = static_cast<double>(order.most_paths) * static_cast<double>(found) /
                          static_cast<double>(pilot.paths);
  if (!(expected < static_cast<double>(least))) {
    return {};
  }
  return "The " + map + " map will hold about " + std::to_string(std::llround(expected)) + " of " +
         std::to_string(least) + " photons: " + std::to_string(found) + " of " + paths +
         " paths from the lights left one " + kept + ", and no more than " +
         std::to_string(kPathsOfPhoton) + " paths are followed for each that is asked for";
}

void add_stats(const Findings& found, RenderStats& stats) {
  stats.rays += found.stats.rays;
  stats.non_finite += found.stats.non_finite;
}

}  // namespace

uint8_t indirect_kinds(const Settings& settings) {
  uint8_t kinds = photons_are_direct(settings) ? kind_bit(PhotonKind::kDirect) : uint8_t{0};
  if (settings.max_bounces != 0) {
    kinds |= kind_bit(PhotonKind::kCaustic) | kind_bit(PhotonKind::kIndirect);
  }
  return kinds;
}

// By what a pilot of vertex connection and merging finds: which photons the picture shows.
std::unique_ptr<const Plan> make_sppm_plan(const RenderContext& context, uint64_t seed,
                                           RenderStats& stats) {
  Settings settings = context.settings;
  settings.integrator = static_cast<int>(IntegratorKind::kVcm);
  settings.vcm_merging = 1;
  settings.merge_radius = settings.photon_radius;
  settings.only_light_vertices = settings.only_camera_vertices = -1;
  const RenderContext pilot{context.scene, settings, context.filter, context.cancelled};
  const auto learnt = make_bidirectional_plan(pilot, seed, stats);
  auto plan = std::make_unique<PhotonPlan>();
  plan->guide = static_cast<const BidirectionalPlan&>(*learnt).guide;
  return plan;
}

std::unique_ptr<const Plan> make_photon_map_plan(const RenderContext& context, uint64_t seed,
                                                 RenderStats& stats) {
  const Scene& scene = context.scene;
  const Settings& settings = context.settings;
  auto plan = std::make_unique<PhotonPlan>();
  plan->guide = scene.lights->guide_by_power();
  if (plan->guide.lights.size() == 0) {
    return plan;
  }
  const uint8_t caustic = kind_bit(PhotonKind::kCaustic);
  const uint8_t kinds = indirect_kinds(settings);
  const auto global_kinds = static_cast<uint8_t>(kinds & ~caustic);
  const bool caustics =
      (kinds & caustic) != 0 && scene.requirements.caustics && settings.caustic_photons > 0;
  const auto tell = [&](std::string note) {
    if (!note.empty() && !context.cancelled) {
      plan->shortages.push_back(std::move(note));
    }
  };
  int maps = 0;
  if (global_kinds != 0 && settings.global_photons > 0) {
    const Findings pilot = run_pilot(context, plan->guide, seed, global_kinds,
                                     [&](const Findings& f) { return f.count(global_kinds); });
    add_stats(pilot, stats);
    if (pilot.count(global_kinds) > 0) {
      plan->global = order_of(plan->guide, global_kinds, settings.global_photons, pilot);
      plan->global_map = maps++;
    }
    tell(shortage_of("global",
                     photons_are_direct(settings) ? "on a surface that scatters"
                                                  : "that one matte surface had sent to another",
                     pilot.count(global_kinds), settings.global_photons, pilot, plan->global));
  }
  if (caustics) {
    // Jensen's projection maps (2001, section 5.2): where paths meet specular surfaces first.
    Findings pilot = run_pilot(context, plan->guide, ~seed, caustic,
                               [](const Findings& f) { return f.first.size(); });
    add_stats(pilot, stats);
    plan->caustic_guide = plan->guide;
    aim_at(pilot.first, scene, plan->caustic_guide);
    choose_by(pilot.tally, plan->caustic_guide);
    direct_by(pilot.tally, *scene.lights, plan->caustic_guide);
    const Findings aimed = run_pilot(context, plan->caustic_guide, hash64(seed), caustic,
                                     [&](const Findings& f) { return f.count(caustic); });
    add_stats(aimed, stats);
    if (aimed.count(caustic) > 0) {
      plan->caustics = order_of(plan->caustic_guide, caustic, settings.caustic_photons, aimed);
      plan->caustic_map = maps++;
    }
    tell(shortage_of("caustic", "that glossy or clear surfaces alone had sent to a matte one",
                     aimed.count(caustic), settings.caustic_photons, aimed, plan->caustics));
  }
  return plan;
}

std::vector<std::string> describe_photon_limits(const Settings& settings,
                                                const Requirements& requirements) {
  std::vector<std::string> notes;
  if (requirements.uneven_visibility) {
    notes.push_back(
        "Photons meet the objects that are visible to diffuse rays: some here are visible to other "
        "kinds of scattered rays only, or hidden from them");
  }
  if (requirements.path_dependent) {
    notes.push_back(
        "Photons meet materials that read the ray's path as a ray of no kind would: they cannot "
        "know what the camera's part of the path has been through");
  }
  if (requirements.transmits_by_side) {
    notes.push_back(
        "Photons pass a surface as the side that they come from has it: what a material lets "
        "through as seen from its other side alone is left out");
  }
  if (requirements.uneven_lights > 0) {
    notes.push_back(
        std::to_string(requirements.uneven_lights) +
        (requirements.uneven_lights == 1 ? " light sends" : " lights send") +
        " no photons, and light from there is direct light only: what shines through walls, on "
        "some kinds of rays only, or otherwise on each receiver has no photons that could tell");
  }
  if (requirements.things_in_lamps) {
    notes.push_back(
        "A point or spot lamp without soft falloff sends no photons to what lies within it: light "
        "from there is direct light only");
  }
  if (BounceLimits::by_kind(settings)) {
    notes.push_back("Photons' bounces are limited in all, not by kind");
  }
  return notes;
}

std::vector<std::string> describe_photon_maps(const Settings& settings,
                                              const Requirements& requirements) {
  std::vector<std::string> notes;
  const uint8_t kinds = indirect_kinds(settings);
  if ((kinds & kind_bit(PhotonKind::kCaustic)) == 0) {
    notes.push_back(kinds == 0 ? "No photon maps: direct light and what is seen in mirrors is all"
                               : "No caustic map: direct light is all");
  } else if (!requirements.caustics) {
    notes.push_back("No caustic map: nothing here is glossy or clear beside something matte");
  } else if (settings.caustic_photons == 0) {
    notes.push_back("No caustic map, as it is set: caustics are left out");
  }
  if (kinds != 0 && settings.global_photons == 0 && settings.final_gather_rays == 0) {
    notes.push_back("No global map, as it is set: light between matte surfaces is left out");
  }
  return notes;
}

}  // namespace vernier
