#pragma once
#include <memory>
#include <vector>

#include "studies/mode_coupling/measure.h"
#include "studies/study.h"

namespace granuscope {

/// Why the peaks spread faster than diffusion: weight and horizontal force are conserved, and what the horizontal force
/// does to the thrust couples the peaks to themselves. Fluctuating hydrodynamics with that coupling (mode coupling)
/// predicts W^2(z) from piles under a leaning load and from the fluctuations of single layers.
std::unique_ptr<Study> mode_coupling_study();

/// What the sentences of page 1 need beside the results; null where nothing is predicted. The prediction holds at a
/// friction coefficient if its strength is 1 within the claim's tolerance and three errors, and if it describes W^2
/// better than without torque: errors alone do not make it hold.
nlohmann::ordered_json coupling_page_1(const std::vector<CoupledSpreading>& measured);

}  // namespace granuscope
