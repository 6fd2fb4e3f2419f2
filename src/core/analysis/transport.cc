#include "analysis/transport.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "analysis/scaling.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/ensemble_spec.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

constexpr std::size_t min_depths = least_window_depths;
constexpr std::size_t min_depths_of_a_law = 4;  ///< fewest from which a curvature is

bool all_exact(const std::vector<MeasuredDepth>& depths) {
  return std::ranges::all_of(
      depths, [](const MeasuredDepth& d) { return d.fit.degrees_of_freedom == 0 && d.fit.identifiable; });
}

/// Everything that follows from slopes.
void set_unknown(Transport& t, const std::string& reason) {
  for (Estimate* e : {&t.c, &t.D, &t.position_offset, &t.width_offset, &t.c_minus_c_thrust, &t.exponents.position,
                      &t.exponents.width, &t.exponents.amplitude, &t.exponents.noise, &t.fitted_area,
                      &t.centre_background, &t.c_beside, &t.D_beside, &t.peak_separation}) {
    e->reason = reason;
  }
  t.position_line.reason = t.width_line.reason = reason;
}

constexpr double least_reach = 1.5;  ///< ratio of deepest to shallowest z from which a power of z is taken

/// The powers of depth and of the number of piles over the depths that the slopes are taken from.
void fit_exponents(const std::vector<const MeasuredDepth*>& used, const DepthSeries& peaks, const DepthSeries& widths,
                   MeasuredTransport& result) {
  Transport& t = result.transport;
  const auto all = {&t.exponents.position, &t.exponents.width, &t.exponents.amplitude, &t.exponents.noise};
  std::string reason;
  if (std::ranges::any_of(used, [](const MeasuredDepth* d) { return !d->inside; })) {
    reason = "an exact profile has no scatter to test an exponent with";
  } else if (used.size() < min_depths_of_a_law || peaks.z.back() < least_reach * peaks.z.front()) {
    reason =
        fmt::format("{} from z = {:.1f} to {:.1f} can be fitted; a power of z needs {} over a factor of {}",
                    how_many(used.size(), "depth"), peaks.z.front(), peaks.z.back(), min_depths_of_a_law, least_reach);
  }
  if (!reason.empty()) {
    for (Estimate* exponent : all) exponent->reason = reason;
    t.position_line.reason = t.width_line.reason = reason;
    return;
  }
  DepthSeries spreads{peaks.z, {}};  // 1/h^2, in proportion to W^2
  ResidualNoise noise;
  for (const MeasuredDepth* depth : used) {
    spreads.y.push_back(transform([](double height) { return 1 / (height * height); }, depth->inside->height));
    add(noise, depth->inside->noise);
  }
  const Replicated amplitude = transform([](double power) { return -power / 2; }, growth_exponent(spreads));
  result.exponents = {growth_exponent(peaks), growth_exponent(widths), amplitude, noise_exponent(noise)};
  t.exponents = {estimate(result.exponents.position), estimate(result.exponents.width),
                 estimate(result.exponents.amplitude), estimate(result.exponents.noise)};
  t.position_line = test_line(peaks);
  t.width_line = test_line(widths);
  t.height_line = test_line(spreads);
}

/// Mean over the window, unknown where one of its depths is.
Estimate mean_over(const std::vector<const MeasuredDepth*>& used, Replicated ShapeDiagnostics::*number) {
  std::vector<Replicated> all;
  for (const MeasuredDepth* depth : used) {
    if (!depth->inside) return {.reason = "an exact profile is not fitted"};
    all.push_back(depth->inside->diagnostics.*number);
  }
  return estimate(mean_of(all), no_extended_fit);
}

/// The slopes of c and D with a background beside the two Gaussians at every depth.
void measure_beside_background(const std::vector<const MeasuredDepth*>& used, const WindowEdge& edge, Transport& t) {
  DepthSeries peaks, widths;
  for (const MeasuredDepth* depth : used) {
    if (!depth->inside) {
      t.c_beside.reason = t.D_beside.reason = "an exact profile is not fitted";
      return;
    }
    peaks.z.push_back(depth->fit.z);
    peaks.y.push_back(depth->inside->diagnostics.peak);
    widths.y.push_back(depth->inside->diagnostics.width_squared);
  }
  widths.z = peaks.z;
  t.c_beside = estimate(line_through(peaks, edge).slope, no_extended_fit);
  t.D_beside = estimate(line_through(widths, edge).slope, no_extended_fit);
  t.chi2_per_dof = t.chi2_beside_per_dof = 0;
  for (const MeasuredDepth* depth : used) {
    const auto depths = static_cast<double>(used.size());
    t.chi2_per_dof += depth->fit.chi2_per_dof / depths;
    t.chi2_beside_per_dof += depth->inside->diagnostics.chi2_beside / (depth->fit.degrees_of_freedom - 1) / depths;
  }
}

