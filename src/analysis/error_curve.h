#pragma once
#include <vector>

#include "analysis/fit_spec.h"
#include "analysis/measured_ensemble.h"
#include "analysis/side_measurements.h"

namespace granuscope {

/// Blocks of one repetition: an ensemble that measures errors holds so many for each.
inline constexpr int repetition_blocks = min_blocks;

/// The depths over which the slopes c and D are taken on piles of this size: the deep two thirds of the usable layers,
/// about fifteen of both kinds of rows.
FitSpec error_curve_fit(const LatticeSpec& lattice);

/// Takes an ensemble apart into repetitions that share no pile (repetition_blocks blocks each), measures c and D of
/// each by itself, and of each two, four, ... of them together: how their values scatter is the error that an ensemble
/// of that size has, whatever error bars it would state. Sizes with fewer than four
/// repetitions are left out, and those of which one has no fit of two peaks.
ErrorCurve measure_error_curve(const MeasuredEnsemble& ensemble, int threads);

/// Slope of ln scatter on ln samples; -1/2 where the error is statistical. The scatter of n repetitions is known to
/// 1/sqrt(2(n - 1)) of itself. Sizes share their piles, which makes the slope better known than its error says. Unknown
/// with fewer than two sizes.
Estimate slope_of_scatter(const std::vector<ErrorPoint>& points, double ErrorPoint::*scatter);

/// What each curve measures beside the linear response, c and D minus those of the curve that bends it least: opposite
/// loads with the smallest epsilon. Curves of the same piles at one friction coefficient.
void set_shifts(std::vector<ErrorCurve>& curves);

}  // namespace granuscope
