#include "analysis/law_average.h"

#include <cmath>

namespace granuscope {
namespace {

Estimate average(const std::vector<MeasuredTransport>& results, double tolerance, Estimate Laws::*law,
                 Replicated ReplicatedLaws::*replicated) {
  std::vector<Replicated> powers;
  std::vector<double> weights;
  double total = 0;
  std::string reason = "the experiment contains no friction above 0";
  for (const MeasuredTransport& result : results) {
    const Estimate& power = result.transport.laws.*law;
    if (!power.known()) {
      if (result.transport.mu() > 0) reason = power.reason;
      continue;
    }
    powers.push_back(result.laws.*replicated);
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

Laws average_laws(const std::vector<MeasuredTransport>& results, double tolerance) {
  return {average(results, tolerance, &Laws::position, &ReplicatedLaws::position),
          average(results, tolerance, &Laws::width, &ReplicatedLaws::width),
          average(results, tolerance, &Laws::amplitude, &ReplicatedLaws::amplitude),
          average(results, tolerance, &Laws::noise, &ReplicatedLaws::noise)};
}

}  // namespace granuscope
