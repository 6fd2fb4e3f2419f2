#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "ensemble/ensemble_spec.h"
#include "plot/figure.h"
#include "plot/figure_captions.h"
#include "render/render_pile.h"

namespace granuscope {

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
