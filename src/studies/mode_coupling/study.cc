#include <fmt/ranges.h>

#include <numbers>

#include "analysis/claims.h"
#include "ensemble/estimator.h"
#include "plot/plot.h"
#include "studies/mode_coupling/fields.h"
#include "studies/study.h"

namespace granuscope {
namespace {
constexpr int line_steps = 40;
constexpr double most_error_shown = 0.25;

std::string title_of(double mu) { return "μ = " + caption_number(mu); }

std::string said_of(const Estimate& number, double mu) {
  return fmt::format("{} at μ = {}", in_words(number), caption_number(mu));
}

double bell(double x) { return std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi); }

/// W^2/z against z, measured and predicted. Throws InputError where nothing is predicted.
Figure plot_predicted_width(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "predicted-width";
  plot.height = 3.6;
  plot.key = {.inches = 0.55, .lines = 2, .centred = true, .entries = {}};
  Panel panel;
  std::vector<std::string> ratios;
  Range z, spreading;
  for (const CoupledSpreading& one : measured) {
    const std::vector<double>& predicted = one.predicted.width_squared;
    if (predicted.empty()) continue;
    CsvTable table({"z: bead diameters", "measured: bead diameters", "standard_error: bead diameters",
                    "predicted: bead diameters", "by_waves: bead diameters"});
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      const LagResponse& lag = one.response.lags[i];
      const double at = lag.z;
      const auto& by_waves = one.from_waves.width_squared;
      table.add_row({at, lag.width_squared.value / at, lag.width_squared.standard_error / at, predicted[i] / at,
                     by_waves.empty() ? std::nan("") : by_waves[i] / at});
      z.add(at);
      spreading.add(lag.width_squared.value / at);
      spreading.add(predicted[i] / at);
    }
    const std::string file = plot.add_data("mu-" + exact(one.mu), table);
    const Ink ink = ink_of_value(plot.key.entries.size());
    panel.add(file, "1:4", ink.line(1.2));
    panel.add(file, "1:5", ink.line(0.8, 2));
    panel.add(file, "1:2:3", ink.bars(0.9, 0.6));
    plot.add_key(title_of(one.mu), ink.points(0.6));
    if (one.strength.known()) ratios.push_back(said_of(one.strength, one.mu));
  }
  if (panel.curves.empty()) {
    throw InputError(
        "the figure of the predicted widths has nothing to show: the response is not known at every lag of any "
        "friction coefficient; give the study more piles");
  }
  plot.add_key("predicted", {.width = 1.2});
  plot.add_key("from D(k)", {.width = 0.8, .dash = 2});
  panel.x = log_axis("depth z  (bead diameters)", widened_by_factor(z, 1.4));
  panel.y = log_axis("W²/z  (bead diameters)", widened_by_factor(spreading, 1.3));
  plot.panels = {panel};
  return plot_figure(plot,
                     {"studies/predicted_width.captions",
                      {{"strengths", enumeration(ratios)},
                       {"first", caption_number(std::round(z.low))},
                       {"deepest", caption_number(std::round(z.high))},
                       {"piles", std::to_string(measured.front().response.samples)}}},
                     run_folder);
}

