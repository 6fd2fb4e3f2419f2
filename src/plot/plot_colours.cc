#include "plot/plot_colours.h"

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "render/palette.h"
#include "support/template_file.h"

namespace granuscope {

TemplateVariables plot_colours() {
  // The order in which Okabe and Ito list them.
  constexpr std::array names = {"black",  "orange", "sky_blue",  "bluish_green",
                                "yellow", "blue",   "vermilion", "reddish_purple"};
  const Palette palette(template_file("palette.txt"), "templates/palette.txt");
  const std::vector<Rgb>& okabe_ito = palette.colours("okabe-ito");
  if (okabe_ito.size() != names.size()) throw std::logic_error("palette.txt: okabe-ito does not have eight colours");
  TemplateVariables colours;
  for (std::size_t i = 0; i < names.size(); ++i) colours[names[i]] = to_hex(okabe_ito[i]);
  colours["frame"] = to_hex(palette.colour("frame"));
  return colours;
}

}  // namespace granuscope
