#include "studies/small_friction.h"

#include <set>

#include "analysis/mean_response.h"
#include "analysis/scaling.h"
#include "ensemble/estimator.h"
#include "plot/plot.h"
#include "plot/power_law_panel.h"

namespace granuscope {
namespace {
constexpr int shown_depths = 40;      ///< spread evenly in ln z
constexpr int averaged_depths = 500;  ///< at most about this many enter the average

int usable(int layers) { return Lattice({4, layers}).usable_layers(); }

int first_deep_layer(int layers) { return usable(layers) / 2; }

constexpr const char* figure_of_peaks = "small-friction";

struct Saturation {
  Panel panel = left_panel();
  Range depth, variance;
};

/// Mean of the weight variance over the deep part; not a number if it is unknown there.
double deep_variance(const SmallFriction& one) {
  double sum = 0, layers = 0;
  for (const ThrustAtDepth& depth : one.depths) {
    if (depth.layer < one.first_layer || depth.layer > one.last_layer || !depth.weight_variance.known()) continue;
    sum += depth.weight_variance.value;
    ++layers;
  }
  return sum / layers;
}

/// The variance of the weights over its deep value, against the layer in units of 0.6/mu^2, at layers a tenth apart.
void add_saturation(Plot& plot, Saturation& all, const SmallFriction& one) {
  const double deep = deep_variance(one);
  const double saturation = one.spec.lattice.layers / one.depth_over_saturation;
  if (!(deep > 0) || !(saturation > 0)) return;
  CsvTable table({"layers_over_saturation: 0.6/mu^2 layers", "variance_over_deep: dimensionless",
                  "standard_error: dimensionless", "layer: layers", "weight_variance: loads of one top bead squared"});
  double last = 0;
  for (const ThrustAtDepth& depth : one.depths) {
    if (!depth.weight_variance.known() || depth.layer < 1.1 * last || depth.layer == 0) continue;
    last = depth.layer;
    const double x = depth.layer / saturation, y = depth.weight_variance.value / deep;
    const double error = depth.weight_variance.standard_error / deep;
    table.add_row({x, y, error, last, depth.weight_variance.value});
    all.depth.add(x);
    all.variance.add(y, error);
  }
  if (table.empty()) return;
  const Ink ink = ink_of_value(all.panel.curves.size());
  all.panel.add(plot.add_data("mu-" + exact(one.spec.sampler.mu), table), "1:2:3", ink.bars(0.8, 0.35));
  plot.add_key("μ = " + caption_number(one.spec.sampler.mu), ink.points(0.55));
}

PowerLawPoint point_of(double mu, const Estimate& slowing) {
  return {mu, mu, 0, slowing.value, slowing.standard_error};
}

}  // namespace

double saturation_layers(double mu) { return 0.6 / (mu * mu); }

std::vector<int> thrust_layers(int layers) {
  const int last = usable(layers) - 1;
  std::set<int> recorded;
  for (int k = 0; k < shown_depths; ++k) {
    recorded.insert(static_cast<int>(std::lround(std::pow(last, static_cast<double>(k) / (shown_depths - 1)))));
  }
  const int deep = last - first_deep_layer(layers);
  const int step = std::max(1, deep / averaged_depths) | 1;  // odd, so that both row parities take part
  for (int layer = last; layer >= first_deep_layer(layers); layer -= step) recorded.insert(layer);
  return {recorded.begin(), recorded.end()};
}

MeasuredSmallFriction measure_small_friction(const MeasuredEnsemble& ensemble) {
  const BlockSums& sums = ensemble.record.sums;
  MeasuredSmallFriction measured;
  SmallFriction& result = measured.result;
  result.spec = ensemble.spec;
  const int layers = ensemble.spec.lattice.layers;
  result.samples = sums.samples();
  result.depth_over_saturation = layers / saturation_layers(ensemble.spec.sampler.mu);
  result.first_layer = first_deep_layer(layers);
  result.last_layer = sums.layers.back();
  std::vector<Replicated> deep;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    const int layer = sums.layers[row];
    const Replicated thrust = block_mean(sums, "thrust", row);
    result.depths.push_back(
        {layer, Lattice::depth(layer), estimate(thrust), estimate(block_mean(sums, "weight_variance", row))});
    if (layer >= result.first_layer) deep.push_back(thrust);
  }
  const Replicated alpha = mean_of(deep);
  const Replicated c = transform([](double kappa) { return speed_from_thrust(kappa); }, alpha);
  measured.c0_minus_c = transform([](double speed) { return tan30 - speed; }, c);
  result.alpha_thrust = estimate(alpha);
  result.c_thrust = estimate(c, "the mean thrust ratio is negative");
  result.c0_minus_c = estimate(measured.c0_minus_c, "the mean thrust ratio is negative");
  return measured;
}