/// D(k) and c(k) - c_thrust of waves, beside the form. Throws InputError where nothing is known of waves.
Figure plot_waves(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "waves-of-sound";
  plot.height = 3;
  plot.key = {.inches = 0.55, .lines = 2, .centred = true, .entries = {}};
  Panel spreading = left_panel(), speed = right_panel();
  std::vector<std::string> chi2, ratios;
  Range k, diffusion, faster;
  faster.add(0);
  for (const CoupledSpreading& one : measured) {
    if (!one.of_waves.B.known()) continue;
    const double D = one.of_waves.D.value, B = one.of_waves.B.value;
    CsvTable table({"k: 1/bead diameter", "D: bead diameters", "standard_error: bead diameters",
                    "c_less_c_thrust: dimensionless", "standard_error: dimensionless"});
    Range waves;
    for (const BandOfModes& band : one.response.bands) {
      if (!band.D.known() || !band.c.known() || band.D.standard_error > most_error_shown * band.D.value) continue;
      const double ahead = band.c.value - one.response.c_thrust.value;
      table.add_row({band.k, band.D.value, band.D.standard_error, ahead, band.c.standard_error});
      waves.add(band.k);
      diffusion.add(band.D.value, band.D.standard_error);
      faster.add(ahead, band.c.standard_error);
    }
    if (table.empty()) continue;
    CsvTable form({"k: 1/bead diameter", "D: bead diameters", "c_less_c_thrust: dimensionless"});
    for (int step = 0; step <= line_steps; ++step) {
      const double at = waves.low * std::pow(waves.high / waves.low, static_cast<double>(step) / line_steps);
      form.add_row({at, D + 2 * B / std::sqrt(at), B * std::sqrt(at)});
      faster.add(B * std::sqrt(at));
    }
    k.add(waves.low);
    k.add(waves.high);
    const std::string file = plot.add_data("mu-" + exact(one.mu), table),
                      line = plot.add_data("form-mu-" + exact(one.mu), form);
    const Ink ink = ink_of_value(plot.key.entries.size());
    spreading.add(line, "1:2", ink.line(1));
    spreading.add(file, "1:2:3", ink.bars(0.8, 0.5));
    speed.add(line, "1:3", ink.line(1));
    speed.add(file, "1:4:5", ink.bars(0.8, 0.5));
    plot.add_key(title_of(one.mu), ink.points(0.6));
    chi2.push_back(
        fmt::format("{:.1f}/{} at μ = {}", one.of_waves.chi2, one.of_waves.degrees_of_freedom, caption_number(one.mu)));
    if (one.speeds.ratio.known()) ratios.push_back(said_of(one.speeds.ratio, one.mu));
  }
  if (plot.key.entries.empty()) {
    throw InputError(
        "the figure of the waves has nothing to show: no diffusion coefficient is known of waves of one length; give "
        "the study more piles");
  }
  plot.add_key("D + 2 B k^{−1/2}, B k^{1/2}", {.width = 1});
  spreading.x = speed.x = log_axis("wave number k  (1/bead diameter)", widened_by_factor(k, 1.2));
  spreading.y = log_axis("D(k)  (bead diameters)", widened_by_factor(diffusion, 1.3));
  speed.y = linear_axis("c(k) − c₀√κ", widened(faster, 0.06), 6, faster);
  plot.panels = {spreading, speed};
  return plot_figure(
      plot, {"studies/waves_of_sound.captions", {{"chi2", enumeration(chi2)}, {"ratios", enumeration(ratios)}}},
      run_folder);
}

