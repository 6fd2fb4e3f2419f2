#include "plot/error_against_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "plot/choice.h"
#include "plot/csv_table.h"
#include "plot/figure_words.h"
#include "plot/plot_script.h"
#include "plot/series_style.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr const char* figure_id = "error-against-time";
/// How far beyond the measured points the total error is drawn, so that floors show.
constexpr double outlook = 300;
constexpr double significant_shift = 3;  // standard errors

std::string name_in_words(const ErrorCurve& curve) {
  const ResponseSpec& response = curve.spec.response;
  const std::string name = name_of(response.estimator);
  if (response.estimator != EstimatorName::multiplexed) return name;
  return fmt::format("{}, ε = {}{}{}", name, caption_number(response.epsilon), response.opposite ? ", opposite" : "",
                     response.sign_run > 1 ? fmt::format(", runs of {}", response.sign_run) : "");
}

std::string in_words(const Estimate& number) {
  return number.known() ? value_with_error(number.value, number.standard_error) : "unknown";
}

/// One panel: c or D.
struct Quantity {
  const char* name;
  double ErrorPoint::*scatter;
  Estimate ErrorCurve::*mean;
  Estimate ErrorCurve::*shift;
  Estimate ErrorCurve::*slope;
};
constexpr Quantity quantities[] = {
    {"c", &ErrorPoint::scatter_c, &ErrorCurve::c, &ErrorCurve::shift_c, &ErrorCurve::slope_c},
    {"D", &ErrorPoint::scatter_D, &ErrorCurve::D, &ErrorCurve::shift_D, &ErrorCurve::slope_D}};

/// The scatter of one sample if it falls as samples^(-1/2), weighted as the points are known.
double scatter_of_one_sample(const ErrorCurve& curve, const Quantity& quantity) {
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

struct Panel {
  std::vector<std::string> curves;
  Range x, y;
};

/// `cost`: of one sample of the curve, on the axis.
void add_curve(Panel& panel, PlotPlan& plan, const ErrorCurve& curve, const Quantity& quantity, double cost,
               std::size_t number) {
  CsvTable table({"cost", "error", "error_low", "error_high", "samples", "repetitions"});
  for (const ErrorPoint& p : curve.points) {
    const double error = p.*quantity.scatter, relative = 1 / std::sqrt(2.0 * (p.repetitions - 1));
    table.add_row({cost * static_cast<double>(p.samples), error, error * std::exp(-relative),
                   error * std::exp(relative), static_cast<double>(p.samples), static_cast<double>(p.repetitions)});
    panel.x.add(cost * static_cast<double>(p.samples));
    panel.y.add(error * std::exp(-relative));
    panel.y.add(error * std::exp(relative));
  }
  const std::string file = fmt::format("{}-{}-{}.csv", figure_id, quantity.name, number + 1);
  plan.data[file] = table.text();
  const std::string style = series_style(number);
  const std::string colour = style.substr(style.find("linecolor"));
  const double one = scatter_of_one_sample(curve, quantity) * std::sqrt(cost);
  const double first = cost * static_cast<double>(curve.points.front().samples);
  const double last = cost * static_cast<double>(curve.points.back().samples);
  const double shift = known_shift(curve.*quantity.shift);
  panel.curves.push_back(fmt::format("[{}:{}] '+' using 1:({}/sqrt($1)) with lines linewidth 1.2 {} notitle",
                                     exact(first), exact(last), exact(one), colour));
  panel.curves.push_back(
      fmt::format("[{}:{}] '+' using 1:(sqrt({}/$1 + {})) with lines linewidth 0.8 dashtype 2 {} notitle", exact(first),
                  exact(outlook * last), exact(one * one), exact(shift * shift), colour));
  panel.curves.push_back(
      fmt::format("'{}' using 1:2:3:4 with yerrorbars linewidth 0.8 pointsize 0.5 {} notitle", file, style));
  plan.curves += 3;
  panel.x.add(outlook * last / 4);
  panel.y.add(std::sqrt(one * one / (outlook * last) + shift * shift));
}

/// How many times cheaper than the first curve (the paper's procedure) one reaches the same scatter.
std::string gain_over(const ErrorCurve& first, double first_cost, const ErrorCurve& curve, double cost,
                      const Quantity& quantity) {
  const double ratio = std::pow(scatter_of_one_sample(first, quantity) / scatter_of_one_sample(curve, quantity), 2);
  return caption_number(ratio * first_cost / cost, 2);
}

/// Relative error of such a ratio: of a variance over R repetitions by another, 2/sqrt(R - 1). The larger ensembles
/// consist of the piles of the smaller ones and add little.
double gain_error(double repetitions) { return 2 / std::sqrt(repetitions - 1); }

}  // namespace

