#include "studies/model_classes/results.h"

#include <stdexcept>
#include <utility>

#include "analysis/scaling.h"
#include "sampling/pile_group.h"

namespace granuscope {
namespace {

/// The c and D of theory where there is one, for peaks as wide as these are.
void set_expected(const ModelSpec& model, ModelResponse& response) {
  response.c_expected = response.D_expected = std::nan("");
  const double spacing = rows_of(model).spacing;
  if (model.name == ModelName::q_model) {
    // A random walk of half a bead either way in every row.
    response.D_expected = 0.25 / spacing;
  }
  const ThreeLegSpec& legs = model.three_leg;
  const bool free_legs = model.name == ModelName::three_leg && legs.law == MiddleLaw::free;
  if (!free_legs && model.name != ModelName::stochastic_osl) return;
  const NoiseTheory theory = noise_theory(model);
  response.c_expected = theory.c(response.width);
  response.D_expected = theory.D(response.width);
  if (!free_legs || legs.cell_rows > 1) response.theory = theory;
}

/// What the noise alone does, beside its theory.
void compare_with_theory(const MeasuredTransport& measured, ModelResponse& response) {
  const NoiseTheory& theory = *response.theory;
  const auto loss = [&](double speed) { return 1 - speed * speed / (theory.c0 * theory.c0); };
  const Estimate& thrust = response.c_thrust;
  response.thrust_loss = thrust;
  if (thrust.known()) {
    response.thrust_loss.value = loss(thrust.value);
    response.thrust_loss.standard_error = 2 * thrust.value * thrust.standard_error / (theory.c0 * theory.c0);
  }
  response.speed_loss.reason = response.spreading_gain.reason = response.c.reason;
  if (!response.c.known()) return;
  response.speed_loss = estimate(transform(loss, measured.c));
  response.spreading_gain = estimate(transform([&](double spreading) { return spreading - theory.D0; }, measured.D));
}

std::vector<StressAtDepth> stress_with_depth(const MeasuredEnsemble& ensemble) {
  const BlockSums& sums = ensemble.record.sums;
  std::vector<StressAtDepth> stress;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    stress.push_back({sums.rows.depth(sums.layers[row]),
                      mean_weight(ensemble.spec.sampler.bead_weight, sums.layers[row]),
                      estimate(block_mean(sums, "thrust", row)), estimate(block_mean(sums, "weight_variance", row))});
  }
  return stress;
}

/// D and the power of z of the single Gaussian that fits each depth of the window best.
void measure_one_peak(const MeasuredEnsemble& ensemble, const FitSpec& fit, MeasuredModel& measured) {
  const BlockSums& sums = ensemble.record.sums;
  DepthSeries widths;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    if (!in_window(fit, sums.layers[row])) continue;
    const LayerSpectrum spectrum = layer_spectrum(sums, row, ensemble.spec.response.overload);
    Replicated width{single_width_squared(spectrum, spectrum.whole), {}};
    for (const auto& modes : spectrum.without_block) {
      width.without_block.push_back(single_width_squared(spectrum, modes));
    }
    widths.z.push_back(sums.rows.depth(sums.layers[row]));
    widths.y.push_back(std::move(width));
  }
  measured.D = line_through(widths).slope;
  measured.response.D = estimate(measured.D);
  measured.response.width_exponent = estimate(growth_exponent(widths));
}

/// Of the three-leg model: how much of the slowing follows from the mean of p alone.
void measure_middle(const BlockSums& sums, std::size_t row, ModelResponse& response, const Replicated& slowing) {
  if (!sums.quantities.contains("middle")) {
    response.middle.reason = response.c_of_middle.reason = response.traction.reason = response.share_of_mean.reason =
        "the model has no middle leg";
    return;
  }
  const Replicated middle = block_mean(sums, "middle", row);
  const Replicated c = transform([](double p) { return tan30 * std::sqrt(1 - p); }, middle);
  response.middle = estimate(middle);
  response.traction = estimate(block_mean(sums, "traction", row));
  response.c_of_middle = estimate(c);
  if (slowing.without_block.empty()) {
    response.share_of_mean.reason = "c is unknown";
  } else {
    response.share_of_mean =
        estimate(transform([](double of_mean, double all) { return (tan30 - of_mean) / all; }, c, slowing));
  }
}

/// Two Gaussians have two maxima where x_p > W.
int peaks_of(ResponseShape shape, const FittedResponseShape& fit) {
  const double least = shape == ResponseShape::two_gaussians ? fit.width : 0;
  return fit.position > least ? 2 : 1;
}

}  // namespace

