#include "studies/deep_response.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "analysis/expected_response.h"
#include "analysis/layer_spectrum.h"
#include "analysis/measured_depth.h"
#include "ensemble/estimator.h"
#include "ensemble/fluctuation_plan.h"
#include "ensemble/parallel.h"
#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/csv_table.h"
#include "plot/figure_captions.h"
#include "plot/plot_script.h"
#include "plot/series_style.h"
#include "report/estimate_json.h"
#include "studies/common_checks.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

constexpr int least_octaves = 3, most_octaves = 11;
/// Longer than the reference lag: modes that only shorter ones have are drowned in noise.
constexpr int first_lag = 32;
constexpr double least_width = 0.3;  ///< bead diameters
constexpr const char* figure_id = "deep-response";

int last_lag(int octaves) { return first_lag << octaves; }

}  // namespace

DeepResponse measure_deep_response(const MeasuredEnsemble& ensemble, int threads) {
  const BlockSums& sums = ensemble.record.sums;
  DeepResponse response;
  response.spec = ensemble.spec;
  response.samples = std::accumulate(sums.count.begin(), sums.count.end(), std::uint64_t{0});
  FitSpec fit;
  fit.min_identifiable_width = least_width;
  std::vector<MeasuredDepth> depths(sums.layers.size() - 1);
  for_each_index(depths.size(), threads, [&](std::size_t i) { depths[i] = measure_depth(ensemble, fit, i + 1); });
  // Another shape than two Gaussians is told by the misfit, and no reason to be silent.
  const auto reason = [](const MeasuredDepth& depth) { return depth.other_shape ? std::string() : depth.fit.reason; };
  for (const MeasuredDepth& depth : depths) {
    response.lags.push_back({depth.fit.layer, depth.fit.z - Lattice::depth(0), estimate(depth.peak, reason(depth)),
                             estimate(depth.width_squared, reason(depth)), depth.fit.chi2_per_dof, depth.fit.misfit});
  }
  for (std::size_t i = 0; i + 1 < depths.size(); ++i) {
    const MeasuredDepth &above = depths[i], &below = depths[i + 1];
    const double from = response.lags[i].z, to = response.lags[i + 1].z;
    OctaveOfDepth octave{from, to, {}, {}, {}, std::max(above.fit.misfit, below.fit.misfit)};
    const std::string against = !reason(above).empty() ? reason(above) : reason(below);
    const auto slope = [&](double a, double b) { return (b - a) / (to - from); };
    const auto power = [&](double a, double b) { return std::log(b / a) / std::log(to / from); };
    if (against.empty()) {
      octave.exponent = estimate(transform(power, above.width_squared, below.width_squared));
      octave.c = estimate(transform(slope, above.peak, below.peak));
      octave.D = estimate(transform(slope, above.width_squared, below.width_squared));
    } else {
      for (Estimate* unknown : {&octave.exponent, &octave.c, &octave.D}) unknown->reason = against;
    }
    response.octaves.push_back(octave);
  }
  response.c_thrust = estimate(thrust_speed(sums, 0), "a block of the ensemble holds no completed pile");
  return response;
}

Figure plot_deep_response(const std::vector<DeepResponse>& measured, const std::filesystem::path& run_folder) {
  PlotPlan plan;
  plan.id = figure_id;
  plan.script = "studies/deep_response";
  plan.height = 3;
  std::vector<std::string> curves, titles;
  Range depth, exponents;
  exponents.add(1);
  for (const DeepResponse& one : measured) {
    CsvTable table({"z", "exponent", "standard_error", "z_from", "z_to", "c", "c_error", "D", "D_error"});
    for (const OctaveOfDepth& octave : one.octaves) {
      if (!octave.exponent.known()) continue;
      const double z = std::sqrt(octave.from * octave.to), p = octave.exponent.value;
      table.add_row({z, p, octave.exponent.standard_error, octave.from, octave.to, octave.c.value,
                     octave.c.standard_error, octave.D.value, octave.D.standard_error});
      depth.add(z);
      exponents.add(p - octave.exponent.standard_error);
      exponents.add(p + octave.exponent.standard_error);
    }
    if (table.empty()) continue;
    const std::string mu = exact(one.spec.sampler.mu), file = fmt::format("{}-mu-{}.csv", figure_id, mu);
    plan.data[file] = table.text();
    const std::string style = series_style(curves.size() / 2);
    const std::string colour = style.substr(style.find("linecolor"));
    curves.push_back(fmt::format("'{}' using 1:2 with lines linewidth 0.8 {} notitle", file, colour));
    curves.push_back(
        fmt::format("'{}' using 1:2:3 with yerrorbars linewidth 0.9 pointsize 0.55 {} notitle", file, style));
    titles.push_back(fmt::format("keyentry with linespoints linewidth 0.9 pointsize 0.55 {} title {}", style,
                                 gnuplot_string("μ = " + caption_number(one.spec.sampler.mu))));
  }
  if (curves.empty()) {
    throw InputError(
        "the figure of the response with depth has nothing to show, because no two lags were fitted; give "
        "studies.deep_response.mu where peaks stand apart, or more piles");
  }
  plan.curves = static_cast<int>(curves.size()) + 1;  // and the line at 1
  const Range axis = widened_by_factor(depth, 1.4);
  const double room = 0.06 * exponents.size();
  Figure figure = plot_figure(plan,
                              {{"curves", fmt::format("{}", fmt::join(curves, ", \\\n    "))},
                               {"titles", fmt::format("{}", fmt::join(titles, ", \\\n    "))},
                               {"left", exact(axis.low)},
                               {"right", exact(axis.high)},
                               {"depth_ticks", log_ticks(axis)},
                               {"low", exact(exponents.low - room)},
                               {"high", exact(exponents.high + room)},
                               {"ticks", linear_ticks(exponents, 6)}},
                              run_folder);
  const DeepResponse& first = measured.front();
  set_captions(figure, "studies/deep_response.captions",
               {{"columns", std::to_string(first.spec.lattice.columns)},
                {"piles", std::to_string(first.samples)},
                {"deepest", caption_number(std::round(first.octaves.back().to))},
                {"reference", std::to_string(fluctuation_plan(first.spec).reference)}});
  return figure;
}

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const LagResponse& lag) {
  return {{"lag", lag.lag},
          {"z", lag.z},
          {"peak_position", granuscope::to_json(lag.peak_position)},
          {"width_squared", granuscope::to_json(lag.width_squared)},
          {"chi2_per_dof", finite_or_null(lag.chi2_per_dof)},
          {"misfit", finite_or_null(lag.misfit)}};
}

