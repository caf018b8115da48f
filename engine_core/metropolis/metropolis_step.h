// One step of a Markov chain: what all Metropolis methods share.
//
// The chain visits points x of some space with a density in proportion to its target f(x), whatever
// proposes them, as long as the ratio of the proposal's densities there and back is told exactly
// (Metropolis et al. 1953; Hastings 1970). Both the point that is left and the one that is proposed
// are recorded, each with its probability of being the next: expected values in place of chance
// (Veach and Guibas 1997, section 5.2).
#pragma once

#include <algorithm>
#include <utility>

namespace vernier {

// The probability of going from a point of target `current` to one of target `proposed`. `ratio` is
// the density of proposing the way back over that of the way there; 0 or not a number: never.
inline double acceptance(double current, double proposed, double ratio) {
  const double a = proposed / current * ratio;
  return a > 0.0 ? std::min(a, 1.0) : 0.0;
}

// Where a chain is. State has a member `target`; a chain starts where it is not 0.
template <class State>
struct MarkovChain {
  State current, proposed;
  double pending = 0;  // visits of `current` that have not been recorded yet
};

// Decides about chain.proposed. `u` is uniform in [0,1). Calls record(const State&, double visits)
// for what is known of the visits so far; true: the chain has moved.
template <class State, class Record>
bool metropolis_step(MarkovChain<State>& chain, double ratio, float u, const Record& record) {
  const double a = acceptance(chain.current.target, chain.proposed.target, ratio);
  chain.pending += 1.0 - a;
  if (static_cast<double>(u) < a) {
    if (chain.pending > 0.0) {
      record(chain.current, chain.pending);
    }
    std::swap(chain.current, chain.proposed);
    chain.pending = a;
    return true;
  }
  if (a > 0.0) {
    record(chain.proposed, a);
  }
  return false;
}

// Records what is pending: to be called when the chain ends.
template <class State, class Record>
void end_chain(MarkovChain<State>& chain, const Record& record) {
  if (chain.pending > 0.0) {
    record(chain.current, chain.pending);
    chain.pending = 0.0;
  }
}

}  // namespace vernier