/// The deepest run of identifiable depths, in the window and above it.
std::vector<const MeasuredDepth*> identifiable_run(const std::vector<MeasuredDepth>& depths, const FitSpec& spec) {
  std::vector<const MeasuredDepth*> at_steps, run;
  std::vector<DepthUse> uses;
  for (const MeasuredDepth& depth : depths) {
    if (!at_step(spec, depth.fit.layer)) continue;
    at_steps.push_back(&depth);
    uses.push_back(depth.fit.identifiable ? DepthUse::fitted
                   : depth.other_shape    ? DepthUse::other_shape
                                          : DepthUse::unidentified);
  }
  for (const std::size_t i : identifiable_depths(uses)) run.push_back(at_steps[i]);
  return run;
}

void measure_variations(const FittedRun& run, MeasuredTransport& result) {
  Transport& t = result.transport;
  if (!(t.c.standard_error > 0)) return;  // an exact line is the same in every window
  result.variations = measure_variations(run, result.c, result.D);
  std::vector<Estimate> c_shifts, D_shifts;
  for (const VariationSlopes& variation : result.variations) {
    t.variations.push_back(variation.shown);
    c_shifts.push_back(variation.shown.c_shift);
    D_shifts.push_back(variation.shown.D_shift);
  }
  t.c.systematic = systematic_spread(c_shifts);
  t.D.systematic = systematic_spread(D_shifts);
}

/// That run, with its edge unless it is exact; `used`: its depths in the window.
FittedRun fitted_run(const std::vector<MeasuredDepth>& depths, const FitSpec& spec, const RowGeometry& rows, bool exact,
                     std::vector<const MeasuredDepth*>& used) {
  FittedRun run;
  for (const MeasuredDepth* depth : identifiable_run(depths, spec)) {
    run.layers.push_back(depth->fit.layer);
    run.peaks.z.push_back(depth->fit.z);
    run.peaks.y.push_back(depth->peak);
    run.widths.y.push_back(depth->width_squared);
    run.peaks_by_equal.y.push_back(depth->peak_by_equal);
    run.widths_by_equal.y.push_back(depth->width_squared_by_equal);
    if (in_window(spec, depth->fit.layer)) used.push_back(depth);
  }
  run.widths.z = run.peaks_by_equal.z = run.widths_by_equal.z = run.peaks.z;
  run.window_start = run.layers.size() - used.size();
  if (!exact && used.size() >= min_depths) {
    const double reach = rows.depth(spec.layer_step) - rows.depth(0);
    run.edge = edge_of(run, spec.min_identifiable_width * rows.pitch, reach);
  }
  return run;
}

void fit_slopes(const std::vector<MeasuredDepth>& depths, const FitSpec& spec, MeasuredTransport& result) {
  Transport& t = result.transport;
  std::vector<const MeasuredDepth*> used;
  const FittedRun run = fitted_run(depths, spec, t.rows(), t.exact, used);
  t.depths_in_window = static_cast<int>(used.size());
  if (used.size() < min_depths) {
    const std::string how_many = used.empty() ? "none" : used.size() == 1 ? "one" : "two";
    static_assert(min_depths == 3);
    const auto deepest_refused = std::find_if(depths.rbegin(), depths.rend(), [&](const MeasuredDepth& depth) {
      return in_window(spec, depth.fit.layer) && !depth.fit.identifiable;
    });
    const std::string why =
        deepest_refused == depths.rend()
            ? ""
            : fmt::format("at layer {} {}; ", deepest_refused->fit.layer, deepest_refused->fit.reason);
    const std::string reason =
        fmt::format("{}a slope needs {} depths from the end of the window, layers {} to {}, upwards, and has {}", why,
                    min_depths, spec.first_layer, spec.last_layer, how_many);
    set_unknown(t, reason);
    t.window_layers = {spec.first_layer, spec.last_layer};
    return;
  }
  const FittedRun window = part_of(run, run.window_start, run.layers.size());
  const TransportLines lines = transport_lines(window);
  t.window_layers = {window.layers.front(), window.layers.back()};
  t.c = estimate(lines.position.slope);
  t.position_offset = estimate(lines.position.intercept);
  t.D = estimate(lines.width.slope);
  t.width_offset = estimate(lines.width.intercept);
  result.c = lines.position.slope;
  result.D = lines.width.slope;
  result.position_offset = lines.position.intercept;
  measure_variations(run, result);
  t.fitted_area = mean_over(used, &ShapeDiagnostics::area);
  t.centre_background = mean_over(used, &ShapeDiagnostics::background);
  measure_beside_background(used, run.edge, t);
  for (const MeasuredDepth* depth : used) t.largest_misfit = std::max(t.largest_misfit, depth->fit.misfit_at_least);
  fit_exponents(used, window.peaks, window.widths, result);
}

