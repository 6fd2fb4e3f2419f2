#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "analysis/transport.h"
#include "ensemble/ensemble_spec.h"
#include "experiment/experiment.h"
#include "model/pile.h"
#include "plot/figure_captions.h"
#include "render/scenes.h"
#include "support/provenance.h"

namespace granuscope {

/// A rendered picture as a figure of the report, and what is to be said about how it was made.
struct PictureOutcome {
  Figure figure;
  std::vector<std::pair<std::string, std::string>> environment;    ///< GL backend, why it was chosen, renderer
  std::vector<std::string> checks;                                 ///< how the pile's audit came out
  std::vector<std::string> skipped;                                ///< what was left out of the picture, counted
  std::vector<std::pair<std::string, std::string>> not_kept = {};  ///< files beside it that could not be written, why
};

/// The pile of the pictures as an ensemble of its own, at any friction coefficient, so that its load and the command
/// that draws it again are written once.
EnsembleSpec pile_spec(const Experiment& experiment, double mu);
/// Whether a picture compares that pile with the one under a uniform load.
bool needs_pair(const Experiment& experiment);

/// The pile of the force-chain picture (size, load, seed and sample), at any friction coefficient.
/// Throws InputError if it could not be completed.
Pile pile_for_figures(const Experiment& experiment, double mu);

/// Throws EnvironmentError if OpenGL is asked for by name for the pictures and cannot be started.
void require_backend(const ForceChainSpec& chains);

/// Draws the pile that the experiment names (piles/force-chains.h5) and its pictures: force chains, and as asked for
/// the weights of its beads and how they change with the overload. A picture that could not be rendered says why
/// (Figure::failure). Throws InputError if the pile could not be completed.
std::vector<PictureOutcome> render_pile_pictures(const Experiment& experiment, const std::filesystem::path& run_folder,
                                                 const Provenance& provenance);

/// The picture of a response_field (figures/response-field.png).
PictureOutcome render_response_field(const Experiment& experiment, Field field, const Transport& transport,
                                     const std::filesystem::path& run_folder, const Provenance& provenance);

}  // namespace granuscope
