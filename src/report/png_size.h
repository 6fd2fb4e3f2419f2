#pragma once
#include <optional>
#include <string_view>

namespace granuscope {

/// How wide a PNG is at its own resolution (chunks IHDR and pHYs), so that text laid out in points stays that large on
/// paper. Nothing if it states no resolution or is no PNG.
std::optional<double> png_width_mm(std::string_view png);

}  // namespace granuscope
