#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace granuscope {

/// What to draw of a pile, and how large. Windows count from the overloaded bead, as x of a response does.
struct SceneSpec {
  std::string scene = "forces";
  int width_px = 1600;  ///< of the whole image, axes and legend included
  double dpi = 300;     ///< mm = 25.4 px / dpi; text is laid out in points
  /// x0, x1 in bead diameters from the middle and first, last layer; both inclusive. None: the whole pile.
  std::optional<std::array<double, 4>> window;
  std::string colour_map = "grey";
  std::string backend = "auto";
  bool skip_invisible = true;
};

/// What was drawn and what was left out, counted. drawn + outside + too_faint + aggregated = contacts of the pile.
struct SceneCounts {
  std::uint64_t drawn = 0;
  std::uint64_t outside = 0;     ///< contacts outside the window
  std::uint64_t too_faint = 0;   ///< contacts whose contribution rounds to nothing at 8 bits
  std::uint64_t aggregated = 0;  ///< contacts drawn as part of a coarser element
  std::uint64_t pixels = 0;
};

/// Widths an image may have; heights obey the same upper limit.
inline constexpr int min_image_px = 1;
inline constexpr int max_image_px = 32768;

/// Every pixel is the mean of samples_per_axis x samples_per_axis samples, taken in sRGB space: a grey of the map then
/// stays the share of black that was drawn, which linear light would lighten.
inline constexpr int samples_per_axis = 4;

/// The part of the plane that is drawn, in bead diameters: x from the overloaded bead, z down from the surface (the top
/// of layer 0, so that layer n has its centres at Lattice::depth(n)).
struct Extent {
  double x0 = 0, x1 = 0, z0 = 0, z1 = 0;
  double width() const { return x1 - x0; }
  double height() const { return z1 - z0; }
};

/// One contact as it is drawn: a bar with round ends around the line between two points.
struct ContactBar {
  double x0 = 0, z0 = 0;  ///< upper end (centre of the bead that pushes), bead diameters, as in Extent
  double x1 = 0, z1 = 0;  ///< lower end
  float width = 0;        ///< bead diameters
  float strength = 0;     ///< 0 .. 1, the share of the force scale; selects the colour
};

/// The one bead whose load differs from all the others.
struct Overload {
  double x = 0;     ///< bead diameters from the middle
  double load = 0;  ///< units of the load on an ordinary top bead
};

/// What is to be drawn, free of how: bars in the order of drawing (weak before strong, so that chains lie on top).
struct Scene {
  std::string name;
  Extent extent;
  int plot_width_px = 0;  ///< of the plot area alone
  int plot_height_px = 0;
  double pixels_per_diameter = 0;
  std::vector<ContactBar> bars;
  double scale_top = 1;  ///< force of strength 1, units of the load on an ordinary top bead; above 0
  double force_max = 0;  ///< the largest force in the window; beyond scale_top bars look alike
  std::optional<Overload> overload;
  SceneCounts counts;
};

}  // namespace granuscope
