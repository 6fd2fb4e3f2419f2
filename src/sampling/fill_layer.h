#pragma once
#include "model/friction_cone.h"
#include "model/incoming.h"

namespace granuscope {

/// Fills a layer below what stands above it, each bead with the split H_R = choose_split(bead, forces, interval),
/// without any regard to the layers below. False, and the rest of the layer left as it was, at the first bead that has
/// no solution.
template <typename ChooseSplit>
bool fill_layer(const FrictionCone& cone, int layer, Pile& pile, ChooseSplit choose_split) {
  for (int bead = 0; bead < pile.lattice.columns(); ++bead) {
    const Incoming in = incoming(pile, layer, bead);
    const Outgoing out = balance(in);
    const Interval interval = split_interval(cone, out, in.H);
    if (unsolvable(out, interval)) return false;
    const std::size_t at = pile.lattice.index(layer, bead);
    pile.V_R[at] = out.V_R;
    pile.V_L[at] = out.V_L;
    pile.H_R[at] = choose_split(bead, out, interval);
    pile.H_L[at] = in.H - pile.H_R[at];
  }
  return true;
}

}  // namespace granuscope
