#pragma once
#include "analysis/fit_spec.h"
#include "analysis/measured_ensemble.h"
#include "analysis/side_measurements.h"

namespace granuscope {

/// What one law makes of uniformly loaded piles: thrust ratio and variance of the weights by layer, their means over
/// the middle third of the layers (away from the top, which the load fixes, and from the bottom, which nothing below
/// constrains), and what drawing took. Needs every layer recorded.
LawOnPiles measure_law(const MeasuredEnsemble& ensemble);

/// c and D of multiplexed piles under one law, from the first layers in which peaks have a width to the last usable
/// one.
LawResponse measure_law_response(const MeasuredEnsemble& ensemble, int threads);

/// The layers of that window, and how they are fitted.
FitSpec law_response_fit(const LatticeSpec& lattice);

}  // namespace granuscope
