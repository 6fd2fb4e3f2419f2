#include "studies/deep_response.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/double_gaussian.h"
#include "ensemble/estimator.h"
#include "ensemble/fluctuation_estimator.h"
#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/gnuplot.h"
#include "plot/plot.h"
#include "studies/study.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr int least_octaves = 3, most_octaves = 11;

/// Error of a D that is shown, relative to the D of the peaks in the first octave.
constexpr double noisiest = 0.25;

/// Columns 1, `value` and `value` + 1 of a data file; y errors are one standard error.
void add_curve(Panel& panel, const std::string& file, int value, const Ink& ink, int dash) {
  panel.add(file, fmt::format("1:{}", value), ink.line(0.8, dash));
  panel.add(file, fmt::format("1:{}:{}", value, value + 1), ink.bars(0.9, 0.55));
}

void reach(Range& range, const Estimate& one) { range.add(one.value, one.standard_error); }

/// Lines of checks are dashed.
int dashes(DeepMeasurement by) { return by == DeepMeasurement::fluctuations ? 0 : by == DeepMeasurement::wide ? 2 : 3; }

std::string data_name(const DeepResponse& one) {
  const char* const check = one.by == DeepMeasurement::fluctuations ? ""
                            : one.by == DeepMeasurement::wide       ? "wide-"
                                                                    : "loads-";
  return fmt::format("{}mu-{}", check, exact(one.spec.sampler.mu));
}

/// The key of the curves: one a friction coefficient, one for each kind of check.
class CurveKey {
 public:
  Ink ink_of(const DeepResponse& one) {
    const auto [at, first] = inks_.try_emplace(one.spec.sampler.mu, ink_of_value(inks_.size()));
    if (first) entries_.push_back({"μ = " + caption_number(one.spec.sampler.mu), at->second.joined(0.9, 0.55)});
    if (one.by != DeepMeasurement::fluctuations) checks_.insert(one.by);
    return at->second;
  }
  bool empty() const { return entries_.empty(); }
  PlotKey key() const {
    PlotKey key;
    key.entries = entries_;
    for (const DeepMeasurement by : checks_) {
      key.entries.push_back({by == DeepMeasurement::wide ? "twice the columns" : "by loads (multiplexed)",
                             {.width = 0.9, .dash = dashes(by)}});
    }
    key.lines = static_cast<int>(key.entries.size() + 2) / 3;
    key.inches = 0.17 * key.lines;
    key.centred = true;
    return key;
  }

 private:
  std::map<double, Ink> inks_;
  std::vector<KeyEntry> entries_;
  std::set<DeepMeasurement> checks_;
};

Wording wording(const std::string& captions, const std::vector<DeepResponse>& measured) {
  const DeepResponse& first = measured.front();
  return {captions,
          {{"columns", std::to_string(first.spec.lattice.columns)},
           {"piles", std::to_string(first.samples)},
           {"deepest", caption_number(std::round(first.octaves.back().to))},
           {"reference", std::to_string(fluctuation_plan(first.spec).reference)}}};
}

}  // namespace

Figure plot_deep_response(const std::vector<DeepResponse>& measured, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "deep-response";
  plot.half_width = true;
  plot.height = 2.15;
  Panel exponents;
  CurveKey key;
  Range depth, exponent;
  exponent.add(1);
  for (const DeepResponse& one : measured) {
    CsvTable table({"z: bead diameters", "exponent: dimensionless", "standard_error: dimensionless",
                    "z_from: bead diameters", "z_to: bead diameters", "c: dimensionless", "c_error: dimensionless",
                    "D: bead diameters", "D_error: bead diameters"});
    for (const OctaveOfDepth& octave : one.octaves) {
      if (!octave.exponent.known()) continue;
      const double z = std::sqrt(octave.from * octave.to);
      table.add_row({z, octave.exponent.value, octave.exponent.standard_error, octave.from, octave.to, octave.c.value,
                     octave.c.standard_error, octave.D.value, octave.D.standard_error});
      depth.add(z);
      reach(exponent, octave.exponent);
    }
    if (table.empty()) continue;
    add_curve(exponents, plot.add_data(data_name(one), table), 2, key.ink_of(one), dashes(one.by));
  }
  if (key.empty())
    throw InputError(
        "the figure of the response with depth has nothing to show: no two lags were fitted; give more piles");
  exponents.name = 0.02;
  exponents.x = log_axis("depth z  (bead diameters)", widened_by_factor(depth, 1.4));
  exponents.y = linear_axis("power of z in W²", widened(exponent, 0.06), 6, exponent);
  exponents.add_level(1, {.width = 0.9, .dash = 4});
  plot.panels = {exponents};
  plot.key = key.key();
  return plot_figure(plot, wording("studies/deep_response.captions", measured), run_folder);
}

