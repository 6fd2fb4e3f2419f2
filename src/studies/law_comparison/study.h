#pragma once
#include <memory>

#include "measure.h"
#include "studies/study.h"

namespace granuscope {

/// The laws side by side: on uniformly loaded piles, by the response under them, and by the work that they take.
/// `measured`: what was found, if that is known already.
std::unique_ptr<Study> law_comparison_study(ComparedLaws measured = {});

}  // namespace granuscope
