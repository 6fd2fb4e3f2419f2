#pragma once
#include <cstdint>
#include <vector>

#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "analysis/results.h"
#include "analysis/shape_fit.h"

namespace granuscope {
/// Standard errors, or effective samples (jackknife.h), at which an ensemble is large enough.
struct PrecisionSpec {
  double c = 0;                          ///< of the slope c; 0: not asked for
  double D = 0;                          ///< of the slope D; 0: not asked for
  std::uint64_t most_samples = 100'000;  ///< piles per friction coefficient at which to give up
  double effective = 0;                  ///< independent piles that it is to be worth; 0: not asked for

  bool asked() const { return c > 0 || D > 0 || effective > 0; }
};

/// The sizes at which a growing ensemble is looked at: half as many again each time. They depend on the first one only,
/// not on what was measured: two runs look at the same places.
std::uint64_t next_size(std::uint64_t rounds);

/// The first size, grown step by step from `rounds`, that is at least `rounds_needed`: where an ensemble is expected to
/// stop, since it is looked at after whole steps only. No larger than most_rounds allows.
std::uint64_t expected_size(std::uint64_t rounds, double rounds_needed, std::uint64_t most_rounds);

/// What one look at an ensemble of `samples` piles says.
struct PrecisionLook {
  bool reached = false;
  bool unattainable = false;  ///< an error is unknown, and more piles promise no change
  std::string reason;         ///< not empty if and only if it is unattainable
  double samples_needed = 0;  ///< in all, since errors fall as 1/sqrt(samples); NaN if unattainable
};

/// The factor by which errors have to grow for having been looked at until they were small: an error from B blocks is
/// known to 1/sqrt(2 (B - 1)) of itself, and of several looks the luckiest one counts. With it the mean stated error is
/// the true one within 1 % for 8 to 128 blocks and steps of next_size (a test simulates it; without it 32 blocks state
/// 3.4 % too little).
double stopped_scatter(int blocks);

/// `measured`: as its blocks scatter. An ensemble that has stopped must state stopped_scatter times the errors.
PrecisionLook look_at_precision(const PrecisionSpec& asked, const Transport& measured, std::uint64_t samples);

/// Standard errors of c and D to be expected before anything is drawn, good to a factor of two or so: fits to errors
/// measured on 500 x 200 beads with a window from layer 58 to 179 at mu = 0.1 to 0.5. One multiplexed pile of 500
/// columns says as much as 90 (2 epsilon)^2 overloaded ones.
struct ExpectedErrors {
  double c, D;
};
/// So many multiplexed piles have the errors of one pair of opposite ones: measured, 2 to 6 at epsilon = 0.1 to 0.5 and
/// mu = 0.1 to 0.6, and 10 at the lowest of both.
inline constexpr std::uint64_t worth_of_opposite_pair = 4;
/// And so many piles of a single overload have those of one with several or coupled ones, or of such a pair. Of coupled
/// piles the variance of c is as good as 2 mu times that of others, from 0.26 at mu = 0.1 to 0.87 at 0.4.
double worth_of_sample(const EnsembleSpec& spec);

ExpectedErrors expected_errors(double mu, bool multiplexed, double load, int columns, std::uint64_t samples);

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
