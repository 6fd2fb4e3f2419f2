#include "sampling/blind_layer.h"

#include "model/equilibrium.h"

namespace granuscope {

bool draw_layer_blindly(const RandomKey& key, std::uint32_t attempt, const FrictionCone& cone, int layer, Pile& pile,
                        SamplerCounts& counts) {
  const Lattice& lattice = pile.lattice;
  for (int i = 0; i < lattice.columns(); ++i) {
    const std::size_t at = lattice.index(layer, i);
    const double half_load = pile.load[static_cast<std::size_t>(i)] / 2;
    Incoming in{half_load, half_load, 0};
    if (layer > 0) {
      const std::size_t a = lattice.index(layer - 1, lattice.upper_left(layer, i));
      const std::size_t b = lattice.index(layer - 1, lattice.upper_right(layer, i));
      in = {pile.V_R[a], pile.V_L[b], pile.H_R[a] + pile.H_L[b]};
    }
    const Outgoing out = balance(in);
    const Interval interval = split_interval(cone, out, in.H);
    if (unsolvable(out, interval)) return false;
    const double u = key.attempt(layer, i, attempt).first;
    ++counts.uniforms;
    pile.V_R[at] = out.V_R;
    pile.V_L[at] = out.V_L;
    pile.H_R[at] = point_at(interval, u);
    pile.H_L[at] = in.H - pile.H_R[at];
  }
  return true;
}

}  // namespace granuscope
