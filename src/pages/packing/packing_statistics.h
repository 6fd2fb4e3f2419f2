#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "packing/packing.h"

namespace granuscope {
/// A number that is told of a packing; not a number where it cannot be known.
struct PackingNumber {
  std::string name;
  double value = 0;
  std::string about;  ///< what it is, with its unit
};

/// Of the normal forces.
double mean_force(const Packing& packing);

/// What readers of force networks look at first. `mu`: friction coefficient, not a number if it is not known.
std::vector<PackingNumber> packing_numbers(const Packing& packing, double mu);

/// How often a normal force lies in [from, to) means: density, 1 over it, with the error of counting.
struct ForceBin {
  double from = 0, to = 0, density = 0, standard_error = 0;
};
std::vector<ForceBin> normal_force_distribution(const Packing& packing);

}  // namespace granuscope