ScalingFit fit_small_friction(const std::vector<MeasuredSmallFriction>& measured) {
  std::vector<Replicated> log_mu, log_slowing;
  std::array<double, 2> window{};
  for (const MeasuredSmallFriction& one : measured) {
    const Replicated slowing = transform([](double s) { return std::log(s); }, one.c0_minus_c);
    if (one.result.spec.sampler.mu <= 0 || !estimate(slowing).known()) continue;
    if (log_mu.empty()) window[0] = one.result.spec.sampler.mu;
    window[1] = one.result.spec.sampler.mu;
    log_mu.push_back(transform([&](double) { return std::log(one.result.spec.sampler.mu); }, slowing));
    log_slowing.push_back(slowing);
  }
  return fit_power_law(log_mu, log_slowing, window);
}

Figure plot_small_friction(const Analysis& main, const std::vector<SmallFriction>& measured, const ScalingFit& scaling,
                           const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = figure_of_peaks;
  plot.height = 3.1;
  plot.key = {.inches = 0.5, .lines = 2, .sample = 2, .entries = {}};
  Saturation saturation;
  PowerLawPanel panel;
  panel.id = "slowing";
  panel.x_label = "friction coefficient μ";
  panel.y_label = "c₀ − c  (thrust)";
  panel.left = 0.60;
  panel.paper_exponent = 1;
  panel.paper_note = "the paper, for c: 1";
  panel.ratios = true;
  PowerLawSeries narrow{"narrow-piles", {}, scaling, {"blue", 7}, "narrow deep piles: " + in_words(scaling.exponent)};
  PowerLawSeries wide{"main-piles", {}, {}, {"vermilion", 13}, ""};
  wide.fit.window = main.scaling.gamma.window;
  int columns = 0;
  double shallowest = std::numeric_limits<double>::infinity();
  for (const SmallFriction& one : measured) {
    if (!one.c0_minus_c.known()) continue;
    add_saturation(plot, saturation, one);
    narrow.points.push_back(point_of(one.spec.sampler.mu, one.c0_minus_c));
    columns = one.spec.lattice.columns;
    shallowest = std::min(shallowest, one.depth_over_saturation);
  }
  for (const Transport& result : main.results) {
    if (result.exact || !result.c_thrust.known()) continue;
    wide.points.push_back(
        point_of(result.scanned(), {tan30 - result.c_thrust.value, result.c_thrust.standard_error, ""}));
  }
  const bool with_wide = std::ranges::any_of(wide.points, fits_log_axes);
  if (with_wide) wide.note = "the main piles";
  panel.series = {wide, narrow};
  const Estimate& exponent = scaling.exponent;
  const bool saturates = !saturation.panel.curves.empty();
  if (saturates) {
    const Range& reach = saturation.depth;
    saturation.variance.add(0);
    saturation.variance.add(1.15);
    Panel& left = saturation.panel;
    left.right = 0.49;
    left.x = log_axis("layer  in units of 0.6/μ²", widened_by_factor(reach, reach.high > 1.5 * reach.low ? 1.3 : 2));
    left.y = linear_axis("variance / deep value", {saturation.variance.low, 1.05 * saturation.variance.high, false}, 6,
                         saturation.variance);
    left.add_level(1, {.colour = "frame", .width = 0.8});
    plot.panels.push_back(left);
  }
  const PowerLawShown law = add_power_law_panel(plot, panel);
  if (!saturates || !law.shown) {
    throw InputError(
        "the figure of small friction has nothing to show, because no thrust ratio was measured for it; list friction "
        "coefficients in studies.small_friction.mu");
  }
  return plot_figure(plot,
                     {"studies/small_friction.captions",
                      {{"columns", std::to_string(columns)},
                       {"shallowest", caption_number(shallowest, 2)},
                       {"exponent", exponent.known() ? in_words(exponent) : ""},
                       {"reason", exponent.known() ? "" : exponent.reason},
                       {"chi2", scaling.misses_the_points() ? significant(scaling.scatter.chi2, 2) : ""},
                       {"degrees", std::to_string(scaling.scatter.degrees_of_freedom)},
                       {"running", scaling.running.meets_the_points() ? "yes" : ""},
                       {"at_low", in_words(scaling.running.at_low)},
                       {"at_high", in_words(scaling.running.at_high)},
                       {"low", caption_number(scaling.window[0])},
                       {"high", caption_number(scaling.window[1])},
                       {"main_piles", with_wide ? "yes" : ""},
                       {"off_scale", law.off_scale}}},
                     run_folder);
}