Json to_json(const OctaveOfDepth& octave) {
  return {{"z", {octave.from, octave.to}},
          {"exponent", granuscope::to_json(octave.exponent)},
          {"c", granuscope::to_json(octave.c)},
          {"D", granuscope::to_json(octave.D)},
          {"misfit", finite_or_null(octave.misfit)}};
}

Json to_json(const DeepResponse& one) {
  const FluctuationPlan plan = fluctuation_plan(one.spec);
  return {{"mu", one.spec.sampler.mu},
          {"law", name_of(one.spec.sampler.law)},
          {"columns", one.spec.lattice.columns},
          {"layers", one.spec.lattice.layers},
          {"samples", one.samples},
          {"reference_lag", plan.reference},
          {"base_layers", {plan.bases.front(), plan.bases.back()}},
          {"bases", plan.bases.size()},
          {"lags", list_of(one.lags, to_json)},
          {"octaves", list_of(one.octaves, to_json)},
          {"c_thrust", granuscope::to_json(one.c_thrust)}};
}

class DeepResponseStudy final : public CopiedStudy<DeepResponseStudy> {
 public:
  std::string id() const override { return "deep_response"; }

  std::vector<Key> keys() override {
    return {
        make_key(table(), "mu", "",
                 "friction coefficients at which the response of deep piles is followed by their fluctuations; "
                 "none: not at all",
                 mu_, friction_range_above_zero()),
        make_key(table(), "octaves", "octaves",
                 "doublings of the depth, from 32 layers on; 5 reach 1024 layers, z = 887", octaves_,
                 KeyRange{}.within(least_octaves, most_octaves)),
        make_key(table(), "columns", "beads",
                 "beads per layer of these piles, wide enough for two peaks at the deepest lag", columns_),
        make_key(table(), "samples", "piles", "piles per friction coefficient, at least eight per block", samples_)};
  }

  bool asked() const override { return !mu_.empty(); }

  Problem find_problem(const MainLine& main) const override {
    for (const double mu : mu_) {
      const double needed = columns_needed(mu, last_lag(octaves_));
      if (columns_ < needed) {
        return problem(key("columns"),
                       "{} columns: at mu = {} the two peaks meet behind the ring above {} layers of depth; give at "
                       "least {}, or fewer octaves",
                       columns_, mu, last_lag(octaves_), std::ceil(needed));
      }
      const EnsembleSpec spec = spec_at(main, mu);
      if (auto found = find_lattice_problem(key("columns"), columns_, key("octaves"), spec.lattice.layers,
                                            bottom_margin + 1, drawing_memory(spec))) {
        return found;
      }
    }
    return find_samples_problem(key("samples"), samples_, main.response.blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const double mu : mu_) {
      all.push_back({fmt::format("deep response, mu = {}", mu), fmt::format("deep-response-mu-{}", exact(mu)),
                     spec_at(main, mu)});
    }
    return all;
  }

  void begin(const MainLine&, int threads) override { threads_ = threads; }
  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override {
    measured_.push_back(measure_deep_response(ensemble, threads_));
  }

  Json json() const override { return list_of(measured_, to_json); }
  std::vector<ReportPart> parts(const Json&) const override { return {table_part()}; }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    if (measured_.empty()) return {};
    return {[this](const std::filesystem::path& folder) { return plot_deep_response(measured_, folder); }};
  }

 private:
  /// As many bases as the deepest lag has layers: half of each pile.
  EnsembleSpec spec_at(const MainLine& main, double mu) const {
    EnsembleSpec spec = main.ensemble_at(mu, {columns_, last_lag(octaves_)}, samples_);
    spec.response.estimator = EstimatorName::fluctuation;
    for (int octave = 0; octave <= octaves_; ++octave) spec.layers.push_back(last_lag(octave));
    spec.lattice.layers = fluctuation_plan(spec).layers_needed + last_lag(octaves_);
    return spec;
  }

  std::vector<double> mu_;  ///< each above 0; empty: not measured
  int octaves_ = 4;
  int columns_ = 720;
  std::uint64_t samples_ = 256;  ///< piles per friction coefficient
  int threads_ = 0;
  std::vector<DeepResponse> measured_;  ///< ascending in mu
};

}  // namespace

std::unique_ptr<Study> deep_response_study() { return std::make_unique<DeepResponseStudy>(); }

}  // namespace granuscope
