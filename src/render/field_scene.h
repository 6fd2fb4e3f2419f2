#pragma once
#include <string>
#include <vector>

#include "render/scene.h"

namespace granuscope {

/// Values on cells of width 1 side by side at one depth.
struct FieldRow {
  double z = 0;   ///< of the cells' middle
  double x0 = 0;  ///< left edge of the first cell
  std::vector<double> values;
};

/// A quantity over the plane, such as the mean response P(x, z) of an ensemble, and lines over it.
struct Field {
  std::vector<FieldRow> rows;  ///< z ascending; each reaches half way to the next, but not into a gap between them
  std::string key_title;       ///< of the colour scale
  std::vector<OverlayLine> lines;
};

/// Scene "field": each cell in the colour of its value (negative ones, the noise around 0, as the page), and the lines
/// over it. Layers of spec.window count as in a pile. Throws InputError: no or misshapen rows; a value that is not
/// finite; a window, range, colour map or size that cannot be.
Scene build_field_scene(const Field& field, const SceneSpec& spec);

}  // namespace granuscope