void to_json(Json& json, const SmallFriction& small) {
  json = {{"mu", small.spec.sampler.mu},
          {"columns", small.spec.lattice.columns},
          {"layers", small.spec.lattice.layers},
          {"samples", small.samples},
          {"depth_over_saturation", small.depth_over_saturation},
          {"window_layers", {small.first_layer, small.last_layer}},
          {"alpha_thrust", small.alpha_thrust},
          {"c_thrust", small.c_thrust},
          {"c0_minus_c_thrust", small.c0_minus_c},
          {"depths", small.depths}};
}

namespace {

/// Peaks are told from here on: narrower ones have c and D that the size of a bead biases.
constexpr double least_peak_width = 0.8;  // bead diameters

/// The layers over which c and D are slopes: from where the peaks of the smallest friction, of W^2 = 0.57 mu^2 z, are
/// that wide to twice as deep, an odd step so that both row parities take part.
FitSpec peak_window(const std::vector<double>& mu) {
  constexpr double D_over_mu2 = 0.57;
  FitSpec fit;
  fit.layer_step = 17;
  const double first = least_peak_width * least_peak_width / (D_over_mu2 * mu.front() * mu.front() * sqrt3 / 2);
  fit.first_layer = fit.shallow_layer = static_cast<int>(std::min(first, 1e9 / 2));
  fit.last_layer = fit.first_layer + fit.layer_step * (fit.first_layer / fit.layer_step);
  fit.min_identifiable_width = least_peak_width;
  fit.scaling_window = {mu.front(), mu.back()};
  return fit;
}

class SmallFrictionStudy final : public CopiedStudy<SmallFrictionStudy> {
 public:
  std::string id() const override { return "small_friction"; }

  std::vector<Key> keys() override {
    return {make_key(table(), "mu", "",
                     "friction coefficients followed by the thrust of narrow deep piles; none: not at all", mu_,
                     friction_range_above_zero()),
            make_key(table(), "columns", "beads", "beads per layer of these piles", columns_),
            make_key(table(), "depth", "0.6/mu^2 layers",
                     "their depth in units of that over which the fluctuations saturate", depth_,
                     KeyRange{.why = "above 1 only are the fluctuations of the forces saturated, and more than 1000 "
                                     "show nothing new (4 is usual)"}
                         .within(1, 1000)),
            make_key(table(), "samples", "piles", "piles per friction coefficient, at least eight per block", samples_),
            make_key(table(), "peaks_mu", "",
                     "friction coefficients, three or more, at which c and D of the peaks are measured too, by the "
                     "linear response (multiplexed, each pile and its opposite) of piles deep enough for the smallest; "
                     "none: not at all",
                     peaks_mu_, friction_range_above_zero()),
            make_key(table(), "peaks_samples", "pairs", "pairs of these piles per friction coefficient", peaks_samples_,
                     KeyRange{.why = "eight blocks of eight are the fewest that give a standard error"}.within(
                         group_size * min_blocks, most_samples))};
  }

  bool asked() const override { return !mu_.empty() || !peaks_mu_.empty(); }

  Problem find_problem(const MainLine& main) const override {
    for (const double mu : mu_) {
      if (auto found = find_lattice_problem(key("columns"), columns_, key("mu"), layers(mu), 2 * bottom_margin,
                                            pile_memory(columns_, layers(mu)))) {
        return found;
      }
    }
    if (!peaks_mu_.empty()) {
      const FitSpec window = peak_window(peaks_mu_);
      if (peaks_mu_.size() < 3 || window.last_layer - window.first_layer < 2 * window.layer_step) {
        return problem(key("peaks_mu"),
                       "exponents need three friction coefficients or more, and three depths at which the peaks of the "
                       "smallest are wide enough; give three or more, the smallest below 0.19");
      }
      if (auto found = find_lattice_problem(key("peaks_mu"), main.lattice.columns, key("peaks_mu"), window.last_layer,
                                            2 * bottom_margin, 0)) {
        return found;
      }
      const EnsembleSpec deep = peaks_spec(main, peaks_mu_.front());
      if (auto found = find_lattice_problem(key("peaks_mu"), deep.lattice.columns, key("peaks_mu"), deep.lattice.layers,
                                            2 * bottom_margin, drawing_memory(deep))) {
        return found;
      }
    }
    return mu_.empty() ? Problem() : find_samples_problem(key("samples"), samples_, main.response.blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const double mu : mu_) {
      EnsembleSpec spec = main.ensemble_at(mu, {columns_, layers(mu)}, samples_);
      spec.load = Load::uniform;
      spec.layers = thrust_layers(spec.lattice.layers);
      spec.record_profiles = false;
      all.push_back({fmt::format("small friction, mu = {}", mu), fmt::format("small-friction-mu-{}", exact(mu)), spec});
    }
    for (const double mu : peaks_mu_) {
      all.push_back({fmt::format("peaks at small friction, mu = {}", mu),
                     fmt::format("small-friction-peaks-mu-{}", exact(mu)), peaks_spec(main, mu), 1});
    }
    return all;
  }

