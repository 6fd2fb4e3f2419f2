#pragma once
#include "render/colour_scale.h"
#include "render/font.h"
#include "render/image.h"
#include "render/layout.h"
#include "render/palette.h"

namespace granuscope {

/// Draws everything of `layout` that is not the plot area: frame, ticks, labels, arrow, scale bar and colour scale.
void draw_furniture(const Scene& scene, const Layout& layout, const Palette& palette, const ColourScale& scale,
                    const Font& font, Image& image);

}  // namespace granuscope