/// The right peak at several depths, each scaled by its own width, beside a Gaussian, the shape of the class and the
/// form. Throws InputError where no shape is known.
Figure plot_peak_shape(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "peak-shape";
  plot.height = 3;
  plot.key = {.inches = 0.55, .lines = 2, .centred = true, .entries = {}};
  const auto shown =
      std::find_if(measured.rbegin(), measured.rend(), [](const auto& one) { return !one.peaks.empty(); });
  if (shown == measured.rend()) {
    throw InputError(
        "the figure of the peaks' shape has nothing to show: the response is not known at every lag; give it "
        "more piles");
  }
  const double root = std::sqrt(kpz_peak().variance);
  const Style gaussian{.width = 0.9, .dash = 3}, kpz{.width = 0.9, .dash = 2}, levy{.width = 1.3};
  Panel heights = left_panel(), excess = right_panel();
  Range difference;
  CsvTable shapes({"x: widths", "gaussian: dimensionless", "kpz: dimensionless"});
  const auto entries = static_cast<std::ptrdiff_t>(kpz_peak().density.size());
  for (std::ptrdiff_t i = 1 - entries; i < entries; ++i) {
    const double x = KpzPeak::step * static_cast<double>(i) / root;
    const double height = root * kpz_peak().density[static_cast<std::size_t>(std::abs(i))];
    if (std::abs(x) > 4) continue;
    shapes.add_row({x, bell(x), height});
    difference.add(height - bell(x));
  }
  const std::string theory = plot.add_data("theory", shapes);
  heights.add(theory, "1:2", gaussian);
  heights.add(theory, "1:3", kpz);
  excess.add(theory, "1:(0)", gaussian);
  excess.add(theory, "1:($3-$2)", kpz);
  std::vector<std::string> words;
  for (std::size_t i = 0; i < shown->peaks.size(); ++i) {
    const ScaledPeak& peak = shown->peaks[i];
    CsvTable table(
        {"x: widths", "height: dimensionless", "standard_error: dimensionless", "above_gaussian: dimensionless"});
    double next = -100;
    for (std::size_t j = 0; j < peak.x.size(); ++j) {
      const double x = peak.x[j];
      if (x < next) continue;
      next = x + 0.16;
      const double above = peak.height[j].value - bell(x);
      table.add_row({x, peak.height[j].value, peak.height[j].standard_error, above});
      difference.add(above, peak.height[j].standard_error);
    }
    const std::string file = plot.add_data(std::to_string(i + 1), table);
    const Ink ink = ink_of_value(i);
    heights.add(file, "1:2", ink.points(0.4));
    excess.add(file, "1:4:3", ink.bars(0.7, 0.4));
    plot.add_key(fmt::format("z = {:.0f}", peak.z), ink.points(0.6));
    const PeakShapeTest& test = shown->shapes[i];
    words.push_back(fmt::format("{:.0f}, {:.0f} and {:.0f} at z = {:.0f}", test.gaussian, test.kpz, test.levy, test.z));
  }
  const double deepest = shown->peaks.back().z;
  const ScaledPeak form = scaled_peak(shown->form, deepest, shown->response.spec.lattice.columns);
  CsvTable predicted({"x: widths", "height: dimensionless", "above_gaussian: dimensionless"});
  for (std::size_t i = 0; i < form.x.size(); ++i) {
    const double above = form.height[i].value - bell(form.x[i]);
    predicted.add_row({form.x[i], form.height[i].value, above});
    difference.add(above);
  }
  const std::string file = plot.add_data("predicted", predicted);
  heights.add(file, "1:2", levy);
  excess.add(file, "1:3", levy);
  plot.add_key(fmt::format("predicted, z = {:.0f}", deepest), levy);
  plot.add_key("Gaussian", gaussian);
  plot.add_key("KPZ", kpz);
  heights.x = excess.x = {"(x − xₚ)/W", -4, 4, false, {{"−4", -4}, {"−2", -2}, {"0", 0}, {"2", 2}, {"4", 4}}};
  heights.y = linear_axis("2 W P(x)", {-0.02, 0.48, false}, 6);
  excess.y = linear_axis("2 W P − Gaussian", widened(difference, 0.06), 6, difference);
  excess.name = 0.51;
  plot.panels = {heights, excess};
  return plot_figure(plot,
                     {"studies/peak_shape.captions",
                      {{"mu", caption_number(shown->mu)},
                       {"chi2", enumeration(words)},
                       {"degrees", std::to_string(shown->shapes.back().degrees_of_freedom)}}},
                     run_folder);
}

constexpr int least_octaves = 3, most_octaves = 9;
/// Tolerance of the claim: the coupling is that of one loop, which in the class of Kardar, Parisi and Zhang, where W^2
/// is known exactly, 0.5105 (lambda z)^(4/3), has 0.455: 1.19 in the strength.
constexpr double most_amiss = 0.2;
constexpr std::size_t least_lines = 3;  ///< beside the upright load: an even fit of fourth order, tested
constexpr int loaded_bases = 50;        ///< of piles under such loads
/// Beads per layer of those piles, and of those whose fluctuations are measured: no peak crosses them.
constexpr int narrow_columns = 512;

enum Part { deep, leaning, turned };

}  // namespace

void to_json(Json& json, const LoadedPiles& one) {
  json = {{"load_angle", one.spec.sampler.load_angle},
          {"slope", one.line.slope},
          {"load_offset", one.line.offset},
          {"thrust_ratio", estimate(one.thrust)}};
}

