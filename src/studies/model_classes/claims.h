#pragma once
#include <vector>

#include "figure.h"

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

}  // namespace granuscope
