#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "ensemble/ensemble_spec.h"
#include "model/pile.h"
#include "plot/figure_captions.h"
#include "render/render_pile.h"

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

/// What the beads of one pile of any model carry: a cell for each bead, darker the more weight enters it.
struct WeightsPicture {
  std::string id;     ///< of the figure
  EnsembleSpec pile;  ///< its sampler, lattice and load
  std::uint64_t sample = 0;
  double depth = 0;  ///< how far down it is shown, bead diameters
  SceneSpec scene;   ///< its size, range and backend
  Wording wording;
  std::string redraw;
};

/// Renders it to figures/<id>.png of the run's folder; a figure that says why not where the machine does not let it be
/// made. Throws InputError for a pile or a picture that cannot be.
Figure render_weights(const WeightsPicture& picture, const std::filesystem::path& run_folder,
                      SceneStatistics& statistics);

}  // namespace granuscope
