#include "plot/series_style.h"

#include <fmt/format.h>

#include <array>

#include "plot/plot_colours.h"

namespace granuscope {

std::string series_style(std::size_t index) {
  constexpr std::array colours = {"blue", "vermilion", "bluish_green", "reddish_purple", "orange", "black"};
  constexpr std::array markers = {7, 5, 13, 9, 11, 6, 4};
  return fmt::format("pointtype {} linecolor rgb '{}'", markers[index % markers.size()],
                     plot_colours().at(colours[index % colours.size()]));
}

}  // namespace granuscope
