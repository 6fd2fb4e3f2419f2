#pragma once
#include "render/gl_context.h"
#include "render/level_table.h"
#include "render/picture_rows.h"

namespace granuscope {

/// Paints the elements of `scene` with OpenGL into the next rows of a picture, as many as the plot area has, from
/// column `left` on. It paints tile by tile, and opens as many rows as a tile has, so that memory does not grow with
/// the height of the picture or the pile; a tile is at most tile_px pixels wide and high, before supersampling (0: as
/// many as suit the supersampling). The pixels do not depend on tile_px. Throws EnvironmentError if a tile exceeds what
/// the driver can paint, or if GL reports an error.
void paint_plot_area(const Scene& scene, const LevelTable& table, Background background, GlContext& context,
                     int tile_px, int left, PictureRows& rows);

}  // namespace granuscope
