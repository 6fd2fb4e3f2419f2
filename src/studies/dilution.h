#pragma once
#include <filesystem>
#include <optional>

#include "analysis/double_gaussian.h"
#include "analysis/mean_response.h"
#include "studies/study.h"

namespace granuscope {
/// Piles of one friction and size of which each contact below the top layer is opened with the probability `share`.
struct SolvableShare {
  double mu = 0;
  int size = 0;  ///< beads in a layer, and layers
  double share = 0;
  std::uint64_t piles = 0;
  std::uint64_t inside = 0, edge = 0;  ///< by the linear programme (sampling/diluted_beads.h); the others: nowhere
  double no_idle_bead = 1;  ///< probability that every bead keeps a lower contact: the largest that `inside` can have

  Estimate solvable() const { return share_of(inside); }
  Estimate at_all() const { return share_of(inside + edge); }

 private:
  Estimate share_of(std::uint64_t count) const;
};

/// Piles of which contacts are opened one after the other, each only if the pile stays solvable, until all were tried.
struct LargestShare {
  double mu = 0;
  int size = 0;
  std::uint64_t piles = 0;
  Estimate share;  ///< mean over the piles
};

/// Draws nothing: (seed, number of the pile) give the opened contacts. `threads`: 0 for as many as the machine has.
std::vector<SolvableShare> measure_solvable_shares(const std::vector<double>& mu, const std::vector<int>& sizes,
                                                   const std::vector<double>& shares, std::uint64_t piles,
                                                   std::uint64_t seed, int threads);
std::vector<LargestShare> measure_largest_shares(const std::vector<double>& mu, const std::vector<int>& sizes,
                                                 double least_slack, std::uint64_t piles, std::uint64_t seed,
                                                 int threads);

/// The response of piles with opened contacts.
struct DilutedResponse {
  double mu = 0, share = 0;
  int columns = 0, layers = 0;
  std::uint64_t samples = 0, failed = 0;  ///< failed: fewer contacts than asked for could be opened
  double z = 0;                           ///< of the deepest layer that is measured; what follows is measured there
  Estimate position, width, thrust_ratio;
  FittedResponseShapes fits;
  int peaks = 1;  ///< maxima of the shape that fits best
  Estimate c, D;  ///< slopes over the layers from half of that depth on
  std::optional<ResponseProfile> profile;
};
DilutedResponse measure_diluted_response(const MeasuredEnsemble& ensemble, const FitSpec& fit, int threads);

/// All that the study measures.
struct DilutedPiles {
  std::vector<SolvableShare> solvable;     ///< by friction, size, share
  std::vector<LargestShare> largest;       ///< by friction, size
  std::vector<DilutedResponse> responses;  ///< by friction, share
};

/// Share of solvable piles against the share of opened contacts. Throws InputError where nothing was measured.
Figure plot_solvable_shares(const DilutedPiles& measured, const std::filesystem::path& run_folder);

/// The response at the deepest layer, and how x_p and W there depend on the share. Throws InputError likewise.
Figure plot_diluted_responses(const DilutedPiles& measured, const std::filesystem::path& run_folder);

/// How many contacts can be opened, and what becomes of the two peaks; `measured`: what was found, if that is known
/// already.
std::unique_ptr<Study> dilution_study(DilutedPiles measured = {});

}  // namespace granuscope
