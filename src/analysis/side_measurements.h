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

/// The response at one friction coefficient to one kind and size of load, beside the linear response.
struct LoadResponse {
  EnsembleSpec spec;                    ///< under a uniform load there is no response, only the thrust ratio
  bool reference = false;               ///< taken for the linear response
  std::uint64_t samples = 0;            ///< piles that entered
  std::uint64_t failed = 0;             ///< piles that could not be completed
  int first_layer = 0, last_layer = 0;  ///< of the window of the slopes
  bool own_window = false;  ///< shorter than the one common to the other loads at this mu, see nonlinearity.h
  Estimate c, D, c_thrust;
  Estimate c_shift;         ///< c minus that of the linear response, over the same layers
  Estimate D_shift;         ///< D over that of the linear response, minus 1; likewise
  Estimate c_thrust_shift;  ///< c_thrust minus that of uniformly loaded piles

  bool uniform() const { return spec.load == Load::uniform; }
  double load() const { return uniform() ? 0 : load_size(spec.response); }
};

/// The exponents over the friction coefficients of one load.
struct LoadExponents {
  ResponseSpec response;
  bool reference = false;
  std::array<double, 2> window{};  ///< of mu: the least and largest that took part
  int points = 0;                  ///< friction coefficients that took part
  Estimate beta, gamma;
  Estimate beta_shift, gamma_shift;  ///< minus those of the linear response at the same friction coefficients
};

/// How far the response depends on the size of the load: c, D and the exponents for several loads.
struct Nonlinearity {
  std::vector<LoadResponse> responses;   ///< ascending in mu, at each mu in the order of the exponents, then uniform
  std::vector<LoadExponents> exponents;  ///< multiplexed ascending in epsilon, then point ascending in the overload
};

/// How c and D scatter over independent repetitions of so many samples.
struct ErrorPoint {
  std::uint64_t samples = 0;
  int repetitions = 0;
  double scatter_c = 0, scatter_D = 0;  ///< standard deviations
};

/// The error of one estimator against the size of its ensembles, see error_curve.h.
struct ErrorCurve {
  EnsembleSpec spec;
  std::uint64_t samples = 0;  ///< of all repetitions
  std::uint64_t failed = 0;
  std::uint64_t beads = 0;         ///< drawn for them
  std::vector<ErrorPoint> points;  ///< ascending in samples; empty if the repetitions have no fit
  Estimate c, D;                   ///< of all samples; errors from the scatter
  Estimate shift_c, shift_D;       ///< from the linear response
  Estimate slope_c, slope_D;       ///< of ln scatter on ln samples; -1/2 is expected
};

struct SideMeasurements {
  std::vector<LawOnPiles> laws;            ///< the larger piles first
  std::vector<LawResponse> law_responses;  ///< those laws that can draw piles in which peaks stand apart
  std::vector<ExactThrust> exact_thrusts;  ///< in the order of friction, then of columns
  std::vector<LawOnPiles> law_costs;       ///< ascending in mu, then by law, then in size
  Nonlinearity nonlinearity;
  std::vector<ErrorCurve> error_curves;  ///< one for each estimator
};

}  // namespace granuscope
