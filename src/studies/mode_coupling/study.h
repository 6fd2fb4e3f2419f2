#pragma once
#include <memory>

#include "studies/study.h"

namespace granuscope {

/// Why the peaks spread faster than diffusion: weight and horizontal force are conserved, and what the horizontal force
/// does to the thrust couples the peaks to themselves. Fluctuating hydrodynamics with that coupling (mode coupling)
/// predicts W^2(z) from piles under a leaning load and from the fluctuations of single layers.
std::unique_ptr<Study> mode_coupling_study();

}  // namespace granuscope
