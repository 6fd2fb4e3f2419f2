#include "studies/nonlinearity.h"

#include <fmt/ranges.h>

#include <map>
#include <optional>
#include <set>

#include "analysis/double_gaussian.h"
#include "analysis/scaling.h"
#include "plot/plot.h"
#include "report/number_text.h"
#include "report/page_scope.h"

namespace granuscope {
void to_json(Json& json, const LoadResponse& one) {
  json = {{"mu", one.spec.sampler.mu},
          {"estimator", one.uniform() ? name_of(one.spec.load) : name_of(one.spec.response.estimator)},
          {"load", one.load()},
          {"reference", one.reference},
          {"columns", one.spec.lattice.columns},
          {"layers", one.spec.lattice.layers},
          {"samples", one.samples},
          {"failed", one.failed},
          {"window_layers", {one.first_layer, one.last_layer}},
          {"own_window", one.own_window},
          {"c", one.c},
          {"D", one.D},
          {"c_thrust", one.c_thrust},
          {"c_minus_linear", one.c_shift},
          {"D_over_linear_minus_1", one.D_shift},
          {"c_thrust_minus_uniform", one.c_thrust_shift}};
}

void to_json(Json& json, const LoadExponents& one) {
  json = {{"estimator", name_of(one.response.estimator)},
          {"load", load_size(one.response)},
          {"reference", one.reference},
          {"window", one.window},
          {"points", one.points},
          {"beta", one.beta},
          {"gamma", one.gamma},
          {"beta_minus_linear", one.beta_shift},
          {"gamma_minus_linear", one.gamma_shift}};
}

namespace {

class NonlinearityStudy final : public CopiedStudy<NonlinearityStudy> {
 public:
  explicit NonlinearityStudy(LoadComparison measured) : measured_(std::move(measured)) {}

  std::string id() const override { return "nonlinearity"; }

  std::vector<Key> keys() override {
    const KeyRange loads{.fewest = 1,
                         .longest = 6,
                         .ascending = true,
                         .why = "beside loads of 1 it cannot be measured, or not in one figure"};
    return {make_key(table(), "mu", "",
                     "friction coefficients at which the response to several loads is compared with the linear one; "
                     "none: not at all",
                     mu_, friction_range_above_zero()),
            make_key(table(), "epsilons", "loads of one top bead",
                     "multiplexed loads compared; that of response.epsilon must be among them and stands for the "
                     "linear response",
                     epsilons_, KeyRange(loads).within(0.01, 0.99)),
            make_key(table(), "overloads", "loads of one top bead", "point loads compared", overloads_,
                     KeyRange(loads).within(0.01, 100)),
            make_key(table(), "multiplexed_samples", "piles",
                     "piles at response.epsilon and under a uniform load; at another epsilon in inverse proportion to "
                     "its square, for errors of one size",
                     multiplexed_samples_),
            make_key(table(), "point_samples", "piles",
                     "piles at the overload 1; at another one in inverse proportion to it", point_samples_)};
  }

  bool asked() const override { return !mu_.empty(); }

  void derive(MainLine& main, const IsOpen& open) override {
    if (open(key("epsilons")) && std::ranges::count(epsilons_, main.response.epsilon) == 0)
      epsilons_.insert(std::ranges::upper_bound(epsilons_, main.response.epsilon), main.response.epsilon);
    Study::derive(main, open);
  }

  Problem find_problem(const MainLine& main) const override {
    if (std::ranges::find(epsilons_, main.response.epsilon) == epsilons_.end()) {
      return problem(key("epsilons"),
                     "response.epsilon = {} is not among [{}], but the linear response is measured with it and the "
                     "others are compared with that; add it",
                     main.response.epsilon, fmt::join(epsilons_, ", "));
    }
    if (mu_.back() > main.mu.back()) {
      return problem(key("mu"),
                     "{} is above the largest friction coefficient of friction.mu, {}, for which lattice.columns were "
                     "found wide enough; leave it out",
                     mu_.back(), main.mu.back());
    }
    const int blocks = main.response.blocks;
    if (auto found = find_samples_problem(key("multiplexed_samples"), multiplexed_samples_, blocks)) return found;
    return find_samples_problem(key("point_samples"), point_samples_, blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const double mu : mu_) add_loads(mu, main, all);
    return all;
  }

