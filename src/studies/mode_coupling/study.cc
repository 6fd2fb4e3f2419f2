#include "studies/mode_coupling/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/claims.h"
#include "ensemble/estimator.h"
#include "ensemble/fluctuation_estimator.h"
#include "model/lattice.h"
#include "report/clean_json.h"
#include "studies/mode_coupling/figures.h"
#include "studies/mode_coupling/measure.h"
#include "studies/study.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

using Json = nlohmann::ordered_json;

constexpr int least_octaves = 3, most_octaves = 9;
/// Tolerance of the claim. Of the class whose W^2 is known exactly, 0.5105 (lambda z)^(4/3), the one-loop equation has
/// 0.455: what it is off by in W^2 is 1.19 in the strength of the coupling.
constexpr double most_amiss = 0.2;
constexpr std::size_t least_lines = 3;  ///< beside the upright load: an even fit of fourth order, tested
/// Piles under such loads: bases, and how much deeper they are looked at once more.
constexpr int loaded_bases = 50, loaded_lag = 512;
/// Beads per layer of those piles, and of those whose fluctuations are measured: no peak crosses them.
constexpr int narrow = 512;

enum Part { deep, leaning, turned, wide, loads, wide_loaded };

}  // namespace

void to_json(Json& json, const LoadedPiles& one) {
  json = {{"load_angle", one.spec.sampler.load_angle},
          {"slope", one.line.slope},
          {"load_offset", one.line.offset},
          {"thrust_ratio", estimate(one.thrust)},
          {"thrust_ratio_deeper", estimate(one.thrust_below)},
          {"deeper_less_here", difference_of(one.thrust_below, one.thrust)}};
}

namespace {

/// What the thrust is at twice the width, less what it is under the same load here.
Json wide_json(const LoadedPiles& one, const CoupledSpreading& all) {
  Json json = one;
  const LoadedPiles& here = one.line.slope > 0 ? all.leaning.back() : all.turned.back();
  json["wide_less_here"] = difference_of(one.thrust, here.thrust);
  return json;
}

}  // namespace

void to_json(Json& json, const SaturatingSpectrum& one) {
  Json bands = Json::array();
  for (const BandOfFluctuations& band : one.bands) {
    bands.push_back({{"k", band.k},
                     {"band", {band.k_from, band.k_to}},
                     {"modes", band.modes},
                     {"C_w", estimate(band.of_w)},
                     {"C_H", estimate(band.of_H)},
                     {"saturation", band.saturation}});
  }
  json = {{"layer", one.layer}, {"z", one.z}, {"bands", bands}};
}

void to_json(Json& json, const ThrustCurvature& one) {
  json = {{"at_zero", one.at_zero},
          {"curvature", one.curvature},
          {"curvature_deeper_less_here", one.curvature_change},
          {"about_form", one.test}};
}

void to_json(Json& json, const ThrustInBlocks& one) {
  json = {{"beads", one.beads}, {"by_slope", estimate(one.by_slope)}, {"by_torque", estimate(one.by_torque)}};
}

void to_json(Json& json, const PeakShapeTest& test) {
  json = {{"z", test.z},
          {"degrees_of_freedom", test.degrees_of_freedom},
          {"chi2_gaussian", finite_or_null(test.gaussian)},
          {"chi2_kpz", finite_or_null(test.kpz)},
          {"chi2_mode_coupling", finite_or_null(test.coupled)}};
}

namespace {

Json predicted_json(const PredictedSpreading& one, const DeepResponse& response) {
  if (one.width_squared.empty()) return nullptr;
  Json lags = Json::array(), octaves = Json::array(), bands = Json::array();
  for (std::size_t i = 0; i < one.D_of_bands.size(); ++i)
    bands.push_back({{"k", response.bands[i].k}, {"D", one.D_of_bands[i]}});
  for (std::size_t i = 0; i < one.width_squared.size(); ++i) {
    const Estimate width{one.width_squared[i], one.width_squared_error[i], {}};
    lags.push_back({{"z", response.lags[i].z}, {"width_squared", width}});
  }
  for (std::size_t i = 0; i < one.c.size(); ++i) {
    const double from = response.lags[i].z, to = response.lags[i + 1].z;
    const double D = (one.width_squared[i + 1] - one.width_squared[i]) / (to - from);
    const double exponent = std::log2(one.width_squared[i + 1] / one.width_squared[i]);
    octaves.push_back({{"z", {from, to}}, {"exponent", exponent}, {"c", one.c[i]}, {"D", D}});
  }
  return {{"D_without_coupling", one.D},
          {"lags", lags},
          {"octaves", octaves},
          {"dispersion", bands},
          {"chi2", finite_or_null(one.chi2)},
          {"octaves_predicted", one.c.size() - 1}};
}

}  // namespace

