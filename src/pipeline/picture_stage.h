#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "experiment/experiment.h"
#include "model/pile.h"
#include "plot/figure.h"
#include "support/provenance.h"

namespace granuscope {

/// A rendered picture as a figure of the report, and what is to be said about how it was made.
struct PictureOutcome {
  Figure figure;
  std::vector<std::pair<std::string, std::string>> environment;  ///< GL backend, why it was chosen, renderer
  std::vector<std::string> checks;                               ///< how the pile's audit came out
  std::vector<std::string> skipped;                              ///< what was left out of the picture, counted
};

/// The pile of the force-chain picture (size, load, seed and sample), at any friction coefficient.
/// Throws InputError if it could not be completed.
Pile pile_for_figures(const Experiment& experiment, double mu);

/// Draws the pile that the experiment names (piles/force-chains.h5) and its picture (figures/force-chains.png).
/// Throws EnvironmentError if there is no GL context or the pile could not be completed.
PictureOutcome draw_force_chains(const Experiment& experiment, const std::filesystem::path& run_folder,
                                 const Provenance& provenance);

}  // namespace granuscope
