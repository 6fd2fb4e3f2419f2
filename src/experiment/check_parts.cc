#include "experiment/check_parts.h"

#include <cmath>

#include "support/describe_bytes.h"

namespace granuscope {

double pile_memory(double columns, double layers) {
  const double numbers_per_bead = 4 + 8;  // a pile's forces, and what a solver keeps beside them
  return 8 * numbers_per_bead * columns * layers;
}

Problem find_lattice_problem(const char* columns_key, int columns, const char* layers_key, int layers, int least_layers,
                             double memory) {
  if (columns < 4) {
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

Problem find_mu_problem(const char* key, double mu) {
  if (std::isfinite(mu) && mu >= 0 && mu < mu_limit) return {};
  return problem(key,
                 "{} is not a friction coefficient that this model has: below 0 it means nothing, and at sqrt(3) "
                 "= 1.7320 the cone reaches the horizontal; give 0 <= mu < 1.7320",
                 mu);
}

}  // namespace granuscope