void to_json(Json& json, const StrengthFit& fit) {
  json = {{"strength", fit.strength},
          {"D", fit.D},
          {"chi2", finite_or_null(fit.chi2)},
          {"degrees_of_freedom", fit.degrees_of_freedom}};
}

void to_json(Json& json, const CheckedSpreading& one) {
  json = {{"response", one.response},
          {"predicted", predicted_json(one.predicted, one.response)},
          {"diffusion_chi2", finite_or_null(one.fit.diffusion_chi2)},
          {"fit", one.fit}};
}

void to_json(Json& json, const CoupledSpreading& one) {
  Json wide_loads = Json::array();
  for (const LoadedPiles& piles : one.twice_as_wide) wide_loads.push_back(wide_json(piles, one));
  json = {{"mu", one.mu},
          {"response", one.response},
          {"leaning", one.leaning},
          {"turned", one.turned},
          {"thrust_largest_change_with_depth", largest_change_with_depth(one)},
          {"thrust_twice_as_wide", wide_loads},
          {"thrust_by_slope", one.by_slope},
          {"thrust_by_torque", one.by_torque},
          {"thrust_in_blocks", one.in_blocks},
          {"plateau",
           {{"layer", one.plateau.layer},
            {"k", {one.plateau.k_from, one.plateau.k_to}},
            {"C_w", one.plateau.of_w},
            {"C_H", one.plateau.of_H},
            {"C_torque", one.plateau.of_torque},
            {"C_H_over_C_w", one.plateau.ratio},
            {"c_thrust_squared", one.plateau.c_thrust_squared}}},
          {"spectra", one.spectra},
          {"saturation",
           {{"points", one.saturation.points},
            {"chi2", finite_or_null(one.saturation.chi2)},
            {"chi2_with_twice_D", finite_or_null(one.saturation.doubled_chi2)}}},
          {"D_torque", one.D_torque},
          {"coupling_to_itself", one.to_itself},
          {"coupling_to_torque", one.to_torque},
          {"predicted", predicted_json(one.predicted, one.response)},
          {"without_torque", predicted_json(one.without_torque, one.response)},
          {"checks", one.checks},
          {"diffusion_chi2", finite_or_null(one.fit.diffusion_chi2)},
          {"fit", one.fit},
          {"shapes", one.shapes}};
}

