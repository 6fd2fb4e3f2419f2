#pragma once
#include <filesystem>
#include <vector>

#include "measure.h"
#include "plot/figure.h"

namespace granuscope {

/// The figure: thrust ratio by layer under each law, with the mean of each law and what drawing took in the legend.
/// Throws InputError if nothing was measured.
Figure plot_laws(const std::vector<LawOnPiles>& laws, const std::filesystem::path& run_folder);

/// The figure: random numbers drawn per bead against the size of square piles, one curve for each law and friction, on
/// a logarithmic axis on which exponential growth is straight. Throws InputError if no pile was completed.
Figure plot_law_cost(const std::vector<LawOnPiles>& costs, const std::filesystem::path& run_folder);

}  // namespace granuscope
