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
#include "studies/mode_coupling/fields.h"
#include "studies/mode_coupling/figures.h"
#include "studies/study.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

using Json = nlohmann::ordered_json;

constexpr int least_octaves = 3, most_octaves = 9;
/// Tolerance of the claim: the coupling is that of one loop, which in the class of Kardar, Parisi and Zhang, where W^2
/// is known exactly, 0.5105 (lambda z)^(4/3), has 0.455: 1.19 in the strength.
constexpr double most_amiss = 0.2;
constexpr std::size_t least_lines = 3;  ///< beside the upright load: an even fit of fourth order, tested
constexpr int loaded_bases = 50;        ///< of piles under such loads
/// Beads per layer of those piles, and of those whose fluctuations are measured: no peak crosses them.
constexpr int narrow = 512;

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

void to_json(Json& json, const PeakShapeTest& test) {
  json = {{"z", test.z},
          {"degrees_of_freedom", test.degrees_of_freedom},
          {"chi2_gaussian", finite_or_null(test.gaussian)},
          {"chi2_kpz", finite_or_null(test.kpz)},
          {"chi2_levy", finite_or_null(test.levy)}};
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

  double memory() const override { return 2 * pile_memory(narrow, layers_needed(fluctuation_piles(0))); }
  double seconds() const override {
    constexpr double beads_per_second = 1e7;
    const double beads = narrow * static_cast<double>(layers_needed(fluctuation_piles(0)));
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

  void begin(const MainLine& main, int threads) override {
    threads_ = threads;
    sampling_ = main.sampling;
    blocks_ = main.response.blocks;
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
      all.push_back(fmt::format("{} at μ = {}", value_with_error(strength.value, strength.standard_error), one.mu));
      const double z = std::abs(strength.value - 1) / strength.standard_error;
      if (farthest != nullptr && z <= farthest_z) continue;
      farthest = &one;
      farthest_z = z;
    }
    if (farthest == nullptr) {
      leave_open(claim, "B is not known: give the study more piles");
      return {claim};
    }
    judge_by_number(claim, farthest->strength, {.value = 1, .tolerance = most_amiss}, {},
                    fmt::format("That ratio at μ = {}, where it is farthest from 1,", farthest->mu));
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
    if (measured_.empty()) return {};
    return {[this](const std::filesystem::path& folder) { return plot_predicted_width(measured_, folder); },
            [this](const std::filesystem::path& folder) { return plot_waves(measured_, folder); },
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
    spec.layers = {0, usual_first_lag};
    spec.lattice.layers = fluctuation_plan(spec).layers_needed + loaded_bases * spec.response.base_step;
    return spec;
  }
  FluctuationPiles fluctuation_piles(double mu) const {
    FluctuationPiles piles{sampling_, std::min(narrow, columns_), layer_, fluctuation_samples_, blocks_};
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
  int threads_ = 0;
  SamplerSpec sampling_;
  int blocks_ = 0;
  std::vector<LoadedPiles> leaning_, turned_;  ///< of the friction coefficient at work
  std::vector<CoupledSpreading> measured_;
};

}  // namespace

std::unique_ptr<Study> mode_coupling_study() { return std::make_unique<ModeCouplingStudy>(); }

}  // namespace granuscope
