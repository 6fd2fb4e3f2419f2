#pragma once
#include <cstdint>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/fit_spec.h"
#include "analysis/measured_ensemble.h"
#include "analysis/thrust_at_depth.h"

namespace granuscope {

/// One law on uniformly loaded piles of one size: what it gives and what it takes.
struct LawOnPiles {
  EnsembleSpec spec;
  std::uint64_t samples = 0;  ///< piles that entered
  std::uint64_t failed = 0;   ///< piles that could not be completed
  Estimate effective_samples;
  double burn_in = 0, thinning = 0;  ///< polytope: sweeps, as measured; otherwise not a number
  double draws_per_bead = 0;         ///< uniform numbers per bead, whatever was thrown away included
  double pair_per_bead = 0, arc_per_bead = 0,
         backtracked_per_bead = 0;      ///< share of beads whose value came from each rule
  std::vector<ThrustAtDepth> depths;    ///< every layer
  int first_layer = 0, last_layer = 0;  ///< that the means below are taken over
  Estimate alpha_thrust;
  Estimate c_thrust;  ///< tan30 sqrt(alpha_thrust)
  Estimate weight_variance;
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

/// All that the laws were compared by.
struct ComparedLaws {
  std::vector<LawOnPiles> on_piles;    ///< the larger piles first
  std::vector<LawResponse> responses;  ///< under those laws that can draw piles in which peaks stand apart
  std::vector<LawOnPiles> costs;       ///< ascending in mu, then by law, then in size
};

/// What one law makes of uniformly loaded piles: thrust ratio and variance of the weights by layer, their means over
/// the middle third of the layers (away from the top, which the load fixes, and from the bottom, which nothing below
/// constrains), and what drawing took. Needs every layer recorded.
LawOnPiles measure_law(const MeasuredEnsemble& ensemble);

/// c and D of multiplexed piles under one law, from the first layers in which peaks have a width to the last usable
/// one.
LawResponse measure_law_response(const MeasuredEnsemble& ensemble, int threads);

/// The layers of that window, and how they are fitted.
FitSpec law_response_fit(const LatticeSpec& lattice);

}  // namespace granuscope