std::string class_of_model(ResponseShape shape, const Estimate& width_exponent) {
  constexpr double between = 1.5, sure = 3;  // diffusion has the power 1, elasticity 2
  if (!width_exponent.known()) return "not decided: the growth of the width is unknown";
  const double p = width_exponent.value, error = sure * width_exponent.standard_error;
  const bool elastic = shape == ResponseShape::isotropic || shape == ResponseShape::orthotropic;
  const bool spreads = p + error<between, grows_with_depth = p - error> between;
  if (!spreads && !grows_with_depth) return "not decided: the power of the width is too uncertain";
  if (elastic && grows_with_depth) return "elastic";
  if (shape == ResponseShape::two_gaussians && spreads) return "hyperbolic with noise";
  if (shape == ResponseShape::one_gaussian && spreads) return "diffusive";
  return "none of these: the shape of one class and the growth of another";
}

MeasuredModel measure_model(const MeasuredEnsemble& ensemble, const FitSpec& fit, std::string series,
                            std::string parameter, int threads) {
  const BlockSums& sums = ensemble.record.sums;
  const ModelSpec& model = ensemble.spec.sampler.model;
  MeasuredModel measured;
  ModelResponse& response = measured.response;
  response.series = std::move(series);
  response.parameter = std::move(parameter);
  response.sampler = ensemble.spec.sampler;
  response.model = name_of(model.name);
  response.bead_weight = ensemble.spec.sampler.bead_weight;
  response.samples = sums.samples();
  response.speed_without_disorder = speed_without_disorder(model);
  response.layers = {fit.first_layer, fit.last_layer};
  response.z = {sums.rows.depth(fit.first_layer), sums.rows.depth(fit.last_layer)};
  const MeasuredTransport transport = measure_transport(ensemble, fit, {fit.last_layer}, threads);
  const Transport& t = transport.transport;
  response.c = t.c;
  response.D = t.D;
  response.c_thrust = t.c_thrust;
  response.width_exponent = t.exponents.width;
  if (!t.profiles.empty()) response.profile = t.profiles.back();
  if (t.c.known()) {
    measured.D = transport.D;
    measured.slowing = transform([&](double c) { return response.speed_without_disorder - c; }, transport.c);
    response.slowing = estimate(measured.slowing);
  } else {
    response.slowing.reason = t.c.reason;
  }
  if (model.is_beads()) response.stress = stress_with_depth(ensemble);

  std::array<int, all_response_shapes.size()> best{};
  std::size_t deepest = 0;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    if (!in_window(fit, sums.layers[row])) continue;
    const LayerSpectrum spectrum = layer_spectrum(sums, row, ensemble.spec.response.overload);
    response.fits = fit_response_shapes(spectrum, sums.rows.depth(sums.layers[row]));
    ++best[static_cast<std::size_t>(best_shape(response.fits))];
    deepest = row;
  }
  response.shape = all_response_shapes[static_cast<std::size_t>(std::ranges::max_element(best) - best.begin())];
  response.width = response.fits[static_cast<std::size_t>(ResponseShape::two_gaussians)].width;
  set_expected(model, response);
  if (response.theory) compare_with_theory(transport, response);
  response.peaks = peaks_of(response.shape, response.fits[static_cast<std::size_t>(response.shape)]);
  if (!t.c.known() && response.shape == ResponseShape::one_gaussian) measure_one_peak(ensemble, fit, measured);
  response.verdict = class_of_model(response.shape, response.width_exponent);
  measure_middle(sums, deepest, response, measured.slowing);
  return measured;
}

TractionDepth measure_traction(const MeasuredEnsemble& ensemble) {
  const BlockSums& sums = ensemble.record.sums;
  const ThreeLegSpec& legs = ensemble.spec.sampler.model.three_leg;
  TractionDepth depth;
  depth.middle = legs.middle;
  depth.noise = legs.noise;
  depth.samples = sums.samples();
  std::vector<Replicated> shares;
  std::vector<double> z;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    shares.push_back(block_mean(sums, "traction", row));
    z.push_back(sums.rows.depth(sums.layers[row]));
  }
  depth.columns = ensemble.spec.lattice.columns;
  const Replicated appears = transform_all(shares, [&](const std::vector<double>& share) {
    double beads = 0;
    for (std::size_t row = 0; row < share.size(); ++row) {
      const double more = share[row] * depth.columns;
      // Straight within the row that makes it one bead.
      if (beads + more >= 1) return z[row] - (row == 0 ? 0 : (z[row] - z[row - 1]) * (beads + more - 1) / more);
      beads += more;
    }
    return std::nan("");
  });
  depth.z = estimate(appears, fmt::format("none does down to z = {:.0f}", z.back()));
  return depth;
}

