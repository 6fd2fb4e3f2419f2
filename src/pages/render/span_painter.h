#pragma once
#include "render/sample_grid.h"
#include "render/scenes.h"

namespace granuscope {
/// Paints the elements of `scene` without OpenGL into the next rows of a picture, as many as the plot area has, from
/// column `left` on: element by element, in each row of samples the span that lies inside. The samples are those of
/// paint_plot_area(), decided by the same formula in the same precision, so that the pixels are the same; a test holds
/// the two together.
void paint_spans(const Scene& scene, const LevelTable& table, Background background, int left, PictureRows& rows);

/// Paints the plot area of a pile whose beads are smaller than two pixels, without OpenGL, into the next rows of a
/// picture, from column `left` on. Its samples stand on a grid
/// that is locked to the lattice, 8 to a bead diameter across and 7 to a layer downwards; all contacts of one direction
/// and level then cover the same samples, so that each is painted by laying a stored stamp over those there, the higher
/// level winning. Neighbours share samples and pixels, which take the mean of their samples as everywhere else: only
/// the places of the samples differ from those of the full picture, and strengths below 1/255 of the scale.
///
/// How far the two pictures may be apart is stated as detail_distance (tests/render/picture_distance.h), and held by a
/// test.
void paint_detail(const Scene& scene, const LevelTable& table, Background background, int left, PictureRows& rows);

/// Samples of that grid per bead diameter, across.
inline constexpr int detail_samples_per_diameter = 8;

}  // namespace granuscope
