#pragma once
#include "model/pile.h"
#include "render/scene.h"

namespace granuscope {

/// Width of a bar at the top of the force scale, in bead diameters; below it widths are in proportion to the force.
inline constexpr double widest_bar = 0.5;

/// Share of the window's contacts that the force scale covers. A few contacts are far stronger than the rest (at
/// large friction a hundred times, and most so in the lowest layer, which carries nothing below it); a scale up to the
/// very strongest would leave the page white.
inline constexpr double scale_quantile = 0.97;

/// What is drawn of a pile. Scene "forces" (right part of Fig. 1 of the paper): each contact is a bar between the
/// centres of the two beads it connects, whose width and darkness follow the magnitude sqrt(V² + H²) of its force, from
/// 0 to the largest one of the window. Contacts that leave the lowest layer are drawn up to the contact point; those
/// that cross the seam of the ring appear on both sides. Contacts beside the window, and those whose colour rounds to
/// the page's at this width and dpi, are left out and counted; with spec.skip_invisible = false every contact is kept,
/// and the picture is the same. Throws InputError: unknown scene or colour map; a force that is not finite; a window
/// that is empty, holds no layer or leaves the pile; an image size that cannot be (see layout.h).
Scene build_scene(const Pile& pile, const SceneSpec& spec);

}  // namespace granuscope