void to_json(Json& json, const ThrustCurvature& one) {
  json = {{"at_zero", one.at_zero}, {"curvature", one.curvature}, {"about_form", one.test}};
}

void to_json(Json& json, const FormFit& fit) {
  json = {
      {"D", fit.D}, {"B", fit.B}, {"chi2", finite_or_null(fit.chi2)}, {"degrees_of_freedom", fit.degrees_of_freedom}};
}

void to_json(Json& json, const FormTest& test) {
  json = {{"slopes", test.slopes},
          {"width_squared", test.width_squared},
          {"chi2", finite_or_null(test.chi2)},
          {"octaves", test.octaves}};
}

void to_json(Json& json, const SpeedTest& test) {
  json = {{"ratio", test.ratio},
          {"chi2", finite_or_null(test.chi2)},
          {"chi2_of_none", finite_or_null(test.chi2_of_none)},
          {"bands", test.bands}};
}

void to_json(Json& json, const CoupledSpreading& one) {
  json = {{"mu", one.mu},
          {"response", one.response},
          {"leaning", one.leaning},
          {"turned", one.turned},
          {"thrust_by_slope", one.by_slope},
          {"thrust_by_torque", one.by_torque},
          {"plateau",
           {{"layer", one.plateau.layer},
            {"k", {one.plateau.k_from, one.plateau.k_to}},
            {"C_w", one.plateau.of_w},
            {"C_H", one.plateau.of_H},
            {"C_torque", one.plateau.of_torque},
            {"C_H_over_C_w", one.plateau.ratio}}},
          {"D_torque", one.D_torque},
          {"coupling_to_itself", one.to_itself},
          {"coupling_to_torque", one.to_torque},
          {"B", one.B},
          {"D_of_first_octave", one.form.D},
          {"predicted", one.predicted},
          {"of_widths", one.of_widths},
          {"strength", one.strength},
          {"of_waves", one.of_waves},
          {"from_waves", one.from_waves},
          {"speeds", one.speeds},
          {"diffusion_chi2", finite_or_null(one.diffusion_chi2)},
          {"shapes", one.shapes}};
}

Json coupling_page_1(const std::vector<CoupledSpreading>& measured) {
  std::vector<std::string> predicted, failed;
  std::size_t octaves = 0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const CoupledSpreading& one = measured[i];
    const Estimate& strength = one.strength;
    if (!strength.known()) continue;
    predicted.push_back(fmt::format("/studies/mode_coupling/{}", i));
    octaves = one.response.octaves.size();
    const bool holds = std::abs(strength.value - 1) < most_amiss + 3 * strength.standard_error &&
                       one.predicted.chi2 < one.diffusion_chi2;
    if (!holds) failed.push_back(predicted.back());
  }
  if (predicted.empty()) return nullptr;
  const bool some = failed.size() < predicted.size();
  const std::string first = predicted.front();
  return {{"explained", some},
          {"fails_somewhere", some && !failed.empty()},
          {"failed", enumerated(failed)},
          {"predictions", enumerated(predicted)},
          {"any", {{"key", first}}},
          {"first", {{"key", first + "/response/octaves/0"}}},
          {"last", {{"key", fmt::format("{}/response/octaves/{}", first, octaves - 1)}}}};
}

namespace {

class ModeCouplingStudy final : public CopiedStudy<ModeCouplingStudy> {
 public:
  std::string id() const override { return "mode_coupling"; }

