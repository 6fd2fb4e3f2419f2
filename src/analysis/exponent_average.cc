#include "analysis/exponent_average.h"

#include <cmath>

namespace granuscope {
namespace {

/// What is averaged of one friction coefficient.
struct Averaged {
  const Estimate& shown;
  const Replicated& replicated;
};

template <typename Pick>
Estimate average(const std::vector<MeasuredTransport>& results, double tolerance, Pick pick) {
  std::vector<Replicated> numbers;
  std::vector<double> weights;
  double total = 0;
  Estimate unknown{.reason = "the experiment contains no friction above 0"};
  for (const MeasuredTransport& result : results) {
    if (result.transport.exact) continue;
    const Averaged one = pick(result);
    if (!one.shown.known()) {
      if (!result.transport.is_frictionless()) unknown.reason = one.shown.reason;
      continue;
    }
    numbers.push_back(one.replicated);
    weights.push_back(1 / (one.shown.standard_error * one.shown.standard_error + tolerance * tolerance));
    total += weights.back();
  }
  if (numbers.empty()) return unknown;
  return estimate(transform_all(numbers, [&](const std::vector<double>& values) {
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i) sum += weights[i] * values[i];
    return sum / total;
  }));
}

Estimate average_exponent(const std::vector<MeasuredTransport>& results, double tolerance,
                          Estimate Exponents::*exponent, Replicated ReplicatedExponents::*replicated) {
  return average(results, tolerance, [&](const MeasuredTransport& result) {
    return Averaged{result.transport.exponents.*exponent, result.exponents.*replicated};
  });
}

}  // namespace

Exponents average_exponents(const std::vector<MeasuredTransport>& results, double tolerance) {
  return {average_exponent(results, tolerance, &Exponents::position, &ReplicatedExponents::position),
          average_exponent(results, tolerance, &Exponents::width, &ReplicatedExponents::width),
          average_exponent(results, tolerance, &Exponents::amplitude, &ReplicatedExponents::amplitude),
          average_exponent(results, tolerance, &Exponents::noise, &ReplicatedExponents::noise)};
}

Estimate average_position_offset(const std::vector<MeasuredTransport>& results) {
  return average(results, 0, [](const MeasuredTransport& result) {
    return Averaged{result.transport.position_offset, result.position_offset};
  });
}

}  // namespace granuscope
