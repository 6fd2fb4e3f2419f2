#include "experiment/experiment.h"

#include <fmt/core.h>

#include <algorithm>

#include "analysis/transport.h"
#include "support/error.h"

namespace granuscope {

Experiment::Experiment() = default;

EnsembleSpec Experiment::main_ensemble(double value) const {
  EnsembleSpec spec;
  spec.sampler = sampler_at(value);
  spec.lattice = lattice;
  spec.response = response;
  const bool profiles_wanted = figures.response_profiles && value == shown_value(figures.profile_mu);
  spec.layers = layers_to_record(fit, profiles_wanted ? figures.profile_layers : std::vector<int>{});
  return spec;
}

SceneSpec PictureSpec::scene_like(const ForceChainSpec& chains) const {
  SceneSpec spec = chains.scene;
  spec.scene = scene;
  spec.colour_map = colour_map;
  spec.width_px = width_px;
  const double half = 0.5 * chains.columns;
  spec.window = {{-half, half, 0.0, static_cast<double>(chains.layers - 1)}};
  if (!window.empty()) {
    if (window.size() != 4) {
      throw InputError(fmt::format(
          "a window has four numbers but {} are given; write [x0, x1, first layer, last layer]", window.size()));
    }
    std::copy(window.begin(), window.end(), spec.window->begin());
  }
  if (!range.empty()) {
    if (range.size() != 2) {
      throw InputError(
          fmt::format("a colour scale has two ends but {} numbers are given; write [low, high]", range.size()));
    }
    spec.range = {{range[0], range[1]}};
  }
  return spec;
}

}  // namespace granuscope