Figure plot_dispersion(const std::vector<DeepResponse>& measured, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "dispersion";
  plot.height = 2.6;
  Panel speeds = left_panel(), diffusions = right_panel();
  CurveKey key;
  Range waves, speed, diffusion;
  speed.add(0);
  for (const DeepResponse& one : measured) {
    CsvTable table({"k: 1/bead diameter", "D: bead diameters", "D_error: bead diameters",
                    "c_minus_c_thrust: dimensionless", "c_error: dimensionless", "c: dimensionless",
                    "k_from: 1/bead diameter", "k_to: 1/bead diameter", "z_from: bead diameters",
                    "z_to: bead diameters"});
    for (const BandOfModes& band : one.bands) {
      // A logarithmic axis shows positive numbers only: to leave out the others of a noisy band would be a choice.
      if (!(band.D.standard_error < noisiest * one.octaves.front().D.value) || !(band.D.value > 0)) continue;
      const Estimate above{band.c.value - one.c_thrust.value, band.c.standard_error, ""};
      table.add_row({band.k, band.D.value, band.D.standard_error, above.value, above.standard_error, band.c.value,
                     band.k_from, band.k_to, band.z_from, band.z_to});
      waves.add(band.k);
      reach(diffusion, band.D);
      reach(speed, above);
    }
    if (table.empty()) continue;
    const std::string file = plot.add_data(data_name(one), table);
    const Ink ink = key.ink_of(one);
    add_curve(diffusions, file, 2, ink, dashes(one.by));
    add_curve(speeds, file, 4, ink, dashes(one.by));
  }
  if (key.empty())
    throw InputError(
        "the figure of the dispersion relation has nothing to show: no band of modes was fitted; give more piles");
  const Range axis = widened_by_factor(waves, 1.3), D_axis = widened_by_factor(diffusion, 1.3);
  speeds.x = diffusions.x = log_axis("wave number k  (1/bead diameter)", axis);
  speeds.y = linear_axis("c(k) − c₀√κ", widened(speed, 0.06), 6, speed);
  diffusions.y = log_axis("D(k)", D_axis);
  const Style guide{.width = 0.9, .dash = 4};
  speeds.add_level(0, {.colour = "frame", .width = 0.8});
  diffusions.curves.insert(diffusions.curves.begin(),
                           {"", "", fmt::format("{} * sqrt({} / $1)", exact(0.5 * D_axis.high), exact(axis.low)),
                            axis.low, axis.high, guide});
  plot.panels = {speeds, diffusions};
  plot.key = key.key();
  return plot_figure(plot, wording("studies/dispersion.captions", measured), run_folder);
}

using Json = nlohmann::ordered_json;

