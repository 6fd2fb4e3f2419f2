#pragma once
#include <span>

#include "model/pile.h"

namespace granuscope {

/// The one pile without friction: every force lies along its contact, H_R = V_R/sqrt(3), H_L = -V_L/sqrt(3), and each
/// half of a load, and of the weight of a bead, runs straight down its lattice row; pile.load_line tells how unequal
/// those of a load are, pile.bead_weight what a bead adds. Exact under every law at mu = 0; draws nothing.
void fill_frictionless(std::span<const double> load, Pile& pile);

}  // namespace granuscope