  void prepare() override { comparer_.emplace(main_.fit, main_.response.epsilon, threads_); }
  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override { comparer_->add(ensemble); }
  void finish() override { measured_ = comparer_->finish(); }

  Json json() const override { return {{"responses", measured_.responses}, {"exponents", measured_.exponents}}; }

  std::vector<ReportPart> parts() const override {
    ReportPart loads = part(id(), "responses");
    loads.overlay = load_overlay({{"studies", {{id(), json()}}}}, loads.base);
    return {loads};
  }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    if (measured_.responses.empty()) return {};
    return {[this](const fs::path& folder) { return plot_load_comparison(measured_, id(), folder); }};
  }

 private:
  /// On columns just wide enough for the response: beads outside it would cost time and tell nothing.
  void add_loads(double mu, const MainLine& main, std::vector<StudyEnsemble>& all) const {
    FitSpec fit = main.fit;
    fit.shallow_layer = fit.first_layer;  // nothing is plotted of the layers above the window
    constexpr double handy = 16;          // for the Fourier transforms
    const int enough = static_cast<int>(handy * std::ceil(columns_needed(mu, fit.last_layer) / handy));
    const LatticeSpec lattice{std::min(enough, main.lattice.columns), main.lattice.layers};
    const double reference = main.response.epsilon;
    const auto add_load = [&](const std::string& name, double mean_samples, const auto& change) {
      EnsembleSpec spec = main.ensemble_at(mu, lattice, whole_rounds(mean_samples, main.response.blocks));
      spec.layers = layers_to_record(fit, {});
      change(spec);
      all.push_back({fmt::format("load {}, mu = {}", name, mu), fmt::format("load-{}-mu-{}", name, exact(mu)), spec});
    };
    const auto multiplexed = static_cast<double>(multiplexed_samples_);
    for (const double epsilon : epsilons_) {
      add_load("multiplexed-" + exact(epsilon), multiplexed * std::pow(reference / epsilon, 2),
               [&](EnsembleSpec& spec) {
                 spec.response.estimator = EstimatorName::multiplexed;
                 spec.response.epsilon = epsilon;
               });
    }
    for (const double overload : overloads_) {
      add_load("point-" + exact(overload), static_cast<double>(point_samples_) / overload,
               [&](EnsembleSpec& spec) { spec.response.overload = overload; });
    }
    add_load(name_of(Load::uniform), multiplexed, [](EnsembleSpec& spec) {
      spec.load = Load::uniform;
      spec.record_profiles = false;
    });
  }

  /// The least number of samples, at least that many, of which every block holds as many groups.
  static std::uint64_t whole_rounds(double samples, int blocks) {
    const std::uint64_t round = group_size * static_cast<std::uint64_t>(blocks);
    return round * static_cast<std::uint64_t>(std::max(1.0, std::ceil(samples / static_cast<double>(round) - 1e-9)));
  }

  std::vector<double> mu_;                        ///< each above 0; empty: not measured
  std::vector<double> epsilons_{0.1, 0.25, 0.5};  ///< multiplexed; the main line's is taken for the linear response
  std::vector<double> overloads_{0.25, 1, 4};     ///< point
  std::uint64_t multiplexed_samples_ = 1024;      ///< piles at the main line's epsilon; others ~ 1/epsilon^2
  std::uint64_t point_samples_ = 8192;            ///< piles at the overload 1; others in inverse proportion
  std::optional<LoadComparer> comparer_;
  LoadComparison measured_;
};

}  // namespace

std::unique_ptr<Study> nonlinearity_study(LoadComparison measured) {
  return std::make_unique<NonlinearityStudy>(std::move(measured));
}

