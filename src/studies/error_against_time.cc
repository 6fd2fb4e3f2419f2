#include "studies/error_against_time.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/transport.h"
#include "ensemble/fluctuation_estimator.h"
#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/gnuplot.h"
#include "plot/plot.h"
#include "report/clean_json.h"
#include "studies/study.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {

namespace {

constexpr const char* figure_id = "error-against-time";
/// How far beyond the measured points the total error is plotted, so that floors show.
constexpr double outlook = 300;
constexpr double significant_shift = 3;  // standard errors

/// One panel: c or D.
struct TimedQuantity {
  const char* name;
  double ErrorPoint::*scatter;
  Estimate ErrorCurve::*mean;
  Estimate ErrorCurve::*shift;
  Estimate ErrorCurve::*slope;
};
constexpr TimedQuantity quantities[] = {
    {"c", &ErrorPoint::scatter_c, &ErrorCurve::c, &ErrorCurve::shift_c, &ErrorCurve::slope_c},
    {"D", &ErrorPoint::scatter_D, &ErrorCurve::D, &ErrorCurve::shift_D, &ErrorCurve::slope_D}};

/// The scatter of one sample if it falls as samples^(-1/2), weighted as the points are known.
double scatter_of_one_sample(const ErrorCurve& curve, const TimedQuantity& quantity) {
  double weights = 0, sum = 0;
  for (const ErrorPoint& p : curve.points) {
    const double weight = p.repetitions - 1;
    weights += weight;
    sum += weight * std::log(p.*quantity.scatter * std::sqrt(static_cast<double>(p.samples)));
  }
  return std::exp(sum / weights);
}

double known_shift(const Estimate& shift) {
  return shift.known() && std::abs(shift.value) > significant_shift * shift.standard_error ? std::abs(shift.value) : 0;
}

/// A panel as it is being filled.
struct ErrorPanel {
  Panel panel = left_panel();
  Range x, y;
};

/// `cost`: of one sample of the curve, on the axis.
void add_curve(ErrorPanel& panel, Plot& plot, const ErrorCurve& curve, const TimedQuantity& quantity, double cost,
               std::size_t number) {
  CsvTable table({"cost: beads", "error: bead diameters", "error_low: bead diameters", "error_high: bead diameters",
                  "samples: piles", "repetitions: repetitions"});
  for (const ErrorPoint& p : curve.points) {
    const double error = p.*quantity.scatter, relative = 1 / std::sqrt(2.0 * (p.repetitions - 1));
    table.add_row({cost * static_cast<double>(p.samples), error, error * std::exp(-relative),
                   error * std::exp(relative), static_cast<double>(p.samples), static_cast<double>(p.repetitions)});
    panel.x.add(cost * static_cast<double>(p.samples));
    panel.y.add(error * std::exp(-relative));
    panel.y.add(error * std::exp(relative));
  }
  const std::string file = plot.add_data(fmt::format("{}-{}", quantity.name, number + 1), table);
  const Ink ink = ink_of_series(number);
  const double one = scatter_of_one_sample(curve, quantity) * std::sqrt(cost);
  const double first = cost * static_cast<double>(curve.points.front().samples);
  const double last = cost * static_cast<double>(curve.points.back().samples);
  const double shift = known_shift(curve.*quantity.shift);
  panel.panel.add_function(fmt::format("{}/sqrt($1)", exact(one)), first, last, ink.line(1.2));
  panel.panel.add_function(fmt::format("sqrt({}/$1 + {})", exact(one * one), exact(shift * shift)), first,
                           outlook * last, ink.line(0.8, 2));
  panel.panel.add(file, "1:2:3:4", ink.bars(0.8, 0.5));
  panel.x.add(outlook * last / 4);
  panel.y.add(std::sqrt(one * one / (outlook * last) + shift * shift));
}

/// How many times cheaper than the first curve (the paper's procedure) one reaches the same scatter.
std::string gain_over(const ErrorCurve& first, double first_cost, const ErrorCurve& curve, double cost,
                      const TimedQuantity& quantity) {
  const double ratio = std::pow(scatter_of_one_sample(first, quantity) / scatter_of_one_sample(curve, quantity), 2);
  return caption_number(ratio * first_cost / cost, 2);
}

/// Relative error of such a ratio: of a variance over R repetitions by another, 2/sqrt(R - 1). The larger ensembles
/// consist of the piles of the smaller ones and add little.
double gain_error(double repetitions) { return 2 / std::sqrt(repetitions - 1); }

}  // namespace

