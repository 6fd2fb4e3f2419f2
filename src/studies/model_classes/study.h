#pragma once
#include <memory>

#include "studies/model_classes/figures.h"
#include "studies/study.h"

namespace granuscope {

/// The models that the paper argues with, under one procedure: what the response of each looks like, and which class it
/// belongs to. `measured`: what has been, for tests of the report.
std::unique_ptr<Study> models_study(MeasuredModels measured = {});

}  // namespace granuscope
