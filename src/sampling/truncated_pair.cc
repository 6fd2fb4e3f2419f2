#include "sampling/truncated_pair.h"

#include <algorithm>
#include <cmath>

namespace granuscope {
namespace {

/// Area under a linear density from y0 at 0 to y1 at `length`, up to fraction x of the length, is
/// length (y0 x + (y1 - y0) x^2 / 2). Returns the x in [0, 1] at which the share u of the whole area is reached.
double invert_linear(double y0, double y1, double u) {
  // Stable form of the quadratic's root: no cancellation for y0 ~ y1 nor for y0 = 0.
  const double target = u * (y0 + y1);
  const double root = std::sqrt(std::max(0.0, y0 * y0 + (y1 - y0) * target));
  const double denominator = y0 + root;
  return denominator > 0 ? std::min(1.0, target / denominator) : u;
}

}  // namespace

std::optional<PairDraw> draw_truncated_pair(Interval A, Interval B, Interval D, double u_difference, double u_chord) {
  if (A.empty() || B.empty()) return std::nullopt;
  // Breakpoints of the trapezoid of a - b; the density rises, stays, falls.
  const double corner1 = A.low - B.low, corner2 = A.high - B.high;
  const double lowest = A.low - B.high, rise_end = std::min(corner1, corner2);
  const double fall_start = std::max(corner1, corner2), highest = A.high - B.low;
  const double low = std::max(D.low, lowest), high = std::min(D.high, highest);
  if (low > high) return std::nullopt;

  const double plateau = std::min(A.high - A.low, B.high - B.low);
  const auto density = [&](double d) { return std::max(0.0, std::min({plateau, d - lowest, highest - d})); };
  // At most three linear pieces inside [low, high].
  const double knot1 = std::clamp(rise_end, low, high), knot2 = std::clamp(fall_start, low, high);
  const double y0 = density(low), y1 = density(knot1), y2 = density(knot2), y3 = density(high);
  const double area1 = (knot1 - low) * (y0 + y1) / 2;
  const double area2 = (knot2 - knot1) * (y1 + y2) / 2;
  const double area3 = (high - knot2) * (y2 + y3) / 2;
  const double area = area1 + area2 + area3;

  double d;
  if (!(area > 0)) {
    d = low + u_difference * (high - low);
  } else {
    double share = u_difference * area;
    if (share < area1) {
      d = low + (knot1 - low) * invert_linear(y0, y1, share / area1);
    } else if ((share -= area1) < area2) {
      d = knot1 + (knot2 - knot1) * (share / area2);
    } else {
      share = area3 > 0 ? std::min(1.0, (share - area2) / area3) : 0.0;
      d = knot2 + (high - knot2) * invert_linear(y2, y3, share);
    }
  }
  // Rounding must not carry the difference out of its band: near mu = sqrt(3) forces on both sides differ by orders of
  // magnitude and the next bead would have no solution.
  d = std::clamp(d, low, high);
  const double chord_low = std::max(A.low, B.low + d), chord_high = std::min(A.high, B.high + d);
  const double a = std::clamp(chord_low + u_chord * (chord_high - chord_low), A.low, A.high);
  return PairDraw{a, std::clamp(a - d, B.low, B.high)};
}

}  // namespace granuscope
