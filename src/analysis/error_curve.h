#pragma once
#include <cstdint>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/fit_spec.h"
#include "analysis/measured_ensemble.h"

namespace granuscope {

/// How c and D scatter over independent repetitions of so many samples.
struct ErrorPoint {
  std::uint64_t samples = 0;
  int repetitions = 0;
  double scatter_c = 0, scatter_D = 0;  ///< standard deviations
};

/// The error of one estimator against the size of its ensembles.
struct ErrorCurve {
  EnsembleSpec spec;
  std::uint64_t samples = 0;  ///< of all repetitions
  std::uint64_t failed = 0;
  std::uint64_t beads = 0;         ///< drawn for them
  std::vector<ErrorPoint> points;  ///< ascending in samples; empty if the repetitions have no fit
  Estimate c, D;                   ///< of all samples; errors from the scatter
  Estimate shift_c, shift_D;       ///< from the linear response
  Estimate slope_c, slope_D;       ///< of ln scatter on ln samples; -1/2 is expected; unknown with fewer than two sizes
};

/// Blocks of one repetition: an ensemble that measures errors holds so many for each.
inline constexpr int repetition_blocks = min_blocks;
/// Fewest repetitions from which a scatter is taken.
inline constexpr int least_repetitions = 4;

/// The depths over which the slopes c and D are taken on piles of this size: the deep two thirds of the usable layers,
/// about fifteen of both kinds of rows.
FitSpec error_curve_fit(const LatticeSpec& lattice);

/// Takes an ensemble apart into repetitions that share no pile (repetition_blocks blocks each), measures c and D of
/// each by itself, and of each two, four, ... of them together: how their values scatter is the error that an ensemble
/// of that size has, whatever error bars it would state. Sizes with fewer than least_repetitions are left out, and
/// those of which one has no fit of two peaks.
ErrorCurve measure_error_curve(const MeasuredEnsemble& ensemble, const FitSpec& fit, int threads);

/// What each curve measures beside the linear response, c and D minus those of the curve that bends it least: opposite
/// loads with the smallest epsilon. Curves of the same piles at one friction coefficient.
void set_shifts(std::vector<ErrorCurve>& curves);

}  // namespace granuscope
