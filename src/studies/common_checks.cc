#include "studies/common_checks.h"

#include <algorithm>

#include "ensemble/ensemble_spec.h"
#include "support/describe_bytes.h"

namespace granuscope {

KeyRange friction_range() {
  return KeyRange{.ascending = true,
                  .why = "below 0 friction means nothing, and at sqrt(3) = 1.7320 the cone reaches the horizontal"}
      .within(0, mu_limit)
      .below(mu_limit);
}

KeyRange friction_range_above_zero() {
  KeyRange range = friction_range();
  range.why =
      "at 0 nothing is random, so that there is nothing to measure here, and at sqrt(3) = 1.7320 the cone "
      "reaches the horizontal";
  return std::move(range).above(0);
}

double pile_memory(double columns, double layers) {
  const double numbers_per_bead = 4 + 8;  // a pile's forces, and what a solver keeps beside them
  return 8 * numbers_per_bead * columns * layers;
}

Problem find_lattice_problem(const std::string& columns_key, int columns, const std::string& layers_key, int layers,
                             int least_layers, double memory) {
  if (columns < fewest_columns) {
    return problem(columns_key,
                   "{} columns are too few: on a ring of fewer than 4 a bead meets its neighbour twice; "
                   "give at least 4",
                   columns);
  }
  if (layers < least_layers) {
    return problem(layers_key, "{} layers are too few; give at least {}", layers, least_layers);
  }
  const bool wide = columns > layers;
  if (memory > most_memory) {
    return problem(wide ? columns_key : layers_key,
                   "{} x {} beads would need about {} of memory, more than {}; make the pile smaller", columns, layers,
                   describe_bytes(memory), describe_bytes(most_memory));
  }
  if (columns > most_columns || layers > most_layers) {
    return problem(
        wide ? columns_key : layers_key,
        "{} x {} beads are more than {} {}, of which a slip of the keyboard is the likelier cause (they would "
        "need about {} of memory); make the pile smaller",
        columns, layers, wide ? most_columns : most_layers, wide ? "columns" : "layers", describe_bytes(memory));
  }
  return {};
}

Problem find_samples_problem(const std::string& key, std::uint64_t samples, int blocks) {
  const auto least = group_size * static_cast<std::uint64_t>(blocks);
  if (samples >= least && samples <= most_samples) return {};
  return problem(key, "{} samples in {} blocks: each block needs a whole group of eight; give {} to {}", samples,
                 blocks, least, most_samples);
}

Problem find_check_problem(const std::string& key, const std::vector<double>& checked, const std::string& measured_key,
                           const std::vector<double>& measured) {
  for (const double mu : checked) {
    if (std::find(measured.begin(), measured.end(), mu) != measured.end()) continue;
    return problem(key, "{} is not in {}, so that nothing would be there to hold it against; add it there", mu,
                   measured_key);
  }
  return {};
}

}  // namespace granuscope
