#include "studies/work_studies.h"

#include <map>
#include <numeric>

#include "analysis/claims.h"
#include "analysis/jackknife.h"
#include "ensemble/estimator.h"
#include "plot/plot.h"

namespace granuscope {
namespace {
/// Few, so that the largest piles need not be many.
constexpr int blocks = 8;

constexpr double paper_beads = 1e6;  ///< 1000 x 1000
/// Ratio of the largest to the smallest number of beads from which a power is taken.
constexpr double least_reach = 16;

double beads_of(const CountedWork& work) {
  return static_cast<double>(work.spec.lattice.columns) * work.spec.lattice.layers;
}

/// Power of the number of beads in the number of draws; NaN where sizes do not reach far enough.
double power_of_size(const std::vector<const CountedWork*>& sizes) {
  std::vector<double> log_beads, log_draws;
  for (const CountedWork* work : sizes) {
    if (work->samples == 0 || !(work->draws_per_bead > 0)) continue;
    log_beads.push_back(std::log(beads_of(*work)));
    log_draws.push_back(std::log(work->draws_per_bead * beads_of(*work)));
  }
  if (log_beads.empty()) return std::nan("");
  const auto [smallest, largest] = std::ranges::minmax_element(log_beads);
  if (*largest - *smallest < std::log(least_reach)) return std::nan("");
  return fit_line(log_beads, log_draws, std::vector<double>(log_beads.size(), 1.0)).slope;
}

}  // namespace

CountedWork counted_work(const MeasuredEnsemble& ensemble) {
  const SamplerCounts& counts = ensemble.record.counts;
  const auto per_bead = [&](std::uint64_t count) {
    return counts.beads == 0 ? std::numeric_limits<double>::quiet_NaN()
                             : static_cast<double>(count) / static_cast<double>(counts.beads);
  };
  CountedWork work;
  work.spec = ensemble.spec;
  const auto& completed = ensemble.record.sums.count;
  work.samples = std::accumulate(completed.begin(), completed.end(), std::uint64_t{0});
  work.failed = ensemble.record.failed.size();
  work.draws_per_bead = per_bead(counts.uniforms);
  work.repaired_per_bead = per_bead(counts.repaired_by_pair + counts.repaired_by_arc + counts.repaired_by_ring);
  work.backtracked_per_bead = per_bead(counts.backtracked);
  return work;
}

Claim judge_linear_time(const std::vector<CountedWork>& measured, const ClaimSpec& spec) {
  Claim claim = open_claim(
      "linear-time", "The work is linear in the number of beads; piles of 1000 × 1000 are solved up to μ about 1.7.",
      "power of the beads in the draws");
  const PaperNumber paper{.value = 1, .tolerance = spec.exponent_tolerance};
  claim.paper = paper.value;
  claim.tolerance = paper.tolerance;
  if (measured.empty()) {
    leave_open(claim,
               "no work was counted: set studies.counted_work.mu, up to 1.7; at that friction a pile of 1000 × "
               "1000 takes well below a second");
    return claim;
  }
  std::map<double, std::vector<const CountedWork*>> by_mu;
  std::uint64_t large_completed = 0, large_failed = 0;
  for (const CountedWork& work : measured) {
    by_mu[work.spec.sampler.mu].push_back(&work);
    if (work.spec.sampler.mu >= spec.highest_mu - 1e-9 && beads_of(work) >= paper_beads) {
      large_completed += work.samples;
      large_failed += work.failed;
    }
  }
  std::vector<double> mu;
  double farthest_mu = 0;
  for (const auto& [friction, sizes] : by_mu) {
    const double power = power_of_size(sizes);
    if (!std::isfinite(power)) continue;
    mu.push_back(friction);
    if (claim.measured.known() && std::abs(power - 1) <= std::abs(claim.measured.value - 1)) continue;
    farthest_mu = friction;
    claim.measured.value = power;
    claim.measured.standard_error = 0;  // counted
  }
  const bool power_known = claim.measured.known();
  const bool linear = power_known && judge_number(claim.measured, paper).verdict == reproduced;
  std::string of_power, of_size;
  if (power_known) {
    claim.quantity = fmt::format("power of the beads in the draws, farthest off at μ = {}", farthest_mu);
    claim.z_score = judge_number(claim.measured, paper).z_score;
    const auto fewer = [](const CountedWork* a, const CountedWork* b) { return beads_of(*a) < beads_of(*b); };
    const auto& sizes = by_mu[farthest_mu];
    const auto [smallest, largest] = std::ranges::minmax_element(sizes, fewer);
    of_power = fmt::format(
        "The number of draws grows as the power {} of the number of beads at μ = {}, where it is farthest from 1 among "
        "{}: {} draws per bead with {} × {} beads, {} with {} × {}.",
        significant(claim.measured.value, 4), farthest_mu, list_of_values(mu),
        significant((*smallest)->draws_per_bead, 4), (*smallest)->spec.lattice.columns,
        (*smallest)->spec.lattice.layers, significant((*largest)->draws_per_bead, 4), (*largest)->spec.lattice.columns,
        (*largest)->spec.lattice.layers);
  } else {
    claim.measured.reason = fmt::format("the sizes counted do not span a factor of {} in beads", least_reach);
    of_power = fmt::format("The sizes counted do not span a factor of {} in beads: widen studies.counted_work.sizes.",
                           least_reach);
  }
  if (large_failed > 0) {
    of_size = fmt::format("{} of {} piles of 10⁶ beads or more at μ ≥ {} could not be completed.", large_failed,
                          large_failed + large_completed, spec.highest_mu);
  } else if (large_completed > 0) {
    of_size =
        fmt::format("All {} piles of 10⁶ beads or more at μ ≥ {} were completed.", large_completed, spec.highest_mu);
  } else {
    of_size = fmt::format(
        "No pile of 1000 × 1000 was tried at μ = {}: it needs that value in studies.counted_work.mu "
        "and that size in sizes.",
        spec.highest_mu);
  }
  claim.verdict = large_failed > 0 || (power_known && !linear) ? not_reproduced
                  : power_known && large_completed > 0         ? reproduced
                                                               : not_tested;
  // What decides comes first.
  const bool size_decides = linear && (large_failed > 0 || large_completed == 0);
  add_sentence(claim, size_decides ? of_size : of_power);
  add_sentence(claim, size_decides ? of_power : of_size);
  return claim;
}

void to_json(Json& json, const CountedWork& work) {
  json = {{"mu", work.spec.sampler.mu},
          {"columns", work.spec.lattice.columns},
          {"layers", work.spec.lattice.layers},
          {"samples", work.samples},
          {"failed", work.failed},
          {"draws_per_bead", finite_or_null(work.draws_per_bead)},
          {"repaired_per_bead", finite_or_null(work.repaired_per_bead)},
          {"backtracked_per_bead", finite_or_null(work.backtracked_per_bead)}};
  if (json["draws_per_bead"].is_null()) json["reason"] = "no pile was completed";
}

namespace {

class CountedWorkStudy final : public CopiedStudy<CountedWorkStudy> {
 public:
  std::string id() const override { return "counted_work"; }

