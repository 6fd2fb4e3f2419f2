#include "sampling/contact_slacks.h"

#include "model/friction_cone.h"
#include "support/error.h"

namespace granuscope {
namespace {

/// V and H of a contact per unit of N and of T; to_right: of one that leads to the lower right.
struct Directions {
  double V_of_N, V_of_T, H_of_N, H_of_T;
};
Directions directions(bool to_right) {
  const double side = to_right ? 0.5 : -0.5;
  return {sqrt3 / 2, -side, side, sqrt3 / 2};
}

}  // namespace

ContactBalances::ContactBalances(double mu, const Lattice& lattice) : lattice_(lattice), mu_(FrictionCone(mu).mu()) {
  if (!(mu > 0)) {
    throw InputError(
        "without friction an opened contact leaves no solution but straight lines of force; give diluted beads a "
        "friction coefficient above 0");
  }
  first_.push_back(0);
  for (std::size_t contact = 0; contact < contacts(); ++contact) {
    const bool to_right = contact < lattice.beads();
    const std::size_t bead = to_right ? contact : contact - lattice.beads();
    const auto columns = static_cast<std::size_t>(lattice.columns());
    const int layer = static_cast<int>(bead / columns), column = static_cast<int>(bead % columns);
    const Directions d = directions(to_right);
    // N = (low + high)/2, T = mu (low - high)/2.
    const auto add = [&](std::size_t equation, double of_N, double of_T) {
      terms_.push_back({equation, (of_N + mu * of_T) / 2, (of_N - mu * of_T) / 2});
    };
    const auto add_bead = [&](std::size_t at, double sign) {
      add(3 * at, sign * d.V_of_N, sign * d.V_of_T);
      add(3 * at + 1, sign * d.H_of_N, sign * d.H_of_T);
      add(3 * at + 2, 0, 1);
    };
    add_bead(bead, -1);
    if (layer + 1 < lattice.layers()) {
      add_bead(
          lattice.index(layer + 1, to_right ? lattice.lower_right(layer, column) : lattice.lower_left(layer, column)),
          1);
    }
    first_.push_back(terms_.size());
  }
}

void ContactBalances::store(const ContactSlacks& slacks, Pile& pile) const {
  for (std::size_t contact = 0; contact < contacts(); ++contact) {
    const bool to_right = contact < lattice_.beads();
    const std::size_t bead = to_right ? contact : contact - lattice_.beads();
    const double N = (slacks.low[contact] + slacks.high[contact]) / 2;
    const double T = mu_ * (slacks.low[contact] - slacks.high[contact]) / 2;
    const Directions d = directions(to_right);
    (to_right ? pile.V_R : pile.V_L)[bead] = d.V_of_N * N + d.V_of_T * T;
    (to_right ? pile.H_R : pile.H_L)[bead] = d.H_of_N * N + d.H_of_T * T;
  }
  pile.mu = mu_;
}

}  // namespace granuscope
