#pragma once
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "analysis/estimate.h"
#include "ensemble/ensemble_spec.h"

namespace granuscope {

struct AccuracyOptions {
  int threads = 1;       ///< repetitions drawn at the same time; one at a time disturbs them least
  int repetitions = 32;  ///< at least 2; the scatter of 32 is known to 13 %
};

/// The scatter of c and D against what they cost, for samples added up 1, 2, 4, ... times.
struct AccuracyPoint {
  std::uint64_t samples = 0;
  int repetitions = 0;
  double seconds = 0;                 ///< of one repetition
  double stderr_c = 0, stderr_D = 0;  /// standard deviation over the repetitions
  double rms_c = 0, rms_D = 0;        ///< root mean square distance from the linear response: scatter and bias
};

/// One estimator at one friction coefficient.
struct AccuracyCase {
  EnsembleSpec spec;                 ///< of one repetition; under a uniform load the thrust alone is measured
  std::vector<AccuracyPoint> curve;  ///< the first one is a single repetition; empty for the thrust alone
  int repetitions = 0;
  double seconds = 0;          ///< of one repetition: processor time of the thread that drew and summed
  double stderr_c_thrust = 0;  ///< standard deviation over the repetitions
  Estimate c, D, c_thrust;     ///< means over the repetitions
  Estimate slope_c, slope_D;   ///< of ln stderr on ln samples along the curve: -1/2 where errors are statistical
  std::string reason;          ///< why there is no scatter of c and D of the peaks, where there is none

  bool thrust_alone() const { return spec.load == Load::uniform; }
};

/// How many times cheaper than by the estimator point D and c of the peaks come at equal scatter by the estimator
/// multiplexed with one epsilon and its options, and c_thrust, another quantity, than c of the peaks by point. What a
/// larger epsilon gains in scatter it pays with a bias of the order epsilon^2: see c, D and rms_* of the cases.
struct Speedup {
  double mu = 0;
  ResponseSpec response;
  double D = 0, c_peaks = 0, c_thrust = 0;
};

struct AccuracyTable {
  std::vector<AccuracyCase> cases;
  std::vector<Speedup> speedups;
  std::size_t stated = 0;  ///< of the speed-ups of each mu, the one that stands for the linear response
};

/// Measures, on 500 x 200 beads at mu = 0.1 and 0.3, what each estimator costs and how its c and D scatter over
/// independent repetitions (other seeds), not what its own error bars say. Laws that do not reach piles in which peaks
/// stand apart are measured on the largest piles they are good for, by the scatter of c_thrust alone, and say so. Times
/// are processor seconds of the thread that draws and sums, Fourier transforms included; the fits that follow are the
/// same for all estimators and are left out.
AccuracyTable measure_accuracy(const AccuracyOptions& options, std::ostream& messages);

std::string accuracy_json(const AccuracyTable& table);

}  // namespace granuscope