namespace {

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
                 "doublings of the depth, from first_lag on; 5 reach 1024 layers, z = 887", octaves_,
                 KeyRange{}.within(least_octaves, most_octaves)),
        first_lag_key(table(), first_lag_),
        make_key(table(), "columns", "beads",
                 "beads per layer of these piles: six widths of a peak or more; under loads twelve, so that the two "
                 "are apart at each depth",
                 columns_),
        make_key(table(), "reference_lag", "layers",
                 "layers from a base layer down to the reference layer, from which the lags count", reference_lag_,
                 KeyRange{}.within(0, most_reference_lag)),
        make_key(table(), "first_base", "layer",
                 "shallowest base layer; 0: where short waves are saturated, 0.6/mu^2, at least 60 and at most 2000",
                 first_base_, KeyRange{}.within(0, most_first_base)),
        make_key(table(), "base_step", "layers", "distance of the base layers", base_step_,
                 KeyRange{}.within(1, most_base_step)),
        make_key(table(), "samples", "piles", "piles per friction coefficient, at least eight per block", samples_),
        make_key(table(), "wide_mu", "", "those of mu that are measured once more with twice the columns", wide_mu_,
                 friction_range_above_zero()),
        make_key(table(), "loaded_mu", "",
                 "those of mu that are measured once more by loads: estimator multiplexed, each pile and its opposite",
                 loaded_mu_, friction_range_above_zero()),
        make_key(table(), "loaded_samples", "pairs",
                 "pairs of piles per friction coefficient of those by loads, which know less from each; 0: samples",
                 loaded_samples_),
        loaded_run_key(table(), loaded_run_)};
  }

  bool asked() const override { return !mu_.empty(); }

  Problem find_problem(const MainLine& main) const override {
    if (auto found = find_check_problem(key("wide_mu"), wide_mu_, key("mu"), mu_)) return found;
    if (auto found = find_check_problem(key("loaded_mu"), loaded_mu_, key("mu"), mu_)) return found;
    const std::vector<StudyEnsemble> all = ensembles(main);
    const std::vector<int>& lags = all.front().spec.layers;
    if (auto found = find_ring_problem(key("columns"), columns_, loaded_mu_, lags)) return found;
    if (const int least = columns_of_waves(mu_, lags, columns_); least != columns_) {
      return problem(key("columns"),
                     "{} columns: a peak is wider than a sixth of the ring at one of the depths that are measured, so "
                     "that its width could not be told; give {} columns, or another number of octaves",
                     columns_, least);
    }
    for (const StudyEnsemble& one : all) {
      if (auto found = find_lattice_problem(key("columns"), one.spec.lattice.columns, key("octaves"),
                                            one.spec.lattice.layers, bottom_margin + 1, drawing_memory(one.spec))) {
        return found;
      }
    }
    if (auto found = find_samples_problem(key("samples"), samples_, main.response.blocks)) return found;
    if (auto found = find_run_problem(key("loaded_run"), loaded_run_, columns_)) return found;
    return loaded_samples_ == 0 ? Problem()
                                : find_samples_problem(key("loaded_samples"), loaded_samples_, main.response.blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    const auto add = [&](DeepMeasurement by, const std::vector<double>& mu, const char* label, const char* file) {
      for (const double one : mu) {
        all.push_back({fmt::format("deep response{}, mu = {}", label, one),
                       fmt::format("deep-response{}-mu-{}", file, exact(one)), spec_at(main, by, one),
                       static_cast<int>(by)});
      }
    };
    add(DeepMeasurement::fluctuations, mu_, "", "");
    add(DeepMeasurement::wide, wide_mu_, " in wide piles", "-wide");
    add(DeepMeasurement::loads, loaded_mu_, " to loads", "-loads");
    return all;
  }

  void begin(const MainLine&, int threads) override { threads_ = threads; }
  void add(const StudyEnsemble& one, const MeasuredEnsemble& ensemble) override {
    measured_.push_back(measure_spreading(ensemble, static_cast<DeepMeasurement>(one.part), threads_));
  }

  void finish() override {
    std::ranges::stable_sort(
        measured_, [](const DeepResponse& a, const DeepResponse& b) { return a.spec.sampler.mu < b.spec.sampler.mu; });
  }

  std::vector<Claim> claims(const ClaimSpec& spec) const override {
    return asked() ? judge_spreading(measured_, spec) : std::vector<Claim>();
  }
  Json json() const override { return measured_; }
  std::vector<ReportPart> parts() const override {
    const Json told = spreading_page_1(measured_, "/studies/" + id());
    return told.is_null() ? std::vector{table_part()} : std::vector{page_1(told), table_part()};
  }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    if (measured_.empty()) return {};
    return {[this](const std::filesystem::path& folder) { return plot_deep_response(measured_, folder); },
            [this](const std::filesystem::path& folder) { return plot_dispersion(measured_, folder); }};
  }

 private:
  EnsembleSpec spec_at(const MainLine& main, DeepMeasurement by, double mu) const {
    const bool other = by == DeepMeasurement::loads && loaded_samples_ > 0;
    EnsembleSpec piles = main.ensemble_at(mu, {columns_, 1}, other ? loaded_samples_ : samples_);
    if (by != DeepMeasurement::loads) {
      piles.response.reference_lag = reference_lag_;
      piles.response.first_base = first_base_;
      piles.response.base_step = base_step_;
    }
    return spec_of_check(spec_of_lags(piles, first_lag_, octaves_), by, main.response.epsilon, loaded_run_);
  }

  std::vector<double> mu_;                   ///< each above 0; empty: not measured
  std::vector<double> wide_mu_, loaded_mu_;  ///< of those in mu_
  int octaves_ = 4;
  int first_lag_ = usual_first_lag;
  int columns_ = 720;
  int reference_lag_ = ResponseSpec().reference_lag, first_base_ = 0, base_step_ = ResponseSpec().base_step;
  std::uint64_t samples_ = 256;  ///< piles per friction coefficient
  std::uint64_t loaded_samples_ = 0;
  int loaded_run_ = 1;
  int threads_ = 0;
  std::vector<DeepResponse> measured_;  ///< ascending in mu, checks behind what they check
};

}  // namespace

std::unique_ptr<Study> deep_response_study() { return std::make_unique<DeepResponseStudy>(); }

}  // namespace granuscope
