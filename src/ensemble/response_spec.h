#pragma once
#include <cstdint>
#include <string>

namespace granuscope {

/// How the top is loaded.
enum class Load {
  uniform,  ///< 1 on every top bead
  point,    ///< 1 on every top bead, 1 + overload on the middle one
};

/// How the response to a load is measured.
enum class EstimatorName {
  point,        ///< the paper's procedure: overloaded piles minus the uniform load
  paired,       ///< the standard procedure: each pile solved with and without the overload, keeping its random numbers
  multiplexed,  ///< every top load raised or lowered at random; the linear response by cross-correlation
};

/// How the response of an ensemble is measured, and on how many samples.
struct ResponseSpec {
  EstimatorName estimator = EstimatorName::point;
  double overload = 1.0;  ///< extra force on the middle top bead (point, paired)
  double epsilon = 0.25;  ///< share by which each top load is raised or lowered (multiplexed)
  bool opposite = false;  ///< multiplexed: each pile once more with all variations reversed, from the same numbers
  int sign_run = 1;       ///< multiplexed: neighbouring top beads varied alike, see load_signs.h
  std::uint64_t samples = 3456;  ///< numbers 0 .. samples-1 of the seed
  int blocks = 32;               ///< each of whole groups of eight samples (the last group may be incomplete)
};

inline ResponseSpec point_response(double overload) { return {.overload = overload}; }
inline ResponseSpec multiplexed_response(double epsilon, bool opposite = false, int sign_run = 1) {
  return {.estimator = EstimatorName::multiplexed, .epsilon = epsilon, .opposite = opposite, .sign_run = sign_run};
}

/// The load that the response is one to: epsilon (multiplexed) or the overload, in loads of one top bead.
inline double load_size(const ResponseSpec& spec) {
  return spec.estimator == EstimatorName::multiplexed ? spec.epsilon : spec.overload;
}

std::string name_of(Load load);
Load load_named(const std::string& name);

/// "point", "paired", "multiplexed".
std::string name_of(EstimatorName estimator);
/// Throws InputError naming the known estimators.
EstimatorName estimator_named(const std::string& name);

}  // namespace granuscope