namespace {

constexpr double window_slack = 1e-9;  ///< both ends of [0.1, 0.3] are inside

double logarithm(double number) { return std::log(number); }
double log_of_slowing(double c) { return std::log(tan30 - c); }

bool has_empty_block(const BlockSums& sums) { return std::ranges::find(sums.count, 0) != sums.count.end(); }

Replicated difference(const Replicated& one, const Replicated& other) {
  return transform([](double a, double b) { return a - b; }, one, other);
}

Estimate unknown_because(const std::string& reason) {
  Estimate unknown;
  unknown.reason = reason;
  return unknown;
}

/// f(one, of_linear), or why it is unknown.
template <typename F>
Estimate compare(const Estimate& one, const Replicated& replicates, const Estimate& of_linear,
                 const Replicated& linear_replicates, F f) {
  if (!one.known()) return unknown_because(one.reason);
  if (!of_linear.known()) return unknown_because("the linear response is unknown here: " + of_linear.reason);
  return estimate(transform(f, replicates, linear_replicates));
}

}  // namespace

void LoadComparer::add(MeasuredEnsemble ensemble) {
  if (!open_.empty() && open_.front().spec.sampler.mu != ensemble.spec.sampler.mu) close_friction();
  open_.push_back(std::move(ensemble));
}

LoadComparer::Measured LoadComparer::measure(const MeasuredEnsemble& ensemble, const FitSpec& fit) const {
  Measured measured;
  LoadResponse& response = measured.response;
  const BlockSums& sums = ensemble.record.sums;
  response.spec = ensemble.spec;
  const ResponseSpec& load = ensemble.spec.response;
  response.reference = load.estimator == EstimatorName::multiplexed && load.epsilon == reference_epsilon_;
  response.samples = sums.samples();
  response.failed = ensemble.record.failed.size();
  response.first_layer = fit.first_layer;
  response.last_layer = fit.last_layer;
  if (response.uniform()) {
    response.c.reason = response.D.reason = "a uniform load has no response";
    measured.slopes = {{response.c, {}}, {response.D, {}}};
    return measured;
  }
  const MeasuredTransport transport = measure_transport(ensemble, fit, {}, threads_);
  response.c = transport.transport.c;
  response.D = transport.transport.D;
  response.first_layer = transport.transport.window_layers[0];
  measured.depths = transport.transport.depths_in_window;
  measured.slopes = {{response.c, transport.c}, {response.D, transport.D}};
  return measured;
}

FitSpec LoadComparer::starting_at(int first_layer) const {
  FitSpec fit = fit_;
  fit.first_layer = first_layer;
  return fit;
}

/// Where the runs of all loads overlap that can be fitted at enough of the depths of the linear response.
int LoadComparer::first_common_layer(const std::vector<Measured>& measured) const {
  int enough = 0;
  for (const Measured& one : measured) {
    if (one.response.reference) enough = static_cast<int>(std::ceil(common_share * one.depths));
  }
  int first = fit_.first_layer;
  for (const Measured& one : measured) {
    if (one.response.c.known() && one.depths >= enough) first = std::max(first, one.response.first_layer);
  }
  return first;
}