Figure plot_error_against_time(const std::vector<ErrorCurve>& curves, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = figure_id;
  plot.height = 3.5;
  plot.key = {.inches = 1.2, .lines = 8, .sample = 2, .entries = {}};
  ErrorPanel panels[2];
  std::vector<std::string> slopes_c, slopes_D, floors, missing, gains;
  const ErrorCurve* point = nullptr;
  Range repetitions;
  double point_cost = 0;
  std::string unloaded_layers;
  for (const ErrorCurve& curve : curves) {
    if (curve.points.empty()) {
      missing.push_back(in_words(curve.spec.response));
      continue;
    }
    if (curve.spec.response.estimator == EstimatorName::fluctuation) {
      unloaded_layers = std::to_string(curve.spec.lattice.layers);
    }
    const double cost = 1e-6 * static_cast<double>(curve.beads) / static_cast<double>(curve.samples);
    for (const ErrorPoint& p : curve.points) repetitions.add(p.repetitions);
    const std::size_t number = plot.key.entries.size();  // of the curve: those not shown count for nothing
    for (const std::size_t q : {0, 1}) add_curve(panels[q], plot, curve, quantities[q], cost, number);
    const std::string name = in_words(curve.spec.response);
    plot.key.entries.push_back({name, ink_of_series(number).points(0.6),
                                fmt::format("{}:  c = {},  D = {}", name, in_words(curve.c), in_words(curve.D))});
    slopes_c.push_back(in_words(curve.slope_c));
    slopes_D.push_back(in_words(curve.slope_D));
    std::vector<std::string> shifts;
    for (const TimedQuantity& quantity : quantities) {
      if (known_shift(curve.*quantity.shift) > 0) {
        shifts.push_back(fmt::format("{} by {}", quantity.name, in_words(curve.*quantity.shift)));
      }
    }
    if (!shifts.empty()) floors.push_back(fmt::format("{} ({})", in_words(curve.spec.response), enumeration(shifts)));
    if (curve.spec.response.estimator == EstimatorName::point && !curve.spec.response.coupled) {
      point = &curve;
      point_cost = cost;
    } else if (point != nullptr) {
      gains.push_back(
          fmt::format("{} for c and {} for D ({})", gain_over(*point, point_cost, curve, cost, quantities[0]),
                      gain_over(*point, point_cost, curve, cost, quantities[1]), in_words(curve.spec.response)));
    }
  }
  if (plot.key.entries.empty()) {
    throw InputError(
        "the figure of error against run time has nothing to show, because no repetition has a fit of two peaks; give "
        "studies.error_against_time.mu where peaks stand apart, or more piles each time");
  }
  for (const std::size_t q : {0, 1}) {
    Panel& panel = panels[q].panel;
    panel.left = q == 0 ? 0.12 : 0.615;
    panel.right = q == 0 ? 0.48 : 0.97;
    panel.name = q == 0 ? 0.015 : 0.53;
    panel.x = log_axis("million beads drawn", widened_by_factor(panels[q].x, 1.4));
    panel.y = log_axis(fmt::format("standard error of {}", quantities[q].name), widened_by_factor(panels[q].y, 1.3));
    plot.panels.push_back(panel);
  }
  return plot_figure(plot,
                     {"studies/error_against_time.captions",
                      {{"mu", caption_number(curves.front().spec.sampler.mu)},
                       {"columns", std::to_string(curves.front().spec.lattice.columns)},
                       {"layers", std::to_string(curves.front().spec.lattice.layers)},
                       {"unloaded_layers", unloaded_layers},
                       {"slopes_c", enumeration(slopes_c)},
                       {"slopes_D", enumeration(slopes_D)},
                       {"floors", enumeration(floors)},
                       {"gains", enumeration(gains)},
                       {"gain_error", caption_number(std::round(gain_error(repetitions.high) * 10) * 10)},
                       {"most_repetitions", caption_number(repetitions.high)},
                       {"fewest_repetitions", caption_number(repetitions.low)},
                       {"missing", enumeration(missing)}}},
                     run_folder);
}

using Json = nlohmann::ordered_json;

void to_json(Json& json, const ErrorPoint& point) {
  json = {{"samples", point.samples},
          {"repetitions", point.repetitions},
          {"scatter_c", finite_or_null(point.scatter_c)},
          {"scatter_D", finite_or_null(point.scatter_D)}};
}

void to_json(Json& json, const ErrorCurve& curve) {
  const ResponseSpec& response = curve.spec.response;
  json = {{"estimator", name_of(response.estimator)},
          {"mu", curve.spec.sampler.mu},
          {"columns", curve.spec.lattice.columns},
          {"layers", curve.spec.lattice.layers}};
  json.update(Json(response));
  json.update(Json{{"samples", curve.samples},
                   {"failed", curve.failed},
                   {"beads", curve.beads},
                   {"points", curve.points},
                   {"c", curve.c},
                   {"D", curve.D},
                   {"shift_c", curve.shift_c},
                   {"shift_D", curve.shift_D},
                   {"slope_c", curve.slope_c},
                   {"slope_D", curve.slope_D}});
}

