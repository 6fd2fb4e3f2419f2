#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "model/pile.h"

namespace granuscope {

/// Which contacts of a pile are opened, by their numbers: contact k < beads leads from bead k (Lattice::index) to its
/// lower-right neighbour, contact beads + k to its lower-left one. Shape [2 beads].
using OpenedContacts = std::vector<std::uint8_t>;

/// How far each contact is inside its friction cone: low = N + T/mu, high = N - T/mu, in loads of one top bead. Both
/// are at least 0 inside the cone, and in a frictionless pile of uniform load 1/sqrt 3. Shape [2 beads] each; an opened
/// contact has 0.
struct ContactSlacks {
  std::vector<double> low, high;
};

/// What a contact's slacks add to one balance.
struct BalanceTerm {
  std::size_t equation;  ///< 3 bead: vertical, + 1: horizontal, + 2: torque balance
  double of_low, of_high;
};

/// The balances of all beads as linear equations in the slacks: two unknowns for each closed contact, three equations
/// for each bead (model/audit.cc has the same in N and T). The top is loaded vertically through the centres; the bottom
/// rests on a floor that bears everything.
class ContactBalances {
 public:
  /// Throws InputError if mu is 0 or out of range.
  ContactBalances(double mu, const Lattice& lattice);

  const Lattice& lattice() const { return lattice_; }
  double mu() const { return mu_; }
  std::size_t contacts() const { return 2 * lattice_.beads(); }
  std::size_t equations() const { return 3 * lattice_.beads(); }
  /// Of the bead that it leads from, and of the one that it leads to unless that is the floor.
  std::span<const BalanceTerm> terms(std::size_t contact) const {
    return {terms_.data() + first_[contact], first_[contact + 1] - first_[contact]};
  }
  /// What the terms of an equation add up to under a load of shape [columns].
  double right_side(std::size_t equation, std::span<const double> load) const {
    return equation % 3 == 0 && equation / 3 < load.size() ? -load[equation / 3] : 0;
  }
  /// Its forces into a pile of this lattice; the load is the caller's.
  void store(const ContactSlacks& slacks, Pile& pile) const;

 private:
  Lattice lattice_;
  double mu_;
  std::vector<BalanceTerm> terms_;
  std::vector<std::size_t> first_;
};

}  // namespace granuscope