void LoadComparer::close_friction() {
  std::vector<Measured> measured;
  for (const MeasuredEnsemble& ensemble : open_) measured.push_back(measure(ensemble, fit_));
  const int common = first_common_layer(measured);
  const Replicated* uniform = nullptr;
  std::vector<Replicated> speeds;
  const MeasuredEnsemble* linear_ensemble = nullptr;
  for (std::size_t k = 0; k < open_.size(); ++k) {
    LoadResponse& response = measured[k].response;
    response.own_window = response.c.known() && response.first_layer > common;
    if (response.c.known() && response.first_layer < common) measured[k] = measure(open_[k], starting_at(common));
    if (!measured[k].response.own_window) measured[k].response.first_layer = common;
    if (measured[k].response.reference) linear_ensemble = &open_[k];
    const BlockSums& sums = open_[k].record.sums;
    if (has_empty_block(sums)) {
      speeds.push_back({std::nan(""), std::vector<double>(sums.count.size(), std::nan(""))});
    } else {
      speeds.push_back(thrust_speed(sums, common));
    }
    measured[k].response.c_thrust = estimate(speeds.back(), "a block of the ensemble holds no completed pile");
  }
  Slopes linear;
  linear.c.estimate.reason = linear.D.estimate.reason = "no such ensemble was drawn";
  for (std::size_t k = 0; k < open_.size(); ++k) {
    if (measured[k].response.reference) linear = measured[k].slopes;
    if (measured[k].response.uniform() && measured[k].response.c_thrust.known()) uniform = &speeds[k];
  }
  for (std::size_t k = 0; k < open_.size(); ++k) {
    Measured& one = measured[k];
    LoadResponse& response = one.response;
    one.linear = response.own_window && linear_ensemble != nullptr
                     ? measure(*linear_ensemble, starting_at(response.first_layer)).slopes
                     : linear;
    response.c_shift = compare(one.slopes.c.estimate, one.slopes.c.replicates, one.linear.c.estimate,
                               one.linear.c.replicates, [](double c, double of_linear) { return c - of_linear; });
    response.D_shift = compare(one.slopes.D.estimate, one.slopes.D.replicates, one.linear.D.estimate,
                               one.linear.D.replicates, [](double D, double of_linear) { return D / of_linear - 1; });
    response.c_thrust_shift = uniform == nullptr || !response.c_thrust.known()
                                  ? unknown_because("no thrust ratio is known to compare with")
                                  : estimate(difference(speeds[k], *uniform));
  }
  measured_.push_back(std::move(measured));
  open_.clear();
}

bool LoadComparer::has_logarithms(const Slopes& slopes) {
  return slopes.c.estimate.known() && slopes.D.estimate.known() &&
         estimate(transform(logarithm, slopes.D.replicates)).known() &&
         estimate(transform(log_of_slowing, slopes.c.replicates)).known();
}

/// The exponents of the load number `k` of every friction coefficient, and how they differ from those of the linear
/// response over the same friction coefficients and layers: others could not be compared.
LoadExponents LoadComparer::measure_exponents(std::size_t k) const {
  const std::array<double, 2> window = fit_.scaling_window;
  std::vector<Coefficients> points, linear_points;
  for (const std::vector<Measured>& loads : measured_) {
    const Measured& one = loads[k];
    const double mu = one.response.spec.sampler.mu;
    if (mu < window[0] - window_slack || mu > window[1] + window_slack) continue;
    if (!has_logarithms(one.slopes) || !has_logarithms(one.linear)) continue;
    points.push_back({mu, one.slopes.c.replicates, one.slopes.D.replicates});
    linear_points.push_back({mu, one.linear.c.replicates, one.linear.D.replicates});
  }
  const ReplicatedFits laws = fit_coefficients(points, window), linear = fit_coefficients(linear_points, window);
  const LoadResponse& load = measured_.front()[k].response;
  LoadExponents exponents;
  exponents.response = load.spec.response;
  exponents.reference = load.reference;
  exponents.window = {points.empty() ? window[0] : points.front().scanned,
                      points.empty() ? window[1] : points.back().scanned};
  exponents.points = static_cast<int>(points.size());
  exponents.beta = laws.beta.fit.exponent;
  exponents.gamma = laws.gamma.fit.exponent;
  const auto shift = [](const ReplicatedPowerLaw& one, const ReplicatedPowerLaw& of_linear) {
    return compare(one.fit.exponent, one.exponent, of_linear.fit.exponent, of_linear.exponent,
                   [](double a, double b) { return a - b; });
  };
  exponents.beta_shift = shift(laws.beta, linear.beta);
  exponents.gamma_shift = shift(laws.gamma, linear.gamma);
  return exponents;
}

