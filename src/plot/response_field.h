#pragma once
#include "analysis/measured_ensemble.h"
#include "analysis/results.h"
#include "render/field_scene.h"

namespace granuscope {

/// The mean response at the recorded layers with the fitted rays x = +-(x_0 + c z) and, around each, +-W of
/// W^2 = w_0 + D z.
Field response_field(const MeasuredEnsemble& ensemble, const Transport& transport);

}  // namespace granuscope
