#include "plot/plot_colours.h"

#include <array>
#include <sstream>
#include <stdexcept>
#include <string>

#include "support/template_file.h"

namespace granuscope {

namespace {

/// The colours of the line "<name> = #... #..." of the palette.
std::stringstream palette_entry(const std::string& name) {
  std::stringstream lines{std::string(template_file("palette.txt"))};
  for (std::string line; std::getline(lines, line);) {
    std::stringstream words(line);
    std::string first, equals;
    if (words >> first >> equals && first == name && equals == "=") return words;
  }
  throw std::logic_error("palette.txt has no entry " + name);
}

Gaps read_colours() {
  // The order in which Okabe and Ito list them.
  constexpr std::array names = {"black",  "orange", "sky_blue",  "bluish_green",
                                "yellow", "blue",   "vermilion", "reddish_purple"};
  Gaps colours;
  std::stringstream okabe_ito = palette_entry("okabe-ito");
  for (const char* name : names) {
    if (!(okabe_ito >> colours[name])) throw std::logic_error("palette.txt: okabe-ito has fewer than eight colours");
  }
  palette_entry("frame") >> colours["frame"];
  return colours;
}

}  // namespace

const Gaps& plot_colours() {
  static const Gaps colours = read_colours();
  return colours;
}

}  // namespace granuscope
