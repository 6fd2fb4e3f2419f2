#include "sampling/truncated_pair.h"

namespace granuscope {

std::optional<PairDraw> draw_truncated_pair(Interval A, Interval B, Interval D, double u_difference, double u_chord) {
  if (A.empty() || B.empty()) return std::nullopt;
  const auto trapezoid = scalar::cut_trapezoid(A, B, D);
  const double low = trapezoid.low, high = trapezoid.high;
  if (low > high) return std::nullopt;
  const double difference =
      trapezoid.area > 0 ? scalar::difference_at(trapezoid, u_difference) : low + u_difference * (high - low);
  return scalar::pair_apart(A, B, scalar::clamped(difference, low, high), u_chord);
}

}  // namespace granuscope
