#pragma once
#include <memory>

#include "measure.h"
#include "studies/study.h"

namespace granuscope {

/// The response to several kinds and sizes of load, beside the linear response; `measured`: what was found, if that is
/// known already.
std::unique_ptr<Study> nonlinearity_study(LoadComparison measured = {});

}  // namespace granuscope