  void add(const StudyEnsemble& one, const MeasuredEnsemble& ensemble) override {
    if (one.part == 1) {
      peaks_.push_back(measure_transport(ensemble, peak_window(peaks_mu_), {}, threads_));
      return;
    }
    replicated_.push_back(measure_small_friction(ensemble));
    measured_.push_back(replicated_.back().result);
  }

  void finish() override {
    scaling_ = fit_small_friction(replicated_);
    if (!peaks_.empty()) peaks_scaling_ = fit_scaling(peaks_, peak_window(peaks_mu_).scaling_window);
  }

  std::vector<OtherReading> readings() const override {
    if (peaks_.empty()) return {};
    OtherReading reading{"small_friction", "small friction", {}, peaks_scaling_};
    for (const MeasuredTransport& one : peaks_) {
      reading.points.push_back({one.transport.scanned(), one.transport.c, one.transport.D});
    }
    return {reading};
  }

  Json json() const override {
    Json json = {{"piles", measured_}};
    if (!measured_.empty()) {
      json["exponent"] = scaling_.exponent;
      json["exponent"]["window"] = scaling_.window;
      json["exponent"]["points"] = scaling_.points;
      json["exponent"]["running"] = scaling_.running;
    }
    for (const MeasuredTransport& one : peaks_) {
      const Transport& t = one.transport;
      const double mu = t.scanned();
      const auto slowing = [mu](double c) { return (tan30 - c) / (mu * mu); };
      json["peaks"].push_back(
          {{"mu", mu},
           {"columns", t.spec.lattice.columns},
           {"layers", t.spec.lattice.layers},
           {"samples", t.samples},
           {"window_layers", t.window_layers},
           {"c", t.c},
           {"D", t.D},
           {"c_thrust", t.c_thrust},
           {"slowing_over_mu_squared",
            t.c.known() ? Estimate{slowing(t.c.value), t.c.standard_error / mu / mu, ""} : t.c},
           {"thrust_slowing_over_mu_squared",
            t.c_thrust.known() ? Estimate{slowing(t.c_thrust.value), t.c_thrust.standard_error / mu / mu, ""}
                               : t.c_thrust}});
    }
    return json;
  }

  std::vector<ReportPart> parts() const override {
    if (peaks_.empty()) return {};
    return {{.page = "studies/small_friction.table", .base = "/studies/small_friction", .needs = "peaks"}};
  }

  std::vector<FigurePlot> figures(const Analysis& main) const override {
    if (measured_.empty()) return {};
    return {[this, &main](const fs::path& folder) { return plot_small_friction(main, measured_, scaling_, folder); }};
  }

 private:
  /// Far more than any pile may have stays a number, which the check then refuses.
  int layers(double mu) const {
    return static_cast<int>(std::min(std::ceil(depth_ * saturation_layers(mu)) + bottom_margin, 2e9));
  }

  EnsembleSpec peaks_spec(const MainLine& main, double mu) const {
    const FitSpec fit = peak_window(peaks_mu_);
    constexpr double room = 1.05;  // for the width of the two peaks, which must stay apart
    const double reach =
        std::max(room * 2 * tan30 * Lattice::depth(fit.last_layer), columns_needed(peaks_mu_.back(), fit.last_layer));
    EnsembleSpec spec = main.ensemble_at(
        mu, {20 * static_cast<int>(std::ceil(reach / 20)), fit.last_layer + bottom_margin + 1}, peaks_samples_);
    spec.response = multiplexed_response(main.response.epsilon, true);
    spec.response.samples = peaks_samples_;
    spec.response.blocks = static_cast<int>(
        std::min<std::uint64_t>(static_cast<std::uint64_t>(main.response.blocks), peaks_samples_ / group_size));
    spec.layers = layers_to_record(fit, {});
    return spec;
  }

  std::vector<double> mu_;  ///< each above 0; empty: not measured
  int columns_ = 64;
  double depth_ = 4;             ///< in units of the saturation depth of 0.6/mu^2 layers
  std::uint64_t samples_ = 512;  ///< piles per friction coefficient
  std::vector<MeasuredSmallFriction> replicated_;
  std::vector<SmallFriction> measured_;  ///< ascending in mu
  ScalingFit scaling_;                   ///< tan30 - c_thrust against mu, over all of them
  std::vector<double> peaks_mu_;         ///< likewise, of the peaks
  std::uint64_t peaks_samples_ = 64;
  std::vector<MeasuredTransport> peaks_;
  ScalingFits peaks_scaling_;
};

}  // namespace

std::unique_ptr<Study> small_friction_study() { return std::make_unique<SmallFrictionStudy>(); }

}  // namespace granuscope
