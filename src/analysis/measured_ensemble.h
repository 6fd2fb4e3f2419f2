#pragma once
#include "ensemble/ensemble_spec.h"
#include "storage/ensemble_file.h"

namespace granuscope {

/// One ensemble handed to the analysis: what was drawn, and what came of it.
struct MeasuredEnsemble {
  EnsembleSpec spec;
  EnsembleRecord record;
};

}  // namespace granuscope