Json coupling_page_1(const std::vector<CoupledSpreading>& measured) {
  std::vector<std::string> predicted, failed;
  std::size_t octaves = 0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const CoupledSpreading& one = measured[i];
    const Estimate& strength = one.fit.strength;
    if (!strength.known()) continue;
    predicted.push_back(fmt::format("/studies/mode_coupling/{}", i));
    octaves = one.response.octaves.size();
    const bool holds = std::abs(strength.value - 1) < most_amiss + 3 * strength.standard_error &&
                       one.predicted.chi2 < one.without_torque.chi2 && std::isfinite(one.without_torque.chi2);
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
                 "friction coefficients at which the spreading of the peaks is predicted from how the conserved fields "
                 "weight, horizontal force and torque couple, and measured; none: not at all",
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
        make_key(table(), "wide_mu", "",
                 "those of mu that are measured once more with twice the columns, and so is the thrust under the "
                 "largest loads",
                 wide_mu_, friction_range_above_zero()),
        make_key(table(), "loaded_mu", "",
                 "those of mu that are measured once more by loads: estimator multiplexed, each pile and its opposite",
                 loaded_mu_, friction_range_above_zero()),
        loaded_run_key(table(), loaded_run_),
        make_key(table(), "load_angles", "degrees",
                 "angles of leaning loads, which tell how the horizontal force changes the thrust", angles_,
                 KeyRange{.fewest = least_lines, .longest = 12, .ascending = true}.above(0).below(load_angle_limit)),
        make_key(table(), "load_offsets", "bead radii",
                 "how far beside the centres of the top beads loads act, which tells how torque changes the thrust",
                 offsets_, KeyRange{.fewest = least_lines, .longest = 12, .ascending = true}.above(0).within(0, 2)),
        make_key(table(), "loaded_samples", "piles", "piles per such load and friction coefficient", loaded_samples_),
        make_key(table(), "fluctuation_layers", "layers",
                 "layers whose fluctuations are followed, to see where they are saturated", layers_,
                 KeyRange{.fewest = 1, .longest = 12, .ascending = true}.within(1, 100'000)),
        make_key(table(), "fluctuation_samples", "piles", "piles per such layer and friction coefficient",
                 fluctuation_samples_)};
  }

  bool asked() const override { return !mu_.empty(); }

  Problem find_problem(const MainLine& main) const override {
    if (auto found = find_check_problem(key("wide_mu"), wide_mu_, key("mu"), mu_)) return found;
    if (auto found = find_check_problem(key("loaded_mu"), loaded_mu_, key("mu"), mu_)) return found;
    if (auto found = find_run_problem(key("loaded_run"), loaded_run_, columns_)) return found;
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

  double memory() const override { return 2 * pile_memory(narrow, layers_needed(fluctuation_piles(0))); }
  double seconds() const override {
    constexpr double beads_per_second = 1e7, theory = 30;
    const double beads = narrow * static_cast<double>(layers_needed(fluctuation_piles(0)));
    return static_cast<double>(mu_.size()) *
           (theory + static_cast<double>(fluctuation_samples_) * beads / beads_per_second);
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
      if (std::find(wide_mu_.begin(), wide_mu_.end(), mu) != wide_mu_.end()) {
        for (const auto& [angle, offset] : {std::pair(angles_.back(), 0.0), std::pair(0.0, offsets_.back())}) {
          EnsembleSpec spec = loaded_spec(main, mu, angle, offset);
          spec.lattice.columns *= 2;
          const char* name = offset == 0 ? "leaning" : "turned";
          add(fmt::format("largest load {}, twice as wide", name), fmt::format("wide-{}", name), spec, wide_loaded);
        }
      }
      const auto check = [&](const std::vector<double>& checked, DeepMeasurement by, const char* name, Part part) {
        if (std::find(checked.begin(), checked.end(), mu) == checked.end()) return;
        add(fmt::format("spreading {}", name), fmt::format("spreading-{}", name),
            spec_of_check(deep_spec(main, mu), by, main.response.epsilon, loaded_run_), part);
      };
      check(wide_mu_, DeepMeasurement::wide, "wide", wide);
      check(loaded_mu_, DeepMeasurement::loads, "loads", loads);
      // Last of its friction coefficient: add() then has the rest.
      add("spreading", "spreading", deep_spec(main, mu), deep);
    }
    return all;
  }

  void begin(const MainLine& main, int threads) override {
    threads_ = threads;
    sampling_ = main.sampling;
    blocks_ = main.response.blocks;
  }

  void add(const StudyEnsemble& one, const MeasuredEnsemble& ensemble) override {
    if (one.part == leaning) leaning_.push_back(measure_loaded(ensemble));
    if (one.part == turned) turned_.push_back(measure_loaded(ensemble));
    if (one.part == wide_loaded) twice_as_wide_.push_back(measure_loaded(ensemble));
    if (one.part == wide) checks_.push_back(measure_spreading(ensemble, DeepMeasurement::wide, threads_));
    if (one.part == loads) checks_.push_back(measure_spreading(ensemble, DeepMeasurement::loads, threads_));
    if (one.part != deep) return;
    turned_.insert(turned_.begin(), leaning_.front());
    measured_.push_back(measure_coupling(ensemble, std::exchange(leaning_, {}), std::exchange(turned_, {}),
                                         std::exchange(twice_as_wide_, {}),
                                         measure_fluctuations(fluctuation_piles(ensemble.spec.sampler.mu), threads_),
                                         std::exchange(checks_, {}), threads_));
  }

  std::vector<Claim> claims(const ClaimSpec&) const override {
    if (!asked()) return {};
    Claim claim =
        open_claim("mode-coupling", "The peaks spread as the coupling of weight, horizontal force and torque predicts.",
                   "strength of the couplings that the spreading needs, over the predicted one");
    claim.beyond_paper = true;
    const CoupledSpreading* farthest = nullptr;
    double farthest_z = 0;
    std::vector<std::string> all;
    for (const CoupledSpreading& one : measured_) {
      const Estimate& strength = one.fit.strength;
      if (!strength.known()) continue;
      all.push_back(fmt::format("{} at μ = {}", value_with_error(strength.value, strength.standard_error), one.mu));
      const double z = std::abs(strength.value - 1) / strength.standard_error;
      if (farthest != nullptr && z <= farthest_z) continue;
      farthest = &one;
      farthest_z = z;
    }
    if (farthest == nullptr) {
      leave_open(claim, "the strength is not known: give the study more piles");
      return {claim};
    }
    judge_by_number(claim, farthest->fit.strength, {.value = 1, .tolerance = most_amiss}, {},
                    fmt::format("That strength at μ = {}, where it is farthest from 1,", farthest->mu));
    if (all.size() > 1) add_sentence(claim, fmt::format("All of them: {}.", fmt::join(all, ", ")));
    return {claim};
  }

  Json json() const override { return measured_; }
  std::vector<ReportPart> parts() const override {
    const Json told = coupling_page_1(measured_);
    std::vector<ReportPart> all;
    if (!told.is_null()) all.push_back(page_1(told));
    all.push_back(table_part());
    for (const char* table : {"blocks", "checks", "spectra"}) {
      all.push_back({.page = fmt::format("studies/mode_coupling_{}.table", table), .base = "/studies", .needs = id()});
    }
    return all;
  }
  std::vector<FigurePlot> figures(const Analysis&) const override {
    if (measured_.empty()) return {};
    return {[this](const std::filesystem::path& folder) { return plot_predicted_width(measured_, folder); },
            [this](const std::filesystem::path& folder) { return plot_coupling(measured_, folder); },
            [this](const std::filesystem::path& folder) { return plot_spectra(measured_, folder); },
            [this](const std::filesystem::path& folder) { return plot_peak_shape(measured_, folder); }};
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
    spec.lattice.columns = std::min(narrow, columns_);
    spec.layers = {0, loaded_lag};
    spec.lattice.layers = fluctuation_plan(spec).layers_needed + loaded_bases * spec.response.base_step;
    return spec;
  }
  FluctuationPiles fluctuation_piles(double mu) const {
    FluctuationPiles piles{sampling_, std::min(narrow, columns_), layers_, fluctuation_samples_, blocks_};
    piles.sampler.mu = mu;
    return piles;
  }

  std::vector<double> mu_;
  int octaves_ = 5;
  int first_lag_ = usual_first_lag;
  int columns_ = 1536;
  int first_base_ = 0;
  std::uint64_t samples_ = 256;
  std::vector<double> wide_mu_, loaded_mu_;  ///< of those in mu_
  int loaded_run_ = 1;
  std::vector<double> angles_{2, 4, 6, 8, 10};
  std::vector<double> offsets_{0.03, 0.06, 0.09, 0.12};
  std::uint64_t loaded_samples_ = 256;
  std::vector<int> layers_{64, 256, 1024};
  std::uint64_t fluctuation_samples_ = 256;
  int threads_ = 0;
  SamplerSpec sampling_;
  int blocks_ = 0;
  std::vector<LoadedPiles> leaning_, turned_, twice_as_wide_;
  std::vector<DeepResponse> checks_;  ///< and these of the friction coefficient at work
  std::vector<CoupledSpreading> measured_;
};

}  // namespace

std::unique_ptr<Study> mode_coupling_study() { return std::make_unique<ModeCouplingStudy>(); }

}  // namespace granuscope
