#include "sampling/frictionless.h"

#include "model/incoming.h"

namespace granuscope {

void fill_frictionless(std::span<const double> load, Pile& pile) {
  const Lattice& lattice = pile.lattice;
  const double half_weight = pile.bead_weight / 2;
  pile.load.assign(load.begin(), load.end());
  for (int n = 0; n < lattice.layers(); ++n) {
    for (int i = 0; i < lattice.columns(); ++i) {
      const std::size_t at = lattice.index(n, i);
      // A bead hands the force of its upper-left contact on to its lower right and the other way round.
      pile.V_R[at] = half_weight + (n == 0 ? top_load(load[at], pile.load_line).V_UL
                                           : pile.V_R[lattice.index(n - 1, lattice.upper_left(n, i))]);
      pile.V_L[at] = half_weight + (n == 0 ? top_load(load[at], pile.load_line).V_UR
                                           : pile.V_L[lattice.index(n - 1, lattice.upper_right(n, i))]);
      pile.H_R[at] = pile.V_R[at] * tan30;
      pile.H_L[at] = -pile.V_L[at] * tan30;
    }
  }
}

}  // namespace granuscope
