#include "analysis/transport.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "analysis/mean_response.h"
#include "analysis/shape_fit.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

/// |x| and x^2 moments of an exact profile: x_p = sum |x| P, W^2 = sum x^2 P - x_p^2.
void measure_exactly(const EnsembleRecord& record, std::size_t row, double overload, MeasuredDepth& depth) {
  const BlockMeans means = mean_response(record.sums, row, overload);
  const auto columns = static_cast<int>(means.whole.size());
  const int layer = record.sums.layers[row];
  const Lattice lattice({columns, 2});
  const int kind_of_row = record.sums.rows.shifted(layer) ? 1 : 0;
  double first = 0, second = 0;
  for (int i = 0; i < columns; ++i) {
    const double x = lattice.x(kind_of_row, i), pressure = means.whole[static_cast<std::size_t>(i)];
    first += std::abs(x) * pressure;
    second += x * x * pressure;
  }
  const std::vector<double> same(static_cast<std::size_t>(record.sums.blocks()), 0.0);
  const auto constant = [&](double value) { return Replicated{value, std::vector<double>(same.size(), value)}; };
  const double width_squared = std::max(0.0, second - first * first);
  depth.peak = constant(first);
  depth.width_squared = constant(width_squared);
  depth.width = constant(std::sqrt(width_squared));
  depth.peak_by_equal = depth.peak;
  depth.width_squared_by_equal = depth.width_squared;
  depth.fit.identifiable = true;
}

/// x_p and W^2 under these weights, from the whole ensemble and without each block; NaN where the fit does not
/// converge.
struct FittedShapes {
  Replicated peak, width, width_squared;
};
FittedShapes fit_replicates(const LayerSpectrum& spectrum, ModeWeights weights, DoubleGaussian start) {
  const DoubleGaussian none{std::nan(""), std::nan("")};
  const DoubleGaussian whole = weighted_shape(spectrum, spectrum.modes(), weights, start).value_or(none);
  FittedShapes shapes{{whole.peak, {}}, {whole.width, {}}, {whole.width * whole.width, {}}};
  for (std::size_t b = 0; b < spectrum.without_block.size(); ++b) {
    const DoubleGaussian shape = weighted_shape(spectrum, spectrum.modes_without(b), weights, whole).value_or(none);
    shapes.peak.without_block.push_back(shape.peak);
    shapes.width.without_block.push_back(shape.width);
    shapes.width_squared.without_block.push_back(shape.width * shape.width);
  }
  return shapes;
}

bool all_known(const Replicated& number) {
  return std::isfinite(number.value) &&
         std::ranges::all_of(number.without_block, [](double value) { return std::isfinite(value); });
}

/// Nothing is fitted, for `reason` unless there is one already.
void set_unknown(const char* reason, const LayerSpectrum& spectrum, MeasuredDepth& depth) {
  const Replicated unknown{std::nan(""), std::vector<double>(spectrum.without_block.size(), std::nan(""))};
  depth.peak = depth.width = depth.width_squared = depth.peak_by_equal = depth.width_squared_by_equal = unknown;
  if (depth.fit.reason.empty()) depth.fit.reason = reason;
}

constexpr const char* no_fit = "the fit of the double Gaussian did not converge; more piles have less noise";

/// The verdict on the shape, chi^2 by the noise of this layer. None if nothing fits.
std::optional<ShapeFit> judge_shape(const LayerSpectrum& spectrum, const FitSpec& spec, MeasuredDepth& depth) {
  const auto whole = fit_shape(spectrum, coarse_shape(spectrum, depth.fit.z / spectrum.pitch));
  // A width of nothing that misses more than there is: a fit that is worse than none.
  if (!whole || (whole->misfit_at_least > 1 && whole->shape.width < spec.min_identifiable_width)) {
    set_unknown(no_fit, spectrum, depth);
    return {};
  }
  depth.fit.evidence = weigh_peaks(spectrum, *whole);
  depth.fit.degrees_of_freedom = whole->degrees_of_freedom;
  depth.fit.chi2_per_dof = whole->chi2 / whole->degrees_of_freedom;
  depth.fit.misfit = whole->misfit;
  depth.fit.misfit_at_least = whole->misfit_at_least;
  depth.other_shape = !reason_against_two_gaussians(*whole).empty();
  depth.fit.reason = reason_against_identification(*whole, depth.fit.evidence, spec);
  return whole;
}

