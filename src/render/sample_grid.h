#pragma once
#include <cstdint>

#include "render/scene.h"

namespace granuscope {

/// Positions in a picture are whole numbers of 1/256 sample, counted from the upper left corner of the plot area.
/// Whether a sample lies in an element is then decided from differences of whole numbers, the same for whatever part of
/// the picture is painted at a time.
inline constexpr int units_per_sample = 256;

/// One element on that grid, as GL reads it: two texels of four 32-bit integers.
struct PackedElement {
  std::int32_t x0, y0, x1, y1;  ///< ends, units
  std::int32_t radius;          ///< units; -1: a box
  std::int32_t level;
  std::int32_t unused[2];
};
static_assert(sizeof(PackedElement) == 32);

/// Turns positions of the scene into units. x is rounded from the middle of the window outwards, so that a mirrored
/// pile gives the mirrored picture. The scene must outlive it.
class Projection {
 public:
  /// `samples`: along each edge of a pixel.
  Projection(const Scene& scene, int samples);
  PackedElement pack(const Element& element) const;

 private:
  std::int32_t across(double x) const;
  std::int32_t down(double z) const;

  const Scene& scene_;
  double middle_;
  double units_per_diameter_;
  std::int32_t middle_units_;
};

}  // namespace granuscope