LoadComparison LoadComparer::finish() {
  if (!open_.empty()) close_friction();
  LoadComparison result;
  for (const std::vector<Measured>& loads : measured_) {
    for (const Measured& one : loads) result.responses.push_back(one.response);
  }
  if (measured_.empty()) return result;
  for (std::size_t k = 0; k < measured_.front().size(); ++k) {
    if (!measured_.front()[k].response.uniform()) result.exponents.push_back(measure_exponents(k));
  }
  return result;
}

namespace {

constexpr double percent = 100, milli = 1000;

/// The responses to one kind of load at one friction coefficient, in the order of the loads.
struct Series {
  double mu = 0;
  EstimatorName estimator;
  std::vector<const LoadResponse*> loads;
};

struct NonlinearityPanels {
  Panel D = left_panel(), c = right_panel();
  Range load, D_range, c_range;
};

void add(Range& range, const Estimate& shift, double scale) {
  range.add(scale * shift.value, scale * shift.standard_error);
}

void add_series(Plot& plot, NonlinearityPanels& panels, const Series& series, std::size_t colour) {
  CsvTable table({"load: loads of one top bead", "D_shift_percent: %", "standard_error: %",
                  "c_shift_thousandths: 0.001", "standard_error: 0.001", "D: bead diameters",
                  "standard_error: bead diameters", "c: dimensionless", "standard_error: dimensionless",
                  "piles: piles"});
  for (const LoadResponse* one : series.loads) {
    if (!one->D_shift.known() || !one->c_shift.known()) continue;
    table.add_row({one->load(), percent * one->D_shift.value, percent * one->D_shift.standard_error,
                   milli * one->c_shift.value, milli * one->c_shift.standard_error, one->D.value, one->D.standard_error,
                   one->c.value, one->c.standard_error, static_cast<double>(one->samples)});
    panels.load.add(one->load());
    add(panels.D_range, one->D_shift, percent);
    add(panels.c_range, one->c_shift, milli);
  }
  if (table.empty()) return;
  const std::string file = plot.add_data(fmt::format("{}-mu-{}", name_of(series.estimator), exact(series.mu)), table);
  const bool point = series.estimator == EstimatorName::point;
  const Ink ink = ink_of_value(colour);
  const Style style = point ? ink.joined_bars(1.2, 0.55) : ink.joined_bars(0.8, 0.35, 2);
  panels.D.add(file, "1:2:3", style);
  panels.c.add(file, "1:4:5", style);
  if (point) plot.add_key("μ = " + caption_number(series.mu), ink.points(0.6));
}

std::string in_percent(const Estimate& shift) {
  return value_with_error(percent * shift.value, percent * shift.standard_error) + " %";
}

/// A mark for each load.
std::vector<Tick> load_marks(const LoadComparison& measured) {
  std::set<double> loads;
  for (const LoadResponse& one : measured.responses) {
    if (one.load() > 0) loads.insert(one.load());
  }
  std::vector<Tick> marks;
  marks.reserve(loads.size());
  for (const double load : loads) marks.push_back({caption_number(load), load});
  return marks;
}

/// "μ = 0.1: −24(3) %" for the overload nearest to the paper's.
std::vector<std::string> shifts_of_the_paper(const LoadComparison& measured) {
  std::vector<std::string> shifts;
  for (const LoadResponse& one : measured.responses) {
    const bool of_the_paper = one.spec.response.estimator == EstimatorName::point && one.load() == 1;
    if (!of_the_paper || !one.D_shift.known()) continue;
    shifts.push_back(fmt::format("{} at μ = {}", in_percent(one.D_shift), caption_number(one.spec.sampler.mu)));
  }
  return shifts;
}

}  // namespace

