#pragma once
#include "render/level_table.h"
#include "render/picture_rows.h"

namespace granuscope {

/// Paints the elements of `scene` without OpenGL into the next rows of a picture, as many as the plot area has, from
/// column `left` on: element by element, in each row of samples the span that lies inside. The samples are those of
/// paint_plot_area(), decided by the same formula in the same precision, so that the pixels are the same; a test holds
/// the two together.
void paint_spans(const Scene& scene, const LevelTable& table, Background background, int left, PictureRows& rows);

}  // namespace granuscope
