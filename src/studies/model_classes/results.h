#pragma once
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "plot/figure_captions.h"
#include "studies/model_classes/measure.h"
#include "studies/spreading.h"
#include "studies/study.h"

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

/// What the paper's discussion says of classes of models, held against the series measured:
///
///   models-not-elastic    the width of the beads' peaks does not grow as that of an elastic medium;
///   q-model-too-narrow    the q-model has one peak, narrower than the beads' response is wide;
///   models-c-of-D         c0 - c of beads does not follow D as in the theory of stochastic OSL;
///   mean-of-noise         in the three-leg model whose legs push, the mean of its noise alone explains c.
///
/// Each only where what it is about was measured.
std::vector<Claim> judge_models(const std::vector<ModelSeries>& series);

/// The results as they stand in summary.json.
nlohmann::ordered_json models_json(const MeasuredModels& measured);

/// What the sentences of page 1 need beside these: series by the number of their peaks, exponents that are known, and
/// the smallest and largest known share of the slowing that a mean explains.
nlohmann::ordered_json models_page_1(const nlohmann::ordered_json& results);

/// The models that the paper argues with, under one procedure: what the response of each looks like, and which class it
/// belongs to. `measured`: what has been, for tests of the report.
std::unique_ptr<Study> models_study(MeasuredModels measured = {});

}  // namespace granuscope