Figure plot_load_comparison(const LoadComparison& measured, const std::string& study,
                            const std::filesystem::path& run_folder) {
  std::vector<Series> all;
  std::map<double, std::size_t> colours;
  double reference = 0;
  for (const LoadResponse& one : measured.responses) {
    if (one.reference) reference = one.load();
    if (one.uniform()) continue;  // there is no response
    const double mu = one.spec.sampler.mu;
    const EstimatorName estimator = one.spec.response.estimator;
    colours.emplace(mu, colours.size());
    if (all.empty() || all.back().mu != mu || all.back().estimator != estimator) all.push_back({mu, estimator, {}});
    all.back().loads.push_back(&one);
  }
  Plot plot;
  plot.id = study;
  plot.height = 3.0;
  plot.key = {.inches = 0.5, .lines = 2, .entries = {}};
  NonlinearityPanels panels;
  panels.D_range.add(0);
  panels.c_range.add(0);
  for (const Series& series : all) add_series(plot, panels, series, colours.at(series.mu));
  if (panels.D.curves.empty()) {
    throw InputError(
        "the figure of the loads has nothing to show, because nothing could be compared with the linear response; list "
        "friction coefficients at which the width of the peaks can be told");
  }
  Panel &D = panels.D, &c = panels.c;
  D.x = log_axis("size of the load  (loads of one top bead)", widened_by_factor(panels.load, 1.3));
  D.x.ticks = load_marks(measured);
  c.x = D.x;
  D.y = linear_axis("change of D  (%)", widened(panels.D_range, 0.06), 7, panels.D_range);
  c.y = linear_axis("change of c  (1/1000)", widened(panels.c_range, 0.06), 7, panels.c_range);
  for (Panel* panel : {&D, &c}) panel->add_level(0, {.colour = "frame", .width = 0.8});
  plot.panels = {D, c};
  plot.add_key("one bead overloaded", {.width = 1.2});
  plot.add_key("all loads ±ε", {.width = 0.8, .dash = 2});
  return plot_figure(
      plot,
      {"studies/" + study + ".captions",
       {{"reference", caption_number(reference)}, {"paper_shifts", enumeration(shifts_of_the_paper(measured))}}},
      run_folder);
}

namespace {

bool is_the_papers(const Json& one) { return one.at("estimator") == "point" && one.at("load") == 1; }

/// Notes why there is no `estimate` of one load: "exponents with overload 4".
void add_load_reason(Json& notes, const Json& summary, const Json& one, const std::string& estimate,
                     const std::string& what, const std::string& place) {
  const std::string load = format_number(one.at("load"));
  add_reason(notes, summary, estimate, what + (one.at("estimator") == "point" ? "overload " : "ε = ") + load, place);
}

}  // namespace

Json load_overlay(const Json& summary, const std::string& base) {
  Json overlay, notes = Json::array();
  overlay["paper_load"] = overlay["paper_load_exponents"] = Json::array();
  const Json& measured = summary.at(Json::json_pointer(base));
  for (std::size_t i = 0; i < measured.at("responses").size(); ++i) {
    const Json& one = measured.at("responses")[i];
    const std::string pointer = fmt::format("{}/responses/{}", base, i);
    if (one.at("estimator") == "uniform") continue;  // it is what the last column compares with
    add_load_reason(notes, summary, one, pointer + "/D", "", " at μ = " + format_number(one.at("mu")));
    // The paper's load at the smallest friction where it can be told.
    if (is_the_papers(one) && overlay["paper_load"].empty() && !one.at("D_over_linear_minus_1").at("value").is_null()) {
      overlay["paper_load"].push_back({{"key", pointer}});
    }
  }
  for (std::size_t i = 0; i < measured.at("exponents").size(); ++i) {
    const Json& one = measured.at("exponents")[i];
    const std::string pointer = fmt::format("{}/exponents/{}", base, i);
    add_load_reason(notes, summary, one, pointer + "/beta", "the exponents with ", "");
    if (!is_the_papers(one)) continue;
    overlay["paper_load_exponents"] = Json::array();
    if (!one.at("beta_minus_linear").at("value").is_null() && !one.at("gamma_minus_linear").at("value").is_null()) {
      overlay["paper_load_exponents"].push_back({{"key", pointer}});
    }
  }
  finish_notes(notes);
  overlay["notes"] = notes;
  return overlay;
}

}  // namespace granuscope