namespace {

constexpr int most_repetitions = 256;

class ErrorAgainstTimeStudy final : public CopiedStudy<ErrorAgainstTimeStudy> {
 public:
  std::string id() const override { return "error_against_time"; }

  std::vector<Key> keys() override {
    return {make_key(table(), "repetitions", "repetitions",
                     "independent repetitions of each estimator from which its error is taken and plotted against the "
                     "beads drawn; 0: none",
                     repetitions_,
                     KeyRange{.or_zero = true,
                              .why = "the scatter of fewer than 8 says nothing about an error, and their sums are kept "
                                     "apart, each in blocks of its own"}
                         .within(8, most_repetitions)),
            make_key(table(), "mu", "", "friction coefficient of that comparison", mu_, friction_range_above_zero()),
            make_key(table(), "columns", "beads", "beads per layer of its piles", lattice_.columns),
            make_key(table(), "layers", "layers", "layers of its piles", lattice_.layers)};
  }

  bool asked() const override { return repetitions_ > 0; }

  Problem find_problem(const MainLine& main) const override {
    if (main.sampling.law != Law::granusolve) {
      return problem(key("repetitions"),
                     "only the law granusolve draws enough piles in which peaks stand apart, but sampling.law is {}; "
                     "set repetitions = 0 or change the law",
                     name_of(main.sampling.law));
    }
    const int columns = lattice_.columns, layers = lattice_.layers;
    constexpr int least_layers = bottom_margin + 40;
    if (auto found = find_lattice_problem(key("columns"), columns, key("layers"), layers, least_layers,
                                          pile_memory(columns, layers))) {
      return found;
    }
    constexpr double room_for_widths = 24;  // bead diameters: eight widths of 3
    const double least_columns = 2 * tan30 * Lattice::depth(layers - bottom_margin) + room_for_widths;
    if (columns >= least_columns) return {};
    return problem(key("columns"),
                   "{} columns: the two peaks meet behind the ring above layer {}, so that no slope could be fitted; "
                   "give at least {}, or fewer layers",
                   columns, layers - bottom_margin, std::ceil(least_columns));
  }

  /// Small repetitions of noisy estimators have no fit, so that these need more piles each time.
  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    const auto add_curve = [&](const std::string& name, const ResponseSpec& response, std::uint64_t samples_each_time) {
      EnsembleSpec spec = main.ensemble_at(mu_, lattice_, 0);
      spec.response = response;
      spec.response.samples = samples_each_time * static_cast<std::uint64_t>(repetitions_);
      spec.response.blocks = repetition_blocks * repetitions_;
      spec.layers = layers_to_record(error_curve_fit(lattice_), {});
      if (response.estimator == EstimatorName::fluctuation) spec.lattice = unloaded_piles(spec);
      all.push_back({fmt::format("error against time, {}", name), fmt::format("error-{}", name), spec});
    };
    add_curve("point", {}, 256);
    add_curve("point-coupled", {.overloads = 0, .coupled = true}, 256);
    add_curve("multiplexed-0.1", multiplexed_response(0.1), 64);
    add_curve("multiplexed-0.25", multiplexed_response(0.25), 64);
    add_curve("multiplexed-0.5", multiplexed_response(0.5), 64);
    add_curve("multiplexed-0.25-opposite-runs-2", multiplexed_response(0.25, true, 2), 64);
    add_curve("multiplexed-0.1-opposite-runs-2", multiplexed_response(0.1, true, 2), 64);
    add_curve("fluctuation", {.estimator = EstimatorName::fluctuation}, 64);
    return all;
  }

  void begin(const MainLine&, int threads) override { threads_ = threads; }
  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override {
    curves_.push_back(measure_error_curve(ensemble, error_curve_fit(lattice_), threads_));
  }
  void finish() override { set_shifts(curves_); }

  Json json() const override { return curves_; }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    if (curves_.empty()) return {};
    return {[this](const std::filesystem::path& folder) { return plot_error_against_time(curves_, folder); }};
  }

 private:
  /// Piles deep enough that most of their layers are compared.
  static LatticeSpec unloaded_piles(const EnsembleSpec& spec) {
    constexpr int times_deeper = 2;
    return {spec.lattice.columns, times_deeper * fluctuation_plan(spec).layers_needed};
  }

  int repetitions_ = 0;  ///< independent ones of each estimator; 0: not measured
  double mu_ = 0.3;
  LatticeSpec lattice_{500, 200};
  int threads_ = 0;
  std::vector<ErrorCurve> curves_;  ///< one for each estimator
};

}  // namespace

std::unique_ptr<Study> error_against_time_study() { return std::make_unique<ErrorAgainstTimeStudy>(); }

}  // namespace granuscope
