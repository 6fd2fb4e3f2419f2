#include "render/window.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "render/pile_scene.h"
#include "support/error.h"

namespace granuscope {

Extent extent_of(const Lattice& lattice, const SceneSpec& spec) {
  const double half = 0.5 * lattice.columns();
  double x0 = -half, x1 = half, n0 = 0, n1 = lattice.layers() - 1;
  if (spec.window) {
    const auto& window = *spec.window;
    const std::string given = fmt::format("the window {},{},{},{}", window[0], window[1], window[2], window[3]);
    if (!std::all_of(window.begin(), window.end(), [](double value) { return std::isfinite(value); })) {
      throw InputError(given + " is not made of numbers; give X0,X1 in bead diameters and N0,N1 as layers");
    }
    x0 = window[0];
    x1 = window[1];
    n0 = window[2];
    n1 = window[3];
    if (x0 >= x1 || n0 > n1) {
      throw InputError(given + " is empty, so there is nothing to render; it needs X0 < X1 and N0 <= N1");
    }
    if (x1 - x0 < 1) {
      throw InputError(given + " is narrower than a bead, too narrow for an axis; X1 - X0 must be at least 1");
    }
    if (n0 != std::floor(n0) || n1 != std::floor(n1)) {
      throw InputError(given + " cuts through a layer; N0 and N1 are whole numbers, counted from 0 at the top");
    }
    if (n0 < 0 || n1 >= lattice.layers()) {
      throw InputError(fmt::format("{} asks for layers that the pile does not have; it has the layers 0 to {}", given,
                                   lattice.layers() - 1));
    }
    if (x0 < -half || x1 > half) {
      throw InputError(
          fmt::format("{} reaches around the ring of {} columns and would show beads twice; keep X0 and X1 "
                      "between {} and {}",
                      given, lattice.columns(), -half, half));
    }
  }
  // Whole beads: from the top of the first layer to the bottom of the last one.
  return {x0, x1, Lattice::depth(static_cast<int>(n0)) - 0.5, Lattice::depth(static_cast<int>(n1)) + 0.5};
}

PileRange range_needed(const Lattice& lattice, const SceneSpec& spec) {
  const Extent extent = extent_of(lattice, spec);
  if (!spec.skip_invisible) return whole_range(lattice);
  PileRange range = whole_range(lattice);
  range.horizontal = needs_horizontal_forces(spec.scene);
  if (spec.window) {
    // A layer further up or down, a bar is a diameter long and a bead's half wide: no more than one reaches in.
    range.first_layer = std::max(static_cast<int>((*spec.window)[2]) - 1, 0);
    range.layers = std::min(static_cast<int>((*spec.window)[3]) + 2, lattice.layers()) - range.first_layer;
  }
  const int left = static_cast<int>(std::floor(extent.x0)) - 1, right = static_cast<int>(std::ceil(extent.x1)) + 1;
  if (right - left + 1 < lattice.columns()) {
    range.beads = right - left + 1;
    range.first_bead = ((left + lattice.middle()) % lattice.columns() + lattice.columns()) % lattice.columns();
  }
  return range;
}

}  // namespace granuscope
