#pragma once
#include <span>

#include "model/pile.h"

namespace granuscope {

/// The one pile without friction: every force lies along its contact, H_R = V_R/sqrt(3), H_L = -V_L/sqrt(3), and each
/// half of a load runs straight down its lattice row; pile.load_line tells how unequal they are. Exact under
/// every law at mu = 0; draws nothing.
void fill_frictionless(std::span<const double> load, Pile& pile);

}  // namespace granuscope
