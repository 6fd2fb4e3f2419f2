#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "studies/study.h"

namespace granuscope {

/// The thrust ratio under the law rejection, away from top and bottom.
struct RejectionThrust {
  EnsembleSpec spec;
  std::uint64_t samples = 0;            ///< piles that entered
  std::uint64_t failed = 0;             ///< piles that could not be completed
  int first_layer = 0, last_layer = 0;  ///< of the bulk
  Estimate alpha;                       ///< mean over the bulk
  Estimate deficit_over_mu2;            ///< (1 - alpha)/mu^2
  Estimate change_with_depth;           ///< alpha of the lower half of the bulk minus that of its upper half
  Estimate alpha_of_last_layer;
};

/// How the piles are measured out. The less friction, the deeper it takes for top and bottom to be forgotten, and the
/// more beads the law rejection can draw: one pile in ten thousand of 25/mu beads has no failure at mu = 0.3, more
/// below.
struct RejectionThrustSize {
  LatticeSpec lattice;
  int margin;  ///< layers at the top and at the bottom that differ from the bulk, 1.2/mu
};

/// As many beads as the law rejection can draw, at a few widths. For mu up to 0.3; at most 400 layers.
std::vector<RejectionThrustSize> rejection_thrust_sizes(double mu);

/// The thrust ratio in the bulk of uniformly loaded piles, and how much it changes with depth there. Needs every layer
/// recorded, and more of them than twice the margin.
RejectionThrust measure_rejection_thrust(const MeasuredEnsemble& ensemble, int margin);

/// Whether the thrust ratio tends to 1 under the law rejection; `measured`: what was found, if that is known already.
std::unique_ptr<Study> rejection_thrust_study(std::vector<RejectionThrust> measured = {});

}  // namespace granuscope
