#include "analysis/exponent_average.h"

#include <cmath>

namespace granuscope {
namespace {

Estimate average(const std::vector<MeasuredTransport>& results, double tolerance, Estimate Exponents::*exponent,
                 Replicated ReplicatedExponents::*replicated) {
  std::vector<Replicated> powers;
  std::vector<double> weights;
  double total = 0;
  std::string reason = "the experiment contains no friction above 0";
  for (const MeasuredTransport& result : results) {
    const Estimate& power = result.transport.exponents.*exponent;
    if (!power.known()) {
      if (result.transport.mu() > 0) reason = power.reason;
      continue;
    }
    powers.push_back(result.exponents.*replicated);
    weights.push_back(1 / (power.standard_error * power.standard_error + tolerance * tolerance));
    total += weights.back();
  }
  Estimate unknown;
  unknown.reason = reason;
  if (powers.empty()) return unknown;
  return estimate(transform_all(powers, [&](const std::vector<double>& values) {
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i) sum += weights[i] * values[i];
    return sum / total;
  }));
}

}  // namespace

Exponents average_exponents(const std::vector<MeasuredTransport>& results, double tolerance) {
  return {average(results, tolerance, &Exponents::position, &ReplicatedExponents::position),
          average(results, tolerance, &Exponents::width, &ReplicatedExponents::width),
          average(results, tolerance, &Exponents::amplitude, &ReplicatedExponents::amplitude),
          average(results, tolerance, &Exponents::noise, &ReplicatedExponents::noise)};
}

}  // namespace granuscope
