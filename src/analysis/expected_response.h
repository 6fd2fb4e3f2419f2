#pragma once
#include <vector>

#include "sampling/sampler_spec.h"

namespace granuscope {

// What a response will be like, before anything is drawn.

/// Expected width W of a response peak in bead diameters at depth z, for making sure that the two peaks stay apart:
/// W^2 = 1 + D z with D = 2.2 mu^2.5, which lies above every D measured on 500 x 200 beads up to mu = 0.5.
double expected_width(double mu, double z);

/// Expected speed x_p/z of a peak, for the same purpose: tan 30 degrees, which no peak exceeds up to mu = 1, and
/// 0.8 (mu - 1)^2 more beyond. Lies above what 800 x 200 beads show: 0.61 at mu = 1.3, 0.68 at 1.5, 0.89 at 1.7.
double expected_speed(double mu);

/// Columns of a ring on which the two peaks of the response are still apart down to `layer`.
double columns_needed(double mu, int layer);
/// The fewest columns, from `columns` on, of a ring on which they are apart at each of these layers alone, however
/// often they have met on the way there, at each of these friction coefficients: fits in Fourier modes need no more.
int columns_apart(const std::vector<double>& mu, const std::vector<int>& layers, int columns);
/// Widths of a peak on the smallest ring that has two waves of k W < 2, which count in a fit of x_p and W.
inline constexpr double widths_of_ring = 6;
/// The fewest columns, from `columns` on, of a ring of so many widths at each of these layers: enough where sines tell
/// a peak from the one that moves to the other side, be they apart or not.
int columns_of_waves(const std::vector<double>& mu, const std::vector<int>& layers, int columns);
/// The same as columns_needed of any model.
double columns_needed(const SamplerSpec& sampler, int layer);

}  // namespace granuscope
