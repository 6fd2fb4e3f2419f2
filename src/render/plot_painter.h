#pragma once
#include "render/gl_context.h"
#include "render/image.h"
#include "render/level_table.h"

namespace granuscope {

/// Paints the elements of `scene` with OpenGL into `image`, whose pixel (left, top) is the upper left one of the plot
/// area. It draws tile by tile, so that memory does not grow with the picture or the pile; a tile is at most tile_px
/// pixels wide and high, before supersampling (0: as many as suit the supersampling). The pixels do not depend on
/// tile_px. Throws EnvironmentError if a tile exceeds what the driver can draw, or if GL reports an error.
void paint_plot_area(const Scene& scene, const LevelTable& table, Background background, GlContext& context,
                     int tile_px, int left, int top, Image& image);

}  // namespace granuscope