void measure_thrust(const std::vector<MeasuredDepth>& depths, const FitSpec& spec, MeasuredTransport& result) {
  std::vector<Replicated> ratios;
  for (const MeasuredDepth& depth : depths) {
    if (in_window(spec, depth.fit.layer)) ratios.push_back(depth.thrust);
  }
  Transport& t = result.transport;
  if (ratios.empty()) {
    t.alpha_thrust.reason = t.c_thrust.reason = "no layer of the window is recorded";
    return;
  }
  const Replicated alpha = mean_of(ratios);
  const Replicated c_thrust = transform([&](double kappa) { return speed_from_thrust(kappa, t.c0()); }, alpha);
  t.alpha_thrust = estimate(alpha);
  t.c_thrust = estimate(c_thrust, "the mean thrust ratio is negative");
  if (t.c.known()) {
    t.c_minus_c_thrust = estimate(transform([](double c, double thrust) { return c - thrust; }, result.c, c_thrust));
  }
}

/// Over all depths of the window where a shape was fitted, whether its width can be told from a bead's or not.
void measure_separation(const std::vector<MeasuredDepth>& depths, const FitSpec& spec, Transport& t) {
  std::vector<Replicated> peaks, widths;
  for (const MeasuredDepth& depth : depths) {
    if (!in_window(spec, depth.fit.layer) || !at_step(spec, depth.fit.layer) || !depth.fit.peak_position.known())
      continue;
    peaks.push_back(depth.peak);
    widths.push_back(depth.width);
  }
  if (t.exact || peaks.empty()) {
    t.peak_separation.reason = t.exact ? "an exact profile has no scatter" : "no depth of the window could be fitted";
    return;
  }
  const auto ratio = [](double peak, double width) { return peak / width; };
  t.peak_separation = estimate(transform(ratio, mean_of(peaks), mean_of(widths)));
}

/// Where the second piles of the estimator paired follow another law than the first ones, no depth can be trusted.
std::string refuse_pairs(const MeasuredEnsemble& ensemble, const FitSpec& spec, std::vector<MeasuredDepth>& depths) {
  const BlockSums& sums = ensemble.record.sums;
  std::vector<Replicated> thrust, of_response;
  for (std::size_t row = 0; row < depths.size(); ++row) {
    if (!in_window(spec, depths[row].fit.layer)) continue;
    thrust.push_back(depths[row].thrust);
    of_response.push_back(block_mean(sums, "response_thrust", row));
  }
  if (thrust.empty()) return {};
  std::string reason = reason_against_pairs(mean_of(of_response), mean_of(thrust));
  for (MeasuredDepth& depth : depths) {
    if (reason.empty() || !depth.fit.identifiable) continue;
    depth.fit.identifiable = false;
    depth.fit.reason = reason;
  }
  // Of another law, whatever its shape.
  if (!reason.empty()) {
    for (MeasuredDepth& depth : depths) depth.fit.misfit_at_least = 0;
  }
  return reason;
}

ResponseProfile response_profile(const MeasuredEnsemble& ensemble, std::size_t row, const MeasuredDepth& depth) {
  const BlockMeans means = mean_response(ensemble.record.sums, row, ensemble.spec.response.overload);
  const int layer = depth.fit.layer, columns = static_cast<int>(means.whole.size());
  const Lattice lattice({columns, 2});
  const int kind_of_row = ensemble.record.sums.rows.shifted(layer) ? 1 : 0;
  const double pitch = ensemble.record.sums.rows.pitch;
  ResponseProfile profile;
  profile.layer = layer;
  profile.z = depth.fit.z;
  profile.c0 = ensemble.record.sums.rows.ray();
  std::vector<int> order(means.whole.size());
  for (int i = 0; i < columns; ++i) order[static_cast<std::size_t>(i)] = i;
  std::ranges::sort(order, [&](int a, int b) { return lattice.x(kind_of_row, a) < lattice.x(kind_of_row, b); });
  // Bead at -x, on the ring: x = i - middle + shift, so the mirror image of i is 2 middle - i - twice the shift.
  const auto mirror = [&](int i) {
    const int image = 2 * lattice.middle() - i - kind_of_row;
    return static_cast<std::size_t>((image % columns + columns) % columns);
  };
  for (int i : order) {
    const auto here = static_cast<std::size_t>(i);
    const auto symmetrised = [&](const std::vector<double>& response) {
      return (response[here] + response[mirror(i)]) / 2;
    };
    Replicated pressure{symmetrised(means.whole), {}};
    for (const auto& without : means.without_block) pressure.without_block.push_back(symmetrised(without));
    profile.x.push_back(lattice.x(kind_of_row, i));
    profile.pressure.push_back(pressure.value);
    profile.standard_error.push_back(estimate(pressure).standard_error);
  }
  if (depth.fit.peak_position.known() && depth.fit.width.value > 0) {
    profile.fit = evaluate({depth.fit.peak_position.value / pitch, depth.fit.width.value / pitch}, profile.x, columns);
  }
  for (double& x : profile.x) x *= pitch;
  for (auto* densities : {&profile.pressure, &profile.standard_error, &profile.fit}) {
    for (double& density : *densities) density /= pitch;
  }
  return profile;
}

}  // namespace