Figure draw_error_against_time(const std::vector<ErrorCurve>& curves, const std::vector<double>& seconds,
                               const std::filesystem::path& run_folder) {
  const bool timed = std::all_of(seconds.begin(), seconds.end(), [](double s) { return std::isfinite(s) && s > 0; });
  PlotPlan plan;
  plan.id = figure_id;
  plan.script = "plot/error_against_time";
  plan.height = 3.5;
  Panel panels[2];
  std::vector<std::string> titles, slopes_c, slopes_D, floors, missing, gains;
  const ErrorCurve* point = nullptr;
  Range repetitions;
  double point_cost = 0;
  for (std::size_t k = 0; k < curves.size(); ++k) {
    const ErrorCurve& curve = curves[k];
    if (curve.points.empty()) {
      missing.push_back(name_in_words(curve));
      continue;
    }
    const double cost =
        (timed ? seconds[k] : 1e-6 * static_cast<double>(curve.beads)) / static_cast<double>(curve.samples);
    for (const ErrorPoint& p : curve.points) repetitions.add(p.repetitions);
    const std::size_t number = titles.size();  // of the curve: those not shown count for nothing
    for (const std::size_t q : {0, 1}) add_curve(panels[q], plan, curve, quantities[q], cost, number);
    titles.push_back(fmt::format("keyentry with points pointsize 0.6 {} title {}", series_style(number),
                                 gnuplot_string(fmt::format("{}:  c = {},  D = {}", name_in_words(curve),
                                                            in_words(curve.c), in_words(curve.D)))));
    slopes_c.push_back(in_words(curve.slope_c));
    slopes_D.push_back(in_words(curve.slope_D));
    std::vector<std::string> shifts;
    for (const Quantity& quantity : quantities) {
      if (known_shift(curve.*quantity.shift) > 0) {
        shifts.push_back(fmt::format("{} by {}", quantity.name, in_words(curve.*quantity.shift)));
      }
    }
    if (!shifts.empty()) floors.push_back(fmt::format("{} ({})", name_in_words(curve), enumeration(shifts)));
    if (curve.spec.response.estimator == EstimatorName::point) {
      point = &curve;
      point_cost = cost;
    } else if (point != nullptr) {
      gains.push_back(fmt::format("{} for c and {} for D ({})",
                                  gain_over(*point, point_cost, curve, cost, quantities[0]),
                                  gain_over(*point, point_cost, curve, cost, quantities[1]), name_in_words(curve)));
    }
  }
  if (titles.empty()) {
    throw InputError(
        "the figure of error against run time has nothing to show, because no repetition has a fit of two peaks; give "
        "figures.error_against_time.mu where peaks stand apart, or more piles each time");
  }
  Gaps gaps = {{"titles", fmt::format("{}", fmt::join(titles, ", \\\n    "))},
               {"axis", timed ? "seconds of drawing" : "million beads drawn"}};
  for (const std::size_t q : {0, 1}) {
    const Range x = widened_by_factor(panels[q].x, 1.4), y = widened_by_factor(panels[q].y, 1.3);
    const std::string name = quantities[q].name;
    gaps[name + "_curves"] = fmt::format("{}", fmt::join(panels[q].curves, ", \\\n    "));
    gaps[name + "_x_low"] = exact(x.low);
    gaps[name + "_x_high"] = exact(x.high);
    gaps[name + "_x_ticks"] = log_ticks(x);
    gaps[name + "_y_low"] = exact(y.low);
    gaps[name + "_y_high"] = exact(y.high);
    gaps[name + "_y_ticks"] = log_ticks(y);
  }
  Figure figure = draw_plot(plan, gaps, run_folder);
  set_words(figure, "plot/error_against_time.words",
            {{"mu", caption_number(curves.front().spec.sampler.mu)},
             {"columns", std::to_string(curves.front().spec.lattice.columns)},
             {"layers", std::to_string(curves.front().spec.lattice.layers)},
             {"timed", timed ? "yes" : ""},
             {"untimed", timed ? "" : "yes"},
             {"slopes_c", enumeration(slopes_c)},
             {"slopes_D", enumeration(slopes_D)},
             {"floors", enumeration(floors)},
             {"gains", enumeration(gains)},
             {"gain_error", caption_number(std::round(gain_error(repetitions.high) * 10) * 10)},
             {"most_repetitions", caption_number(repetitions.high)},
             {"fewest_repetitions", caption_number(repetitions.low)},
             {"missing", enumeration(missing)}});
  return figure;
}

}  // namespace granuscope
