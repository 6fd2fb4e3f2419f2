#pragma once
#include <vector>

#include "model/lattice.h"

namespace granuscope {

/// Of how many beads the rearrangement of each bead consists: redrawn beads that touch belong to one. 0 for a bead that
/// was not redrawn. Both of shape [layers, columns].
void measure_rearrangements(const Lattice& lattice, const std::vector<unsigned char>& redrawn, std::vector<int>& beads);

}  // namespace granuscope
