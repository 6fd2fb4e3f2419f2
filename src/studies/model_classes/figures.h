#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "plot/figure_captions.h"
#include "studies/model_classes/measure.h"
#include "studies/spreading.h"

namespace granuscope {
/// Those that are scanned together, with the power law of c0 - c against D.
struct ModelSeries {
  std::string name;
  bool aside = false;  ///< no class of models by itself: it has a figure of its own
  std::vector<ModelResponse> responses;
  ScalingFit alpha;
};

/// The response of one model over depths that double, from its fluctuations.
struct DeepModel {
  std::string series, parameter;
  DeepResponse response;
};

/// What the study has measured.
struct MeasuredModels {
  std::vector<ModelSeries> series;
  std::vector<TractionDepth> tractions;
  std::vector<DeepModel> deep;
};

/// c0 - c against D of all series with two peaks, and the response of the last of each series at the
/// deepest layer. Throws InputError where nothing was measured.
Figure plot_models(const std::vector<ModelSeries>& series, const std::string& study,
                   const std::filesystem::path& run_folder);

/// What correlated noise takes from c^2 and adds to D against Delta^2, beside the theory to second order.
Figure plot_noise(const std::vector<ModelSeries>& series, const std::filesystem::path& run_folder);

/// The three-leg model: c against the mean share of the middle leg, beside c0 sqrt(1 - p), and where legs begin to
/// pull.
Figure plot_middle(const std::vector<ModelSeries>& series, const std::vector<TractionDepth>& tractions,
                   const std::filesystem::path& run_folder);

/// What the beads of one pile of the last model of a series carry, under a uniform load.
Figure render_pile_of(const ModelSeries& series, const std::filesystem::path& run_folder);

/// Heavy beads: the thrust ratio over depth, and the response at the deepest layer.
Figure plot_gravity(const std::vector<ModelSeries>& series, const std::filesystem::path& run_folder);

}  // namespace granuscope
