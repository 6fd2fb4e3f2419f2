#pragma once
#include <nlohmann/json.hpp>

#include <vector>

#include "studies/model_classes/figures.h"

namespace granuscope {
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

}  // namespace granuscope
