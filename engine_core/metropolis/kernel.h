// What a Metropolis method is to the render session.
#pragma once

#include "metropolis/explore.h"

namespace vernier {

// What the user should know of any Metropolis method.
std::vector<std::string> describe_metropolis_limits(const Settings& settings,
                                                    const Requirements& requirements,
                                                    PassSet passes);

template <class Explorer>
Kernel metropolis_kernel(const Settings& settings, const Requirements& requirements,
                         PassSet passes) {
  return {.render_tile = passes.any_sampled()
                             ? explore_tile<Explorer, BidirectionalFeatures{true, true}>
                             : explore_tile<Explorer, BidirectionalFeatures{false, true}>,
          .splats = true,
          .make_plan = make_metropolis_plan,
          .make_light_pass = make_seed_pool<Explorer>,
          .notes = describe_metropolis_limits(settings, requirements, passes)};
}

}  // namespace vernier
