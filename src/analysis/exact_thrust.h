#pragma once
#include <vector>

#include "analysis/measured_ensemble.h"
#include "analysis/side_measurements.h"

namespace granuscope {

/// How the piles are measured out. The less friction, the deeper it takes for top and bottom to be forgotten, and the
/// more beads the law rejection can draw: one pile in ten thousand of 25/mu beads has no failure at mu = 0.3, more
/// below.
struct ExactThrustSize {
  LatticeSpec lattice;
  int margin;  ///< layers at the top and at the bottom that differ from the bulk, 1.2/mu
};

/// As many beads as the law rejection can draw, at a few widths. For mu up to 0.3; at most 400 layers.
std::vector<ExactThrustSize> exact_thrust_sizes(double mu);

/// The thrust ratio in the bulk of uniformly loaded piles, and how much it changes with depth there. Needs every layer
/// recorded, and more of them than twice the margin.
ExactThrust measure_exact_thrust(const MeasuredEnsemble& ensemble, int margin);

}  // namespace granuscope