ScalingFit slowing_against_spreading(const std::vector<const MeasuredModel*>& series) {
  std::vector<Replicated> log_D, log_slowing;
  for (const MeasuredModel* one : series) {
    if (one->slowing.without_block.empty()) continue;
    const auto logarithm = [](double value) { return std::log(value); };
    const Replicated D = transform(logarithm, one->D), slowing = transform(logarithm, one->slowing);
    if (!estimate(D).known() || !estimate(slowing).known()) continue;
    log_D.push_back(D);
    log_slowing.push_back(slowing);
  }
  ScalingFit fit = fit_power_law(log_D, log_slowing, {});
  if (log_D.size() < min_power_law_points) {
    fit.exponent.reason = "an exponent needs three parameters with known c and D";
  }
  return fit;
}

namespace {

NoiseTheory theory_of(const StochasticOslSpec& spec, double spacing) {
  NoiseTheory theory;
  theory.c0 = tan30;
  theory.disorder = spec.disorder;
  // g_x falls by 1/width over the width of a cell, g_z(u/c0) = 1 - u/reach.
  const double width = spec.cell_columns, reach = theory.c0 * spec.cell_rows * spacing, u = std::min(width, reach);
  theory.cell = width;
  theory.wide.kappa = (u - u * u / (2 * reach)) / width;
  theory.wide.spreading = theory.c0 * (u * u / 2 - u * u * u / (3 * reach)) / width;
  const double both = u - u * u / 2 * (1 / reach + 1 / width) + u * u * u / (3 * reach * width);
  theory.narrow = {theory.wide.kappa / 2 + 0.25, theory.c0 / 2 * both};
  return theory;
}

/// The share that the middle leg of one bead carries beyond p enters the rows below as b = (F_t, push) = (1, 0) below
/// it and (-1/2, -+1/2) on either side. What of this comes back as weight m rows on meets noise that is still the same
/// with g_x g_z: for slow fields both noises together are a change of p by Delta_p^2 sum_m q_m, q_m = g_z(m) sum_x
/// g_x(x) h_m(x), at a delay of m rows, by which a peak that moves is spread.
NoiseTheory theory_of(const ThreeLegSpec& spec, double spacing) {
  const double p = spec.middle;
  NoiseTheory theory;
  theory.c0 = tan30 * std::sqrt(1 - p);
  theory.D0 = p / (2 * spacing);
  theory.disorder = spec.noise / std::sqrt(3.0) / (1 - p);
  theory.cell = spec.cell_columns;
  const int rows = spec.cell_rows, middle = rows + 1;
  std::vector<double> weight(2 * static_cast<std::size_t>(middle) + 1), push(weight.size());
  const auto at = [middle](std::vector<double>& row, int x) -> double& {
    const int place = middle + x;
    return row[static_cast<std::size_t>(place)];
  };
  at(weight, 0) = 1;
  at(weight, 1) = at(weight, -1) = at(push, 1) = -0.5;
  at(push, -1) = 0.5;
  double shift = 0, delayed = 0;  // of p, over Delta_p^2
  for (int m = 1; m < rows; ++m) {
    double q = 0;
    for (int x = -std::min(middle, spec.cell_columns); x <= std::min(middle, spec.cell_columns); ++x) {
      q += (1 - static_cast<double>(m) / rows) * (1 - std::abs(x) / static_cast<double>(spec.cell_columns)) *
           at(weight, x);
    }
    shift += q;
    delayed += (m + 0.5) * q;
    std::vector<double> weight_below(weight.size()), push_below(weight.size());
    for (int x = -m; x <= m; ++x) {
      const double right = ((1 - p) * at(weight, x) + at(push, x)) / 2;
      const double left = ((1 - p) * at(weight, x) - at(push, x)) / 2;
      at(weight_below, x) += p * at(weight, x);
      at(weight_below, x + 1) += right, at(push_below, x + 1) += right;
      at(weight_below, x - 1) += left, at(push_below, x - 1) -= left;
    }
    weight = weight_below;
    push = push_below;
  }
  theory.wide = {shift * (1 - p), delayed * (1 - p) * (1 - p) / spacing};
  return theory;
}

}  // namespace

double NoiseTheory::c(double width) const { return c0 * std::sqrt(1 - shift(width).kappa * disorder * disorder); }

NoiseTheory noise_theory(const ModelSpec& model) {
  const double spacing = rows_of(model).spacing;
  if (model.name == ModelName::stochastic_osl) return theory_of(model.stochastic_osl, spacing);
  if (model.name == ModelName::three_leg && model.three_leg.law == MiddleLaw::free) {
    return theory_of(model.three_leg, spacing);
  }
  throw std::logic_error("a model without a theory of its noise was asked for it");
}

}  // namespace granuscope
