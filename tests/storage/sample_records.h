#pragma once
#include <cstdint>
#include <limits>

#include "model/pile.h"
#include "storage/ensemble_file.h"

namespace granuscope::test {

/// A pile of awkward numbers: denormals, signed zeros, huge and tiny ones. Not in balance: storage does not ask.
inline Pile awkward_pile(int layers, int columns) {
  using Limits = std::numeric_limits<double>;
  Pile pile{Lattice({.columns = columns, .layers = layers})};
  double value = 1;
  for (auto* forces : {&pile.V_R, &pile.V_L, &pile.H_R, &pile.H_L, &pile.load}) {
    for (double& force : *forces) force = (value += 0.1);
    (*forces)[0] = Limits::denorm_min();
    (*forces)[1] = -0.0;
    (*forces)[2] = -std::nextafter(beyond_sums, 0);
    (*forces)[3] = Limits::min();
  }
  pile.mu = 0.1;
  pile.law = "granusolve";
  pile.seed = std::numeric_limits<std::uint64_t>::max();
  pile.sample = (std::uint64_t{1} << 53) + 1;  // no double
  return pile;
}

inline EnsembleRecord awkward_ensemble() {
  EnsembleRecord record;
  record.configuration = "mu = 0.1\nlaw = \"granusolve\"\n# μ\n";
  record.configuration_key = "0123456789abcdef";
  record.sampling_version = "1";
  record.sums.layers = {0, 3, 4};
  record.sums.count = {8, 0, (std::uint64_t{1} << 60) + 1};
  double value = -1;
  for (const auto& [name, width] : {std::pair{"weight", 5}, {"thrust", 1}}) {
    QuantitySums& sums = record.sums.quantities[name];
    sums.width = width;
    for (auto* values : {&sums.sum, &sums.sum_of_squares}) {
      if (values == &sums.sum_of_squares && !sums.has_squares()) continue;
      values->resize(3U * 3U * static_cast<std::size_t>(width));
      for (double& one : *values) one = (value += 0.3);
      values->front() = std::numeric_limits<double>::denorm_min();
      values->back() = -0.0;
    }
  }
  std::uint64_t count = std::numeric_limits<std::uint64_t>::max();
  for (const auto& [name, counter] : sampler_counters) record.counts.*counter = count--;
  record.failed = {{17, 40, "granuscope sample --mu 0.1 --sample 17"}, {1234567890123, 0, ""}};
  return record;
}

}  // namespace granuscope::test
