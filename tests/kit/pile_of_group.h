#pragma once
#include <utility>

#include "model/pile.h"
#include "sampling/pile_group.h"

namespace granuscope::test {

/// Pile `k` of a group of which all forces of all layers are kept, taken out.
inline Pile pile_of(const PileGroup& group, std::size_t k) {
  Pile pile(group.lattice);
  const std::size_t beads = group.lattice.beads();
  for (const auto& [from, to] : {std::pair{group.V_R, &pile.V_R}, std::pair{group.V_L, &pile.V_L},
                                 std::pair{group.H_R, &pile.H_R}, std::pair{group.H_L, &pile.H_L}}) {
    for (std::size_t bead = 0; bead < beads; ++bead) (*to)[bead] = from[bead * group.stride + k];
  }
  pile.load.assign(group.loads[k].begin(), group.loads[k].end());
  pile.load_line = group.load_line;
  pile.bead_weight = group.bead_weight;
  pile.mu = group.mu;
  pile.law = group.law;
  pile.seed = group.seed;
  pile.sample = group.first_sample + group.sample_step * k;
  return pile;
}

}  // namespace granuscope::test
