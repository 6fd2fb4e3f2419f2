#pragma once
#include <filesystem>

#include "model/pile.h"
#include "plot/figure.h"

namespace granuscope {

/// Which bead the figure of one bead's forces shows.
struct BeadForcesSpec {
  /// In this layer the bead nearest to the axis of the overload whose four contacts all bear at least half their mean:
  /// a rule, not a choice by looks. The middle bead of the layer if no bead passes.
  int layer = 20;
};

/// The paper's Fig. 1 (left): a bead of the lattice, its four contacts, their friction cones and the forces inside
/// them, in position space and in the plane of normal and tangential force.
/// Writes figures/bead-forces*.csv, .gp, .svg and .pdf below `run_folder`. Throws InputError if the pile does not reach
/// below the layer, EnvironmentError if gnuplot is missing or fails.
Figure plot_bead_forces(const Pile& pile, const BeadForcesSpec& spec, const std::filesystem::path& run_folder);

}  // namespace granuscope
