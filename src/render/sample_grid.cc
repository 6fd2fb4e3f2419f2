#include "render/sample_grid.h"

#include <algorithm>
#include <cmath>

namespace granuscope {
namespace {

/// Far outside (elements that are painted although they lie beside the window) one place is as good as another.
std::int32_t units(double value) {
  constexpr double far = 1 << 29;
  return static_cast<std::int32_t>(std::lround(std::clamp(value, -far, far)));
}

}  // namespace

Projection::Projection(const Scene& scene, int samples)
    : scene_(scene),
      middle_(0.5 * (scene.extent.x0 + scene.extent.x1)),
      units_per_diameter_(scene.pixels_per_diameter * samples * units_per_sample),
      middle_units_(scene.plot_width_px * samples * (units_per_sample / 2)) {}

PackedElement Projection::pack(const Element& element) const {
  PackedElement packed{
      across(element.x0), down(element.z0), across(element.x1), down(element.z1), -1, element.level, {0, 0}};
  if (element.outline == Outline::bar) {
    // At least a sample wide; see make_level_table().
    const double width = std::max(element.width * units_per_diameter_, static_cast<double>(units_per_sample));
    packed.radius = static_cast<std::int32_t>(std::lround(0.5 * width));
  }
  return packed;
}

std::int32_t Projection::across(double x) const { return middle_units_ + units((x - middle_) * units_per_diameter_); }
std::int32_t Projection::down(double z) const { return units((z - scene_.extent.z0) * units_per_diameter_); }

}  // namespace granuscope