/// x_p and W go by weights that do not look at the noise.
void measure_by_fit(const LayerSpectrum& spectrum, const FitSpec& spec, MeasuredDepth& depth) {
  const auto whole = judge_shape(spectrum, spec, depth);
  if (!whole) return;
  const FittedShapes shapes = fit_replicates(spectrum, ModeWeights::by_width, whole->shape);
  if (!all_known(shapes.peak)) return set_unknown(no_fit, spectrum, depth);
  depth.peak = shapes.peak;
  depth.width = shapes.width;
  depth.width_squared = shapes.width_squared;
  const FittedShapes by_equal = fit_replicates(spectrum, ModeWeights::equal, {depth.peak.value, depth.width.value});
  depth.peak_by_equal = by_equal.peak;
  depth.width_squared_by_equal = by_equal.width_squared;
  depth.fit.identifiable = depth.fit.reason.empty();
  if (depth.fit.identifiable && in_window(spec, depth.fit.layer)) {
    depth.inside.emplace().diagnostics = diagnose_shape(spectrum, *whole, {depth.peak.value, depth.width.value});
  }
}

/// A layer without anything measured but its thrust.
MeasuredDepth depth_of(const MeasuredEnsemble& ensemble, std::size_t row) {
  MeasuredDepth depth;
  depth.fit.layer = ensemble.record.sums.layers[row];
  depth.fit.z = ensemble.record.sums.rows.depth(depth.fit.layer);
  return depth;
}

/// From columns to bead diameters.
void scale(double pitch, MeasuredDepth& depth) {
  if (pitch == 1) return;
  const auto by = [](double factor, std::initializer_list<Replicated*> numbers) {
    for (Replicated* number : numbers) *number = transform([&](double value) { return factor * value; }, *number);
  };
  by(pitch, {&depth.peak, &depth.width, &depth.peak_by_equal});
  by(pitch * pitch, {&depth.width_squared, &depth.width_squared_by_equal});
  if (!depth.inside) return;
  by(1 / pitch, {&depth.inside->height});
  by(pitch, {&depth.inside->diagnostics.peak});
  by(pitch * pitch, {&depth.inside->diagnostics.width_squared});
}

constexpr const char* nothing_fluctuates =
    "piles without friction are all alike, so that there are no fluctuations to follow";

}  // namespace

MeasuredDepth measure_depth(const MeasuredEnsemble& ensemble, const FitSpec& spec, std::size_t row) {
  const EnsembleRecord& record = ensemble.record;
  MeasuredDepth depth = depth_of(ensemble, row);
  depth.thrust = block_mean(record.sums, "thrust", row);
  const LayerSpectrum spectrum = layer_spectrum(record.sums, row, ensemble.spec.response.overload);
  if (spectrum.whole.empty()) {
    set_unknown(nothing_fluctuates, spectrum, depth);
  } else if (spectrum.exact) {
    measure_exactly(record, row, ensemble.spec.response.overload, depth);
  } else {
    measure_by_fit(spectrum, spec, depth);
  }
  if (depth.inside) {
    depth.inside->height =
        peak_height(mean_response(record.sums, row, ensemble.spec.response.overload), Lattice({spectrum.columns, 2}),
                    spectrum.half_shifted ? 1 : 0, depth.peak, depth.width);
    depth.inside->noise = residual_noise(spectrum, depth.peak, depth.width);
  }
  scale(spectrum.pitch, depth);
  depth.fit.peak_position = estimate(depth.peak, depth.fit.reason);
  depth.fit.width = estimate(depth.width, depth.fit.reason);
  depth.fit.width_squared = estimate(depth.width_squared, depth.fit.reason);
  depth.fit.thrust_ratio = estimate(depth.thrust);
  if (depth.inside) {
    depth.fit.peak_height = estimate(depth.inside->height);
    depth.fit.fitted_area = estimate(depth.inside->diagnostics.area, no_extended_fit);
    depth.fit.centre_background = estimate(depth.inside->diagnostics.background, no_extended_fit);
  } else {
    depth.fit.peak_height.reason = depth.fit.fitted_area.reason = depth.fit.centre_background.reason =
        "measured only at identifiable depths of the window, and where there is scatter";
  }
  return depth;
}

MeasuredDepth measure_depth_values(const MeasuredEnsemble& ensemble, const FitSpec& spec, std::size_t row) {
  const double overload = ensemble.spec.response.overload;
  MeasuredDepth depth = depth_of(ensemble, row);
  LayerSpectrum spectrum = layer_spectrum(ensemble.record.sums, row, overload);
  if (spectrum.exact) {
    measure_exactly(ensemble.record, row, overload, depth);
    scale(spectrum.pitch, depth);
    return depth;
  }
  spectrum.without_block.clear();
  if (spectrum.whole.empty()) {
    set_unknown(nothing_fluctuates, spectrum, depth);
  } else if (const auto whole = judge_shape(spectrum, spec, depth)) {
    const FittedShapes shapes = fit_replicates(spectrum, ModeWeights::by_width, whole->shape);
    depth.peak = shapes.peak;
    depth.width_squared = shapes.width_squared;
    depth.fit.identifiable = depth.fit.reason.empty() && std::isfinite(shapes.peak.value);
  }
  scale(spectrum.pitch, depth);
  return depth;
}

}  // namespace granuscope
