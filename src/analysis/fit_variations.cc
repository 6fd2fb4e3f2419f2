#include "analysis/fit_variations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace granuscope {
namespace {

constexpr std::size_t fewest_depths = 3;  ///< from which a slope is taken
constexpr int edge_rounds = 4;            ///< each moves the edge by less than a tenth of the move before
constexpr std::size_t parts = 4;          ///< of the window, one of which a neighbour has more or less

VariationSlopes measure(const char* change, const FittedRun& part, const std::string& reason, const Replicated& c,
                        const Replicated& D) {
  VariationSlopes variation;
  FitVariation& shown = variation.shown;
  shown.change = change;
  if (!reason.empty()) {
    for (Estimate* e : {&shown.c, &shown.D, &shown.c_shift, &shown.D_shift}) e->reason = reason;
    return variation;
  }
  const TransportLines lines = transport_lines(part);
  const auto minus = [](double a, double b) { return a - b; };
  variation.c = lines.position.slope;
  variation.D = lines.width.slope;
  shown.layers = {part.layers.front(), part.layers.back()};
  shown.depths = static_cast<int>(part.layers.size());
  shown.c = estimate(variation.c);
  shown.D = estimate(variation.D);
  shown.c_shift = estimate(transform(minus, variation.c, c));
  shown.D_shift = estimate(transform(minus, variation.D, D));
  return variation;
}

}  // namespace

FittedRun part_of(const FittedRun& run, std::size_t first, std::size_t last) {
  const auto cut = [&](const auto& list) {
    return std::decay_t<decltype(list)>(list.begin() + static_cast<std::ptrdiff_t>(first),
                                        list.begin() + static_cast<std::ptrdiff_t>(last));
  };
  const auto cut_series = [&](const DepthSeries& series) { return DepthSeries{cut(series.z), cut(series.y)}; };
  return {.layers = cut(run.layers),
          .peaks = cut_series(run.peaks),
          .widths = cut_series(run.widths),
          .peaks_by_equal = cut_series(run.peaks_by_equal),
          .widths_by_equal = cut_series(run.widths_by_equal),
          .edge = run.edge};
}

TransportLines transport_lines(const FittedRun& run) {
  return {line_through(run.peaks, run.edge), line_through(run.widths, run.edge)};
}

WindowEdge edge_of(const FittedRun& run, double min_width, double reach) {
  const FittedRun window = part_of(run, run.window_start, run.layers.size());
  const auto crossing = [&](double intercept, double slope) {
    return slope > 0 ? (min_width * min_width - intercept) / slope : -std::numeric_limits<double>::infinity();
  };
  // The line itself must not jump with the first depth either: it goes through the depths as the edge counts them.
  WindowEdge edge;
  for (int round = 0; round < edge_rounds; ++round) {
    const ReplicatedLine line = line_through(window.widths, edge);
    edge = {transform(crossing, line.intercept, line.slope), reach};
  }
  return edge;
}

std::vector<VariationSlopes> measure_variations(const FittedRun& run, const Replicated& c, const Replicated& D) {
  const std::size_t start = run.window_start, end = run.layers.size(), depths = end - start;
  const std::size_t quarter = std::max<std::size_t>(1, depths / parts);
  const std::size_t above = std::min(quarter, start);
  const std::string too_short = depths < fewest_depths + quarter
                                    ? fmt::format("a quarter less than {} depths leaves too few for a slope", depths)
                                    : "";
  const std::string nothing_above = above == 0 ? "no depth just above the window can be fitted" : "";
  FittedRun other_weights = part_of(run, start, end);
  other_weights.peaks = other_weights.peaks_by_equal;
  other_weights.widths = other_weights.widths_by_equal;
  const auto window = [&](std::size_t first, std::size_t last, const std::string& reason) {
    return reason.empty() ? part_of(run, first, last) : FittedRun{};
  };
  return {
      measure("without_shallowest_quarter", window(start + quarter, end, too_short), too_short, c, D),
      measure("without_deepest_quarter", window(start, end - quarter, too_short), too_short, c, D),
      measure("longer_above", window(start - above, end, nothing_above), nothing_above, c, D),
      measure("equal_weights", other_weights, "", c, D),
  };
}

double systematic_spread(const std::vector<Estimate>& shifts) {
  double sum = 0;
  int known = 0;
  for (const Estimate& shift : shifts) {
    if (!shift.known() || !std::isfinite(shift.standard_error)) continue;
    sum += shift.value * shift.value - shift.standard_error * shift.standard_error;
    ++known;
  }
  return known == 0 ? std::numeric_limits<double>::quiet_NaN() : std::sqrt(std::max(0.0, sum / known));
}

}  // namespace granuscope