std::vector<int> layers_to_record(const FitSpec& spec, const std::vector<int>& extra) {
  std::vector<int> layers = extra;
  for (int layer = spec.last_layer; layer >= std::min(spec.first_layer, spec.shallow_layer); layer -= spec.layer_step) {
    layers.push_back(layer);
  }
  std::ranges::sort(layers);
  layers.erase(std::unique(layers.begin(), layers.end()), layers.end());
  return layers;
}

MeasuredTransport measure_transport(const MeasuredEnsemble& ensemble, const FitSpec& spec,
                                    const std::vector<int>& profile_layers, int threads) {
  const EnsembleRecord& record = ensemble.record;
  MeasuredTransport result;
  Transport& t = result.transport;
  t.spec = ensemble.spec;
  t.failed = record.failed;
  for (std::uint64_t count : record.sums.count) t.samples += count;
  const auto per_bead = [&](std::uint64_t count) {
    return record.counts.beads > 0 ? static_cast<double>(count) / static_cast<double>(record.counts.beads)
                                   : std::numeric_limits<double>::quiet_NaN();
  };
  t.draws_per_bead = per_bead(record.counts.uniforms);
  t.repaired_per_bead =
      per_bead(record.counts.repaired_by_pair + record.counts.repaired_by_arc + record.counts.repaired_by_ring);
  t.backtracked_per_bead = per_bead(record.counts.backtracked);
  t.rounded_per_bead = per_bead(record.counts.rounded);
  if (const std::uint64_t chains = record.counts.chains; chains > 0) {
    t.chained = true;
    t.effective_samples = effective_samples(record.sums);
    t.flat = test_flat_law(record.sums);
    t.burn_in = static_cast<double>(record.counts.burn_in) / static_cast<double>(chains);
    t.thinning = static_cast<double>(record.counts.thinning) / static_cast<double>(chains);
  }

  // A block all of whose piles failed leaves nothing to average.
  if (std::ranges::find(record.sums.count, 0) != record.sums.count.end()) {
    const std::string reason = "a block of the ensemble holds no completed pile";
    set_unknown(t, reason);
    t.alpha_thrust.reason = t.c_thrust.reason = reason;
    return result;
  }

  const std::size_t first_row = first_response(record.sums);
  std::vector<MeasuredDepth> depths(record.sums.layers.size() - first_row);
  for_each_index(depths.size(), threads,
                 [&](std::size_t i) { depths[i] = measure_depth(ensemble, spec, i + first_row); });
  t.exact = all_exact(depths);
  const std::string against_pairs =
      ensemble.spec.response.estimator == EstimatorName::paired ? refuse_pairs(ensemble, spec, depths) : "";
  fit_slopes(depths, spec, result);
  if (!against_pairs.empty()) set_unknown(t, against_pairs);
  if (against_pairs.empty()) measure_separation(depths, spec, t);
  measure_thrust(depths, spec, result);
  for (std::size_t i = 0; i < depths.size(); ++i) {
    t.depths.push_back(depths[i].fit);
    if (std::ranges::find(profile_layers, depths[i].fit.layer) != profile_layers.end()) {
      t.profiles.push_back(response_profile(ensemble, i + first_row, depths[i]));
    }
  }
  return result;
}

Slopes measure_slopes(const MeasuredEnsemble& ensemble, const FitSpec& spec) {
  const BlockSums& sums = ensemble.record.sums;
  std::vector<MeasuredDepth> depths;
  for (std::size_t row = first_response(sums); row < sums.layers.size(); ++row) {
    if (in_window(spec, sums.layers[row])) depths.push_back(measure_depth_values(ensemble, spec, row));
  }
  std::vector<const MeasuredDepth*> used;
  const FittedRun run = fitted_run(depths, spec, sums.rows, all_exact(depths), used);
  if (used.size() < min_depths) return {std::nan(""), std::nan("")};
  const TransportLines lines = transport_lines(run);
  return {lines.position.slope.value, lines.width.slope.value};
}

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
