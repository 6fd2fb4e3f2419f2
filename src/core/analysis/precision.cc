#include "analysis/precision.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"

namespace granuscope {
std::uint64_t next_size(std::uint64_t rounds) { return rounds + (rounds + 1) / 2; }

std::uint64_t expected_size(std::uint64_t rounds, double rounds_needed, std::uint64_t most_rounds) {
  while (static_cast<double>(rounds) < rounds_needed && next_size(rounds) <= most_rounds) rounds = next_size(rounds);
  return rounds;
}

double stopped_scatter(int blocks) { return 1 + 1.2 / (blocks - 1); }

PrecisionLook look_at_precision(const PrecisionSpec& asked, const Transport& measured, std::uint64_t samples) {
  PrecisionLook look;
  double ratio = 0;
  const auto consider = [&](double target, const Estimate& number, const char* name, bool is_count = false) {
    if (target <= 0) return;
    if (!number.known()) {
      look.unattainable = true;
      if (look.reason.empty()) look.reason = std::string(name) + " is unknown: " + number.reason;
      return;
    }
    const double times = is_count ? std::sqrt(target / number.value) : number.standard_error / target;
    ratio = std::max(ratio, stopped_scatter(measured.spec.response.blocks) * times);
  };
  consider(asked.c, measured.c, "c");
  consider(asked.D, measured.D, "D");
  consider(asked.effective, measured.effective_samples, "the number of effective piles", true);
  look.reached = !look.unattainable && ratio <= 1;
  look.samples_needed =
      look.unattainable ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(samples) * ratio * ratio;
  return look;
}

double worth_of_sample(const EnsembleSpec& spec) {
  if (spec.response.opposite) return worth_of_opposite_pair;
  const bool measured = spec.sampler.law == Law::granusolve && spec.sampler.model.is_beads();
  const double variance =
      measured && moves_loads(spec) && spec.response.coupled ? std::clamp(2 * spec.sampler.mu, 0.2, 1.0) : 1;
  return overloads_of(spec) / variance;
}

ExpectedErrors expected_errors(double mu, bool multiplexed, double load, int columns, std::uint64_t samples) {
  constexpr double piles = 3461, wide = 500, worth_at_half = 90;
  double in_overloaded_piles = static_cast<double>(samples) * load * load;
  if (multiplexed) in_overloaded_piles *= worth_at_half * 4 * columns / wide;
  const double scale = std::sqrt(piles / in_overloaded_piles);
  return {(multiplexed ? 0.0045 : 0.011) * std::pow(mu, 1.7) * scale,
          (multiplexed ? 0.1 : 0.13) * std::pow(mu, 2.6) * scale};
}

namespace {

/// The blocks of one repetition, as an ensemble of its own.
EnsembleRecord repetition_of(const BlockSums& all, std::size_t repetition) {
  EnsembleRecord part;
  part.sums = take_blocks(all, repetition * repetition_blocks, repetition_blocks);
  return part;
}

std::vector<EnsembleRecord> paired_up(const std::vector<EnsembleRecord>& records) {
  std::vector<EnsembleRecord> sums;
  for (std::size_t r = 0; r + 1 < records.size(); r += 2) {
    sums.push_back(records[r]);
    merge_into(sums.back(), records[r + 1]);
  }
  return sums;
}

struct Values {
  std::vector<double> c, D;
  bool all_known() const {
    const auto known = [](double number) { return std::isfinite(number); };
    return std::ranges::all_of(c, known) && std::ranges::all_of(D, known);
  }
};

Values fit_all(const EnsembleSpec& spec, const FitSpec& fit, const std::vector<EnsembleRecord>& records, int threads) {
  Values values{std::vector<double>(records.size()), std::vector<double>(records.size())};
  for_each_index(records.size(), threads, [&](std::size_t r) {
    // The curves show how far off the estimator paired is.
    const Slopes slopes = measure_slopes({spec, records[r]}, fit);
    values.c[r] = slopes.c;
    values.D[r] = slopes.D;
  });
  return values;
}

/// Standard deviation over the repetitions.
double scatter_of(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / (n - 1));
}

/// The error of all samples together, if it falls from that of the smallest repetitions, which are most.
double error_of_all(const ErrorCurve& curve, double ErrorPoint::*scatter) {
  const ErrorPoint& p = curve.points.front();
  return p.*scatter * std::sqrt(static_cast<double>(p.samples) / static_cast<double>(curve.samples));
}

Estimate unknown(const char* reason) {
  Estimate none;
  none.reason = reason;
  return none;
}

Estimate difference(const Estimate& a, const Estimate& b) {
  if (!a.known() || !b.known()) return unknown("one of the two curves has no mean");
  return {a.value - b.value, std::hypot(a.standard_error, b.standard_error), {}};
}

/// Slope of ln scatter on ln samples. The scatter of n repetitions is known to 1/sqrt(2(n - 1)) of itself. Sizes share
/// their piles, which makes the slope better known than its error says.
Estimate slope_of_scatter(const std::vector<ErrorPoint>& points, double ErrorPoint::*scatter) {
  if (points.size() < 2) return unknown("fewer than two sizes were measured");
  double weights = 0, x_mean = 0, y_mean = 0;
  const auto weight = [](const ErrorPoint& p) { return 2.0 * (p.repetitions - 1); };
  for (const ErrorPoint& p : points) {
    weights += weight(p);
    x_mean += weight(p) * std::log(static_cast<double>(p.samples));
    y_mean += weight(p) * std::log(p.*scatter);
  }
  x_mean /= weights;
  y_mean /= weights;
  double xx = 0, xy = 0;
  for (const ErrorPoint& p : points) {
    const double x = std::log(static_cast<double>(p.samples)) - x_mean;
    xx += weight(p) * x * x;
    xy += weight(p) * x * (std::log(p.*scatter) - y_mean);
  }
  return {xy / xx, 1 / std::sqrt(xx), {}};
}

}  // namespace

