#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/scaling_fit.h"
#include "analysis/thrust_at_depth.h"
#include "ensemble/ensemble_spec.h"

namespace granuscope {

/// What an experiment measures beside its main ensembles, each on small ensembles of its own. An empty list: the
/// experiment did not ask for it.

/// One law on uniformly loaded piles of one size: what it gives and what it takes.
struct LawOnPiles {
  EnsembleSpec spec;
  std::uint64_t samples = 0;  ///< piles that entered
  std::uint64_t failed = 0;   ///< piles that could not be completed
  Estimate effective_samples;
  double burn_in = 0, thinning = 0;  ///< polytope: sweeps, as measured; otherwise not a number
  double draws_per_bead = 0;         ///< uniform numbers per bead, whatever was thrown away included
  double pair_per_bead = 0, arc_per_bead = 0, climbed_per_bead = 0;  ///< share of beads whose value came from each rule
  std::vector<ThrustAtDepth> depths;                                 ///< every layer
  int first_layer = 0, last_layer = 0;                               ///< that the means below are taken over
  Estimate alpha_thrust;
  Estimate c_thrust;  ///< tan30 sqrt(alpha_thrust)
  Estimate weight_variance;
};

/// The thrust ratio under the law rejection, away from top and bottom (exact_thrust.h).
struct ExactThrust {
  EnsembleSpec spec;
  std::uint64_t samples = 0;            ///< piles that entered
  std::uint64_t failed = 0;             ///< piles that could not be completed
  int first_layer = 0, last_layer = 0;  ///< of the bulk
  Estimate alpha;                       ///< mean over the bulk
  Estimate deficit_over_mu2;            ///< (1 - alpha)/mu^2
  Estimate change_with_depth;           ///< alpha of the lower half of the bulk minus that of its upper half
  Estimate alpha_of_last_layer;
};

/// The response under one law, on piles small enough for the slowest.
struct LawResponse {
  EnsembleSpec spec;
  std::uint64_t samples = 0;
  std::uint64_t failed = 0;
  Estimate effective_samples;
  double burn_in = 0, thinning = 0;     ///< polytope: sweeps, as measured; otherwise not a number
  int first_layer = 0, last_layer = 0;  ///< of the slopes c and D
  Estimate c, D;
};

struct SideMeasurements {
  std::vector<LawOnPiles> laws;            ///< the larger piles first
  std::vector<LawResponse> law_responses;  ///< those laws that can draw piles in which peaks stand apart
  std::vector<ExactThrust> exact_thrusts;  ///< in the order of friction, then of columns
  std::vector<LawOnPiles> law_costs;       ///< ascending in mu, then by law, then in size
};

}  // namespace granuscope
