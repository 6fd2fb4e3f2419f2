#pragma once
#include "analysis/side_measurements.h"
#include "ensemble/ensemble_spec.h"
#include "storage/ensemble_file.h"

namespace granuscope {

/// What one law makes of uniformly loaded piles: thrust ratio and variance of the weights by layer, their means over
/// the middle third of the layers (away from the top, which the load fixes, and from the bottom, which nothing below
/// constrains), and what drawing took. Needs every layer recorded.
LawOnPiles measure_law(const EnsembleSpec& spec, const EnsembleRecord& record);

}  // namespace granuscope
