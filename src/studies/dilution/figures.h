#pragma once
#include <filesystem>
#include <vector>

#include "measure.h"
#include "plot/figure.h"

namespace granuscope {

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

}  // namespace granuscope
