#pragma once
#include <optional>

#include "model/equilibrium.h"
#include "sampling/rounding.h"

namespace granuscope {

using PairDraw = scalar::PairOf<double>;

/// Draws (a, b) uniformly on the polygon { a in A, b in B, a - b in D } from two uniform numbers in [0, 1).
/// The difference d = a - b has the density of a trapezoid (the length of the polygon's chord at d), cut to D; its
/// distribution is piecewise quadratic and is inverted in closed form, then a is uniform on the chord.
/// None if the polygon is empty. A polygon without area (a segment, a point) is sampled along its length.
std::optional<PairDraw> draw_truncated_pair(Interval A, Interval B, Interval D, double u_difference, double u_chord);

}  // namespace granuscope