  std::vector<Key> keys() override {
    return {
        make_key(table(), "mu", "",
                 "friction coefficients at which the spreading of the peaks is measured, and predicted as that of "
                 "sound which "
                 "the conserved torque feeds; none: not at all",
                 mu_, friction_range_above_zero()),
        make_key(table(), "octaves", "octaves",
                 "doublings of the depth, from first_lag on; 5 reach 1024 layers, z = 887", octaves_,
                 KeyRange{}.within(least_octaves, most_octaves)),
        first_lag_key(table(), first_lag_),
        make_key(table(), "columns", "beads",
                 "beads per layer of these piles: twelve widths of a peak or more, so that the two are apart at each "
                 "depth",
                 columns_),
        make_key(table(), "samples", "piles", "piles per friction coefficient, at least eight per block", samples_),
        make_key(table(), "first_base", "layer",
                 "shallowest layer from which the response is followed; 0: where short waves are saturated, 0.6/mu^2, "
                 "at least 60 and at most 2000",
                 first_base_, KeyRange{}.within(0, most_first_base)),
        make_key(table(), "load_angles", "degrees",
                 "angles of leaning loads, which tell how the horizontal force changes the thrust", angles_,
                 KeyRange{.fewest = least_lines, .longest = 12, .ascending = true}.above(0).below(load_angle_limit)),
        make_key(table(), "load_offsets", "bead radii",
                 "how far beside the centres of the top beads loads act, which tells how torque changes the thrust",
                 offsets_, KeyRange{.fewest = least_lines, .longest = 12, .ascending = true}.above(0).within(0, 2)),
        make_key(table(), "loaded_samples", "piles", "piles per such load and friction coefficient", loaded_samples_),
        make_key(table(), "fluctuation_layer", "layer",
                 "layer from which fluctuations and the spreading of torque are measured, deep enough for waves to be "
                 "saturated",
                 layer_, KeyRange{}.within(1, 100'000)),
        make_key(table(), "fluctuation_samples", "piles",
                 "piles per friction coefficient whose fluctuations are measured", fluctuation_samples_)};
  }

  bool asked() const override { return !mu_.empty(); }

  Problem find_problem(const MainLine& main) const override {
    if (auto found = find_ring_problem(key("columns"), columns_, mu_, deep_spec(main, mu_.front()).layers))
      return found;
    for (const StudyEnsemble& one : ensembles(main)) {
      if (auto found = find_lattice_problem(key("columns"), one.spec.lattice.columns, key("octaves"),
                                            one.spec.lattice.layers, bottom_margin + 1, drawing_memory(one.spec))) {
        return found;
      }
    }
    const int blocks = main.response.blocks;
    for (const auto& [name, samples] : {std::pair("samples", samples_), std::pair("loaded_samples", loaded_samples_),
                                        std::pair("fluctuation_samples", fluctuation_samples_)}) {
      if (auto found = find_samples_problem(key(name), samples, blocks)) return found;
    }
    return {};
  }

  double memory() const override { return 2 * pile_memory(narrow_columns, layers_needed(fluctuation_piles(0))); }
  double seconds() const override {
    constexpr double beads_per_second = 1e7;
    const double beads = narrow_columns * static_cast<double>(layers_needed(fluctuation_piles(0)));
    return static_cast<double>(mu_.size()) * static_cast<double>(fluctuation_samples_) * beads / beads_per_second;
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const double mu : mu_) {
      const auto add = [&](const std::string& label, const std::string& file, EnsembleSpec spec, Part part) {
        all.push_back(
            {fmt::format("{}, mu = {}", label, mu), fmt::format("{}-mu-{}", file, exact(mu)), std::move(spec), part});
      };
      add("upright load", "upright", loaded_spec(main, mu, 0, 0), leaning);
      for (const double angle : angles_) {
        add(fmt::format("load leaning by {} degrees", angle), fmt::format("leaning-{}", exact(angle)),
            loaded_spec(main, mu, angle, 0), leaning);
      }
      for (const double offset : offsets_) {
        add(fmt::format("load {} bead radii beside", offset), fmt::format("turned-{}", exact(offset)),
            loaded_spec(main, mu, 0, offset), turned);
      }
      // Last of its friction coefficient: add() then has the rest.
      add("spreading", "spreading", deep_spec(main, mu), deep);
    }
    return all;
  }

  void add(const StudyEnsemble& one, const MeasuredEnsemble& ensemble) override {
    if (one.part == leaning) leaning_.push_back(measure_loaded(ensemble));
    if (one.part == turned) turned_.push_back(measure_loaded(ensemble));
    if (one.part != deep) return;
    turned_.insert(turned_.begin(), leaning_.front());
    measured_.push_back(measure_coupling(ensemble, std::exchange(leaning_, {}), std::exchange(turned_, {}),
                                         measure_fluctuations(fluctuation_piles(ensemble.spec.sampler.mu), threads_),
                                         threads_));
  }

  std::vector<Claim> claims(const ClaimSpec&) const override {
    if (!asked()) return {};
    Claim claim = open_claim("mode-coupling", "The peaks spread as sound that the conserved torque feeds.",
                             "B that the spreading needs, over that of the coupling to torque");
    claim.beyond_paper = true;
    const CoupledSpreading* farthest = nullptr;
    double farthest_z = 0;
    std::vector<std::string> all;
    for (const CoupledSpreading& one : measured_) {
      const Estimate& strength = one.strength;
      if (!strength.known()) continue;
      all.push_back(said_of(strength, one.mu));
      const double z = std::abs(strength.value - 1) / strength.standard_error;
      if (farthest != nullptr && z <= farthest_z) continue;
      farthest = &one;
      farthest_z = z;
    }
    if (farthest == nullptr) {
      leave_open(claim, "B is not known: give the study more piles");
      return {claim};
    }
    judge_by_number(
        claim, farthest->strength, {.value = 1, .tolerance = most_amiss}, {},
        fmt::format("Measured over predicted strength at μ = {}, where it is farthest from 1,", farthest->mu));
    if (all.size() > 1) add_sentence(claim, fmt::format("All of them: {}.", fmt::join(all, ", ")));
    return {claim};
  }

  Json json() const override { return measured_; }
  std::vector<ReportPart> parts() const override {
    const Json told = coupling_page_1(measured_);
    std::vector<ReportPart> all;
    if (!told.is_null()) all.push_back(page_1(told));
    all.push_back(table_part());
    all.push_back({.page = "studies/mode_coupling_form.table", .base = "/studies", .needs = id()});
    return all;
  }
  std::vector<FigurePlot> figures(const Analysis&) const override {
    return figures_of(measured_, plot_predicted_width, plot_waves, plot_peak_shape);
  }

 private:
  EnsembleSpec fluctuation_spec(const MainLine& main, double mu, std::uint64_t samples) const {
    EnsembleSpec spec = main.ensemble_at(mu, {columns_, 1}, samples);
    spec.response.estimator = EstimatorName::fluctuation;
    spec.response.first_base = first_base_;
    return spec;
  }
  EnsembleSpec deep_spec(const MainLine& main, double mu) const {
    return spec_of_lags(fluctuation_spec(main, mu, samples_), first_lag_, octaves_);
  }
  EnsembleSpec loaded_spec(const MainLine& main, double mu, double angle, double offset) const {
    EnsembleSpec spec = fluctuation_spec(main, mu, loaded_samples_);
    spec.sampler.load_angle = angle;
    spec.sampler.load_offset = offset;
    spec.record_profiles = false;
    spec.lattice.columns = std::min(narrow_columns, columns_);
    spec.layers = {0, usual_first_lag};
    spec.lattice.layers = fluctuation_plan(spec).layers_needed + loaded_bases * spec.response.base_step;
    return spec;
  }
  FluctuationPiles fluctuation_piles(double mu) const {
    FluctuationPiles piles{main_.sampling, std::min(narrow_columns, columns_), layer_, fluctuation_samples_,
                           main_.response.blocks};
    piles.sampler.mu = mu;
    return piles;
  }

  std::vector<double> mu_;
  int octaves_ = 5;
  int first_lag_ = usual_first_lag;
  int columns_ = 1536;
  int first_base_ = 0;
  std::uint64_t samples_ = 256;
  std::vector<double> angles_{2, 4, 6, 8, 10};
  std::vector<double> offsets_{0.03, 0.06, 0.09, 0.12};
  std::uint64_t loaded_samples_ = 256;
  int layer_ = 1024;
  std::uint64_t fluctuation_samples_ = 64;
  std::vector<LoadedPiles> leaning_, turned_;  ///< of the friction coefficient at work
  std::vector<CoupledSpreading> measured_;
};

}  // namespace

std::unique_ptr<Study> mode_coupling_study() { return std::make_unique<ModeCouplingStudy>(); }

}  // namespace granuscope
