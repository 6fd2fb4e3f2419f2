#pragma once
#include "plot/template_variables.h"

namespace granuscope {

/// The categorical colours of templates/palette.txt (Okabe and Ito) by name, as "#rrggbb": black, orange, sky_blue,
/// bluish_green, yellow, blue, vermilion, reddish_purple, and frame for decorations. Throws std::logic_error if the
/// palette lacks one.
TemplateVariables plot_colours();

}  // namespace granuscope
