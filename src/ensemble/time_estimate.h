#pragma once
#include <cstdint>

#include "ensemble/ensemble_spec.h"

namespace granuscope {

/// Processor time for drawing an ensemble, and adding it up, on one core of this machine.
struct TimeEstimate {
  double once = 0;        ///< seconds before the first pile, which more threads do not shorten: the pilot of a chain
  double per_sample = 0;  ///< seconds
  bool at_least = false;  ///< the trial ended before it could tell how much more it is

  double on_threads(std::uint64_t samples, int threads) const {
    return once + per_sample * static_cast<double>(samples) / threads;
  }
};

/// Draws the first piles of the ensemble and keeps nothing, or runs the beginning of the pilot of its chains: what a
/// pile costs depends on the law, the friction, the size, the estimator and the machine, beyond any rule of thumb.
/// Takes at most about so many seconds of processor time, beside the first few piles. Of deep piles of the law
/// granusolve only the upper layers are drawn, since its work is linear in the layers. Piles of laws that draw again
/// and again are given up after fewer tries than in the ensemble, and the mean is that of tries which forget the ones
/// before.
TimeEstimate estimate_time(const EnsembleSpec& spec, double seconds);

}  // namespace granuscope