FitSpec error_curve_fit(const LatticeSpec& lattice) {
  FitSpec fit;
  fit.last_layer = lattice.layers - bottom_margin - 1;
  fit.first_layer = fit.last_layer / 3;
  fit.shallow_layer = fit.first_layer;
  fit.layer_step = std::max(1, (fit.last_layer - fit.first_layer) / 28 * 2 + 1);
  // All estimators are to be compared over the same depths, also where the peaks are as narrow as a bead.
  fit.min_identifiable_width = 0.1;
  return fit;
}

ErrorCurve measure_error_curve(const MeasuredEnsemble& ensemble, const FitSpec& fit, int threads) {
  const auto& [spec, record] = ensemble;
  ErrorCurve curve;
  curve.spec = spec;
  curve.failed = record.failed.size();
  curve.samples = record.sums.samples();
  curve.beads = record.counts.beads;
  curve.c = curve.D = curve.slope_c = curve.slope_D = unknown("the repetitions have no fit of two peaks");
  curve.shift_c = curve.shift_D = unknown("there is no linear response to compare with");
  if (std::ranges::find(record.sums.count, 0) != record.sums.count.end()) return curve;

  std::vector<EnsembleRecord> records;
  const auto repetitions = static_cast<std::size_t>(record.sums.blocks() / repetition_blocks);
  if (repetitions == 0) return curve;
  const BlockSums all = in_memory(record.sums);
  for (std::size_t r = 0; r < repetitions; ++r) records.push_back(repetition_of(all, r));
  EnsembleRecord whole = records.front();
  for (std::size_t r = 1; r < records.size(); ++r) merge_into(whole, records[r]);
  std::uint64_t samples = curve.samples / repetitions;
  for (; records.size() >= std::size_t{least_repetitions}; records = paired_up(records), samples *= 2) {
    const Values values = fit_all(spec, fit, records, threads);
    // A repetition too small for a fit tells nothing about the error of those that have one.
    if (!values.all_known()) continue;
    curve.points.push_back({samples, static_cast<int>(records.size()), scatter_of(values.c), scatter_of(values.D)});
  }
  if (curve.points.empty()) return curve;
  const Values values = fit_all(spec, fit, {whole}, threads);
  curve.c = {values.c[0], error_of_all(curve, &ErrorPoint::scatter_c), {}};
  curve.D = {values.D[0], error_of_all(curve, &ErrorPoint::scatter_D), {}};
  if (!values.all_known()) curve.c = curve.D = unknown("the whole ensemble has no fit of two peaks");
  curve.slope_c = slope_of_scatter(curve.points, &ErrorPoint::scatter_c);
  curve.slope_D = slope_of_scatter(curve.points, &ErrorPoint::scatter_D);
  return curve;
}

void set_shifts(std::vector<ErrorCurve>& curves) {
  const ErrorCurve* linear = nullptr;
  for (const ErrorCurve& curve : curves) {
    const ResponseSpec& response = curve.spec.response;
    if (response.opposite && (linear == nullptr || response.epsilon < linear->spec.response.epsilon)) linear = &curve;
  }
  if (linear == nullptr) return;
  const Estimate c = linear->c, D = linear->D;
  for (ErrorCurve& curve : curves) {
    if (&curve == linear) {
      curve.shift_c = curve.shift_D = unknown("this curve is the linear response that the others are held against");
      continue;
    }
    curve.shift_c = difference(curve.c, c);
    curve.shift_D = difference(curve.D, D);
  }
}

}  // namespace granuscope
