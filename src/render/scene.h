#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace granuscope {

/// What to draw of a pile, and how large. Windows count from the overloaded bead, as x of a response does.
struct SceneSpec {
  std::string scene = "forces";
  int width_px = 1600;   ///< of the whole image, axes and legend included
  double dpi = 300;      ///< mm = 25.4 px / dpi; text is laid out in points
  /// x0, x1 in bead diameters from the middle and first, last layer; both inclusive. None: the whole pile.
  std::optional<std::array<double, 4>> window;
  std::string colour_map = "grey";
  std::string backend = "auto";
  bool skip_invisible = true;
};

/// What was drawn and what was left out, counted.
struct SceneCounts {
  std::uint64_t drawn = 0;
  std::uint64_t outside = 0;     ///< contacts outside the window
  std::uint64_t too_faint = 0;   ///< contacts whose contribution rounds to nothing at 8 bits
  std::uint64_t aggregated = 0;  ///< contacts drawn as part of a coarser element
  std::uint64_t pixels = 0;
};

}  // namespace granuscope
