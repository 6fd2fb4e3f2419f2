#pragma once
#include "render/colour_scale.h"
#include "render/gl_context.h"
#include "render/image.h"
#include "render/scene.h"

namespace granuscope {

/// Paints the bars of `scene` into `image`, whose pixel (left, top) is the upper left one of the plot area. It draws
/// tile by tile, so that memory does not grow with the picture; a tile is at most tile_px pixels wide and high, before
/// supersampling. The pixels do not depend on tile_px. Throws EnvironmentError if a tile exceeds what the driver can
/// draw, or if GL reports an error.
void paint_plot_area(const Scene& scene, const ColourScale& scale, GlContext& context, int tile_px, int left, int top,
                     Image& image);

}  // namespace granuscope
