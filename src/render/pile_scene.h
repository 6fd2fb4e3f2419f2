#pragma once
#include <memory>
#include <string>
#include <vector>

#include "model/pile_layers.h"
#include "model/pile_view.h"
#include "render/scene.h"

namespace granuscope {

/// Share of the window's elements that the scale covers. A few contacts are far stronger than the rest (at large
/// friction a hundred times, and most so in the lowest layer, which carries nothing below it); a scale up to the very
/// strongest would leave the page white.
inline constexpr double scale_quantile = 0.97;

/// Below this many pixels per bead diameter even the widest bar is thinner than a pixel, and the level of detail takes
/// over: one pixel over the width of the widest bar.
inline constexpr double detail_pixels_per_diameter = 1 / widest_bar;

/// Names of the scenes of a pile, as --scene takes them.
std::vector<std::string> pile_scenes();
/// Whether a scene shows the difference of two piles. Throws InputError if there is no such scene.
bool needs_two_piles(const std::string& scene);
/// Whether it needs H as well as V. Throws InputError if there is no such scene.
bool needs_horizontal_forces(const std::string& scene);
/// The title of its colour scale. Throws InputError if there is no such scene.
std::string key_title_of(const std::string& scene);

/// What can be said against a picture before there is a pile: throws InputError for an unknown scene or colour map, a
/// window that is empty or leaves the lattice, a size that cannot be, a range that is none, or the friction of a pile
/// without any.
void check_drawable(const Lattice& lattice, double mu, const SceneSpec& spec);

/// What is shown of a pile:
/// - "forces" (right part of Fig. 1 of the paper): each contact is a bar between the centres of the two beads it
///   connects, whose width and darkness follow the magnitude sqrt(V² + H²) of its force;
/// - "weight": each bead is a disc, darker the more weight V_R + V_L it passes on;
/// - "friction": each contact is a bar whose colour is the mobilisation |T| / (mu N) of its friction, 0 to 1;
/// - "response": each bead is a disc coloured by how its weight differs from that in the pile `minus`.
/// Contacts that leave the lowest layer are painted up to the contact point; those that cross the seam of the ring
/// appear on both sides. What lies beside the window, and what has a colour that rounds to the page's at this width and
/// dpi, is left out and counted; with spec.skip_invisible = false everything is painted, and the picture is the same.
/// Where a bead is smaller than two pixels the level of detail is used, unless nothing is to be skipped.
///
/// The piles' range must be range_needed() (render/window.h); they are gone through layer by layer, here and when the
/// scene is painted. Throws InputError: unknown scene or colour map; a force that is not finite; piles that do not
/// belong together; a range or window that is empty or leaves the pile; an image size that cannot be (see layout.h).
Scene build_scene(const std::shared_ptr<PileLayers>& pile, const std::shared_ptr<PileLayers>& minus,
                  const SceneSpec& spec);
/// The same of piles in memory, whose arrays must outlive the scene.
Scene build_scene(const PileView& pile, const PileView* minus, const SceneSpec& spec);

}  // namespace granuscope
