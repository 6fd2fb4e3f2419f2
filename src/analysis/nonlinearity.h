#pragma once
#include <array>
#include <string>
#include <vector>

#include "analysis/fit_spec.h"
#include "analysis/side_measurements.h"
#include "analysis/transport.h"

namespace granuscope {

/// What stands for the estimator of piles under the uniform load, which have a thrust ratio but no response.
inline constexpr const char* uniform_load = "uniform";

/// Compares the responses to several loads. Ensembles come friction coefficient by friction coefficient, ascending,
/// each time the same loads; those of one friction coefficient are kept until the next one begins.
///
/// Every shift is taken with its own error: the ensembles share random numbers, so that block b is left out of all of
/// them at once. Their blocks must hold whole rounds of groups, interleaved (ensemble_spec.h): then block b of one
/// holds no pile of another block of the other.
class NonlinearityMeasurer {
 public:
  /// `reference_epsilon`: the multiplexed ensemble that is taken for the linear response. `threads` changes no number.
  NonlinearityMeasurer(const FitSpec& fit, double reference_epsilon, int threads)
      : fit_(fit), reference_epsilon_(reference_epsilon), threads_(threads) {}

  void add(MeasuredEnsemble ensemble);
  Nonlinearity finish();

 private:
  /// One response with the replicates that the exponents need.
  struct Measured {
    LoadResponse response;
    Replicated c, D;  ///< empty if unknown
  };

  struct LawPair;

  void close_friction();
  Measured measure(const MeasuredEnsemble& ensemble, const FitSpec& fit) const;
  static bool has_logarithms(const Measured& one);
  LoadExponents measure_exponents(std::size_t k) const;

  FitSpec fit_;
  double reference_epsilon_;
  int threads_;
  std::vector<MeasuredEnsemble> open_;           ///< of one friction coefficient
  std::vector<std::vector<Measured>> measured_;  ///< by friction coefficient
};

}  // namespace granuscope
