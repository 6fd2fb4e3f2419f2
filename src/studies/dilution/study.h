#pragma once
#include <memory>
#include <vector>

#include "figures.h"
#include "studies/study.h"

namespace granuscope {

/// How many contacts can be opened, and what becomes of the two peaks; `measured`: what was found, if that is known
/// already.
std::unique_ptr<Study> dilution_study(DilutedPiles measured = {});

}  // namespace granuscope
