#pragma once
#include <array>
#include <cstddef>

#include "sampling/group_lanes.h"

namespace granuscope {

/// Forces of a row of beads: entry 0 is the first bead of the first pile.
struct ForceRow {
  const double *V_R, *V_L, *H_R, *H_L;
  bool totals = false;  ///< H_L is the H that enters each bead instead, of which H_L is what H_R leaves
};

/// What is measured of a layer: sums over its beads, for each pile.
struct LayerMoments {
  std::array<double, group_lanes> thrust{};    ///< of H_R - H_L
  std::array<double, group_lanes> variance{};  ///< of (w - mean)^2, w = V_R + V_L
};

/// The moments of a row of `beads` beads of 1 or group_lanes piles (`stride`), summed bead by bead in their order. One
/// pile gives H_L, not totals. `mean`: of w, exactly known. Writes the weight w of each entry to `weight`, if that is
/// not null.
LayerMoments measure_row(const ForceRow& row, std::size_t beads, std::size_t stride, double mean, double* weight);

}  // namespace granuscope
