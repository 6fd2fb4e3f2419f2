#pragma once
#include <string>
#include <string_view>

namespace granuscope {

/// A gnuplot SVG that WeasyPrint 57 can render. gnuplot writes each point as <use xlink:href='#gpPt6' color='...'> of a
/// shape that paints with fill='currentColor', which makes WeasyPrint raise a ValueError. Here the point shapes are
/// copied once for each colour in use, the colour written out, and every point refers to the copy of its colour.
/// Nothing else changes; an SVG without points comes back as it was.
std::string svg_for_weasyprint(std::string_view svg);

}  // namespace granuscope