  std::vector<Key> keys() override {
    return {make_key(table(), "mu", "",
                     "friction coefficients at which the work of drawing is counted against size; none: not at all",
                     mu_, friction_range()),
            make_key(table(), "sizes", "beads", "columns and layers of the square piles", sizes_,
                     KeyRange{.fewest = 3, .ascending = true, .why = "fewer sizes show no law"}),
            make_key(table(), "samples", "piles", "piles per size and friction coefficient, at least 64", samples_)};
  }

  bool asked() const override { return !mu_.empty(); }

  Problem find_problem(const MainLine&) const override {
    for (const int size : sizes_) {
      if (auto found = find_lattice_problem(key("sizes"), size, key("sizes"), size, bottom_margin + 1,
                                            pile_memory(size, size))) {
        return found;
      }
    }
    return find_samples_problem(key("samples"), samples_, blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const double mu : mu_) {
      for (const int size : sizes_) {
        EnsembleSpec spec = main.ensemble_at(mu, {size, size}, samples_);
        spec.load = Load::uniform;
        spec.response.blocks = blocks;
        spec.layers = {size - bottom_margin - 1};  // nothing is measured; the ensemble is drawn to be counted
        spec.record_profiles = false;
        all.push_back({fmt::format("counted work, mu = {}, {} x {}", mu, size, size),
                       fmt::format("counted-work-mu-{}-{}x{}", exact(mu), size, size), spec});
      }
    }
    return all;
  }

  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override {
    measured_.push_back(counted_work(ensemble));
  }

  std::vector<Claim> claims(const ClaimSpec& spec) const override { return {judge_linear_time(measured_, spec)}; }

  Json json() const override { return measured_; }

  std::vector<ReportPart> parts() const override { return {table_part()}; }

 private:
  std::vector<double> mu_;                       ///< empty: not measured
  std::vector<int> sizes_{125, 250, 500, 1000};  ///< columns and layers of each square pile, ascending
  std::uint64_t samples_ = 64;                   ///< piles per size and friction coefficient
  std::vector<CountedWork> measured_;            ///< ascending in mu, then in size
};

}  // namespace

std::unique_ptr<Study> counted_work_study() { return std::make_unique<CountedWorkStudy>(); }

namespace {

constexpr const char* figure_of_errors = "error-against-time";
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
  Panel panel;
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
  plot.id = figure_of_errors;
  plot.height = 3.5;
  plot.key = {.inches = 1.2, .lines = 8, .sample = 2, .entries = {}};
  ErrorPanel panels[2] = {{left_panel(), {}, {}}, {right_panel(), {}, {}}};
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
    plot.add_key(name, ink_of_series(number).points(0.6));
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

  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override {
    curves_.push_back(measure_error_curve(ensemble, error_curve_fit(lattice_), threads_));
  }
  void finish() override { set_shifts(curves_); }

  Json json() const override { return curves_; }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    return figures_of(curves_, plot_error_against_time);
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
  std::vector<ErrorCurve> curves_;  ///< one for each estimator
};

}  // namespace

std::unique_ptr<Study> error_against_time_study() { return std::make_unique<ErrorAgainstTimeStudy>(); }

}  // namespace granuscope
