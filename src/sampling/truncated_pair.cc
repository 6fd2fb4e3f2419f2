#include "sampling/truncated_pair.h"

#include <algorithm>
#include <cmath>

namespace granuscope {

std::optional<PairDraw> draw_truncated_pair(Interval A, Interval B, Interval D, double u_difference, double u_chord) {
  if (A.empty() || B.empty()) return std::nullopt;
  // Breakpoints of the trapezoid of a - b; the density rises, stays, falls.
  const double corner1 = A.low - B.low, corner2 = A.high - B.high;
  const double lowest = A.low - B.high, rise_end = std::min(corner1, corner2);
  const double fall_start = std::max(corner1, corner2), highest = A.high - B.low;
  const double low = std::max(D.low, lowest), high = std::min(D.high, highest);
  if (low > high) return std::nullopt;

  const double plateau = std::min(A.high - A.low, B.high - B.low);
  const auto density = [&](double d) { return std::min({plateau, d - lowest, highest - d}); };
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
    // From the start of its piece on, where the density is y and its slope s, the area grows as y x + s x^2 / 2. The
    // root of that is written without cancellation.
    double grown = u_difference * area, start = low, y = y0, slope = 1;
    if (!(grown < area1)) {
      grown -= area1;
      if (grown < area2) {
        start = knot1, y = y1, slope = 0;
      } else {
        grown -= area2;
        start = knot2, y = y2, slope = -1;
      }
    }
    const double twice = 2 * grown;
    const double root = slope == 0 ? y : std::sqrt(std::max(0.0, y * y + slope * twice));
    d = start + (y + root > 0 ? twice / (y + root) : 0);
  }
  // Rounding must not carry the difference out of its band: near mu = sqrt(3) forces on both sides differ by orders of
  // magnitude and the next bead would have no solution.
  d = std::clamp(d, low, high);
  const double chord_low = std::max(A.low, B.low + d), chord_high = std::min(A.high, B.high + d);
  const double a = std::clamp(chord_low + u_chord * (chord_high - chord_low), A.low, A.high);
  return PairDraw{a, std::clamp(a - d, B.low, B.high)};
}

}  // namespace granuscope
