#include "analysis/depth_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "analysis/line_fit.h"

namespace granuscope {
namespace {

constexpr std::size_t blocks_per_tested_depth = 4;
constexpr std::size_t always_counted = 3;  ///< depths that no edge takes away: a line needs them

}  // namespace

std::vector<double> depth_weights(const std::vector<double>& z) {
  std::vector<double> weights;
  weights.reserve(z.size());
  for (const double depth : z) weights.push_back(1 / (depth * depth));
  return weights;
}

ReplicatedLine line_through(const DepthSeries& series, const WindowEdge& edge) {
  const std::vector<double> weights = depth_weights(series.z);
  std::vector<Replicated> numbers = series.y;
  if (edge.reach > 0) numbers.push_back(edge.z);
  const auto part = [&](auto pick) {
    return transform_all(numbers, [&](const std::vector<double>& values) {
      std::vector<double> reduced = weights;
      for (std::size_t i = 0; edge.reach > 0 && i + always_counted < reduced.size(); ++i) {
        reduced[i] *= std::clamp((series.z[i] - values.back()) / edge.reach, 0.0, 1.0);
      }
      return pick(fit_line(series.z, std::span(values).first(series.z.size()), reduced));
    });
  };
  return {part([](const Line& l) { return l.slope; }), part([](const Line& l) { return l.intercept; })};
}

Replicated growth_exponent(const DepthSeries& series) {
  const std::vector<double> weights = depth_weights(series.z);
  std::vector<double> cubes;
  for (const double z : series.z) cubes.push_back(z * z * z);
  const double middle = fit_parabola(series.z, cubes, weights).curvature / 3;
  std::vector<double> u;
  for (const double z : series.z) u.push_back((z - middle) / middle);
  return transform_all(series.y, [&](const std::vector<double>& y) {
    const Parabola parabola = fit_parabola(u, y, weights);
    return 1 + 2 * parabola.curvature / parabola.slope;
  });
}

LineTest test_line(const DepthSeries& series) {
  const std::size_t blocks = series.y.empty() ? 0 : series.y.front().without_block.size();
  const std::size_t depths = std::min(series.z.size(), blocks / blocks_per_tested_depth);
  if (depths < 3) {
    LineTest test;
    test.points = static_cast<int>(depths);
    test.reason = fmt::format("{} blocks give no covariance of three depths", blocks);
    return test;
  }
  DepthSeries tested;
  for (std::size_t i = 0; i < depths; ++i) {
    const std::size_t k = i * (series.z.size() - 1) / (depths - 1);
    tested.z.push_back(series.z[k]);
    tested.y.push_back(series.y[k]);
  }
  return test_line(tested.z, tested.y);
}

}  // namespace granuscope
