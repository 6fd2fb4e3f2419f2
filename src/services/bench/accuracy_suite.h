#pragma once
#include <ostream>
#include <string>
#include <vector>

#include "analysis/precision.h"

namespace granuscope {

struct AccuracyOptions {
  int threads = 1;       ///< blocks drawn at the same time; one at a time disturbs them least
  int repetitions = 32;  ///< at least least_repetitions; the scatter of 32 is known to 13 %
  bool quick = false;    ///< mu = 0.1 and 0.3, only the best estimators, and no laws of small piles
};

/// One estimator at one friction coefficient: all its repetitions in one ensemble.
struct AccuracyCase {
  ErrorCurve curve;    ///< no points and no c and D where peaks were not measured; their reason says why
  double seconds = 0;  ///< processor time of drawing and summing all repetitions
  double wall = 0;     ///< by the clock, times the threads: more where others use the processors, too
  Estimate c_thrust;   ///< of all samples

  int repetitions() const { return curve.spec.response.blocks / repetition_blocks; }
  bool thrust_alone() const { return curve.spec.load == Load::uniform; }
};

/// How many times cheaper than by the estimator point in its literal form D and c of the peaks come at equal scatter by
/// its coupled form, by fluctuation, or by multiplexed with one epsilon and its options, and c_thrust, another
/// quantity, than c of the peaks by point. What a larger epsilon gains in scatter it pays with a bias of the order
/// epsilon^2: see the shifts of the cases.
struct Speedup {
  double mu = 0;
  ResponseSpec response;
  double D = 0, c_peaks = 0, c_thrust = 0;
  bool stated = false;  ///< the one that stands for the linear response
};

struct AccuracyTable {
  std::vector<AccuracyCase> cases;
  std::vector<Speedup> speedups;
};

/// Measures, on 500 x 200 beads (fluctuation: 256 x 1600), what each estimator costs and how its c and D scatter over
/// independent repetitions (precision.h), not what its own error bars say: all of them at mu = 0.1 and 0.3, the best at
/// 0.15, 0.2 and 0.4, too. The first case of each mu is point in its literal form. Laws that do not reach
/// piles in which peaks stand apart are measured on the largest piles they are good for, by the error of c_thrust
/// alone, and say so. Times are processor seconds of all threads that draw and sum, Fourier transforms included; the
/// fits that follow are the same for all estimators and are left out.
AccuracyTable measure_accuracy(const AccuracyOptions& options, std::ostream& messages);

/// Times, samples and the members stderr_* are those of one repetition.
std::string accuracy_json(const AccuracyTable& table);

}  // namespace granuscope
