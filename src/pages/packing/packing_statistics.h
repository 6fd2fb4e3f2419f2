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

/// A contact slides where |T| reaches mu N to this share, and breaks Coulomb's law above it.
inline constexpr double sliding_share = 1e-3;

/// Of the normal forces.
double mean_force(const Packing& packing);

/// What readers of force networks look at first. `mu`: friction coefficient, not a number if it is not known.
std::vector<PackingNumber> packing_numbers(const Packing& packing, double mu);

/// How often a value lies in [from, to): density, 1 over the unit of the value, with the error of counting.
struct ForceBin {
  double from = 0, to = 0, density = 0, standard_error = 0;
};
/// Of contacts that do not pull: N over its mean; |T|/(mu N) (mu = 1 if it is not known), empty without T; the
/// direction of the line between the centres, in degrees from x, 0 to 180, of all that are placed.
enum class Distributed { normal_force, friction, direction };
std::vector<ForceBin> distribution(const Packing& packing, Distributed of, double mu);

/// What the contacts exert on each particle, in the order of Packing::particles; not a number where it is not known.
struct OfParticle {
  int contacts = 0;
  double x = 0, y = 0;  ///< sum of forces
  double torque = 0;    ///< about its centre
  double largest = 0;   ///< force
};
std::vector<OfParticle> forces_on_particles(const Packing& packing);

}  // namespace granuscope
