#pragma once
#include <nlohmann/json_fwd.hpp>

#include <filesystem>

#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "studies/study.h"

namespace granuscope {
/// One law on uniformly loaded piles of one size: what it gives and what it takes.
struct LawOnPiles {
  EnsembleSpec spec;
  std::uint64_t samples = 0;  ///< piles that entered
  std::uint64_t failed = 0;   ///< piles that could not be completed
  Estimate effective_samples;
  FlatTest flat;                     ///< polytope with lambda = 0
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

/// The laws side by side: on uniformly loaded piles, by the response under them, and by the work that they take.
/// `measured`: what was found, if that is known already.
std::unique_ptr<Study> law_comparison_study(ComparedLaws measured = {});

/// The members "laws", "responses" and "costs".
Json laws_json(const ComparedLaws& measured);

/// What the parts of the report need beside these: an overlay of their place in summary.json (report/page_scope.h).
Json laws_overlay(const ComparedLaws& measured);
/// Of the sentences of page 1, over all studies; null where fewer than two laws were compared.
Json laws_page_1(const ComparedLaws& measured);

/// The figure: thrust ratio by layer under each law, with the mean of each law and what drawing took in the legend.
/// Throws InputError if nothing was measured.
Figure plot_laws(const std::vector<LawOnPiles>& laws, const std::filesystem::path& run_folder);

/// The figure: random numbers drawn per bead against the size of square piles, one curve for each law and friction, on
/// a logarithmic axis on which exponential growth is straight. Throws InputError if no pile was completed.
Figure plot_law_cost(const std::vector<LawOnPiles>& costs, const std::filesystem::path& run_folder);

}  // namespace granuscope
