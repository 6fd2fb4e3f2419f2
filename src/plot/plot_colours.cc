#include "plot/plot_colours.h"

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "render/palette.h"

namespace granuscope {

namespace {

TemplateVariables read_colours() {
  // The order in which Okabe and Ito list them.
  constexpr std::array names = {"black",  "orange", "sky_blue",  "bluish_green",
                                "yellow", "blue",   "vermilion", "reddish_purple"};
  const std::vector<Rgb>& okabe_ito = Palette::builtin().colours("okabe-ito");
  if (okabe_ito.size() != names.size()) throw std::logic_error("palette.txt: okabe-ito does not have eight colours");
  TemplateVariables colours;
  for (std::size_t i = 0; i < names.size(); ++i) colours[names[i]] = to_hex(okabe_ito[i]);
  colours["frame"] = to_hex(Palette::builtin().colour("frame"));
  return colours;
}

}  // namespace

const TemplateVariables& plot_colours() {
  static const TemplateVariables colours = read_colours();
  return colours;
}

}  // namespace granuscope
