#include "studies/deep_response.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "analysis/claim_rule.h"
#include "analysis/expected_response.h"
#include "analysis/layer_spectrum.h"
#include "analysis/measured_depth.h"
#include "ensemble/estimator.h"
#include "ensemble/fluctuation_plan.h"
#include "ensemble/parallel.h"
#include "model/lattice.h"
#include "report/estimate_json.h"
#include "studies/common_checks.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

constexpr int least_octaves = 3, most_octaves = 11;
/// Longer than the reference lag: modes that only shorter ones have are drowned in noise.
constexpr int first_lag = 32;
constexpr double least_width = 0.3;  ///< bead diameters
constexpr double most_decay = 0.5;   ///< -ln of the amplitude that is left

int last_lag(int octaves) { return first_lag << octaves; }

/// Each band of modes over the deepest octave of depth at whose end it has kept most of its amplitude: there its decay
/// stands out of the noise. (To take the octave with the least error would favour errors that are small by chance.)
std::vector<BandOfModes> bands_at_their_depths(const BlockSums& sums, const std::vector<OctaveOfDepth>& octaves,
                                               double c_thrust) {
  const std::vector<double> edges = half_octave_bands(sums.quantities.at("propagation").width / 2);
  std::map<double, BandOfModes> bands;  // by lower edge
  for (std::size_t i = 0; i < octaves.size(); ++i) {
    const double D = octaves[i].D.value;
    if (!octaves[i].D.known()) continue;
    for (const BandOfModes& band : measure_dispersion(sums, i + 1, i + 2, edges, {c_thrust, D})) {
      if (!band.c.known() || !band.D.known()) continue;
      if (band.k * band.k * D * band.z_to / 2 < most_decay) {
        bands.insert_or_assign(band.k_from, band);
      } else {
        bands.try_emplace(band.k_from, band);
      }
    }
  }
  std::vector<BandOfModes> all;
  for (const auto& [edge, band] : bands) all.push_back(band);
  return all;
}

}  // namespace

DeepResponse measure_deep_response(const MeasuredEnsemble& ensemble, DeepMeasurement by, int threads) {
  const BlockSums& sums = ensemble.record.sums;
  // Recorded first are the lag 0, which others are referred to, or the loads.
  constexpr std::size_t first = 1;
  DeepResponse response;
  response.by = by;
  response.spec = ensemble.spec;
  response.samples = std::accumulate(sums.count.begin(), sums.count.end(), std::uint64_t{0});
  FitSpec fit;
  fit.min_identifiable_width = least_width;
  std::vector<MeasuredDepth> depths(sums.layers.size() - first);
  for_each_index(depths.size(), threads, [&](std::size_t i) { depths[i] = measure_depth(ensemble, fit, i + first); });
  // Another shape than two Gaussians is told by the misfit, and no reason to be silent.
  const auto reason = [](const MeasuredDepth& depth) { return depth.other_shape ? std::string() : depth.fit.reason; };
  for (const MeasuredDepth& depth : depths) {
    response.lags.push_back({depth.fit.layer, depth.fit.z - Lattice::depth(0), estimate(depth.peak, reason(depth)),
                             estimate(depth.width_squared, reason(depth)), depth.fit.chi2_per_dof, depth.fit.misfit});
  }
  const auto power = [&](std::size_t i, std::size_t j) {
    const MeasuredDepth &above = depths[i], &below = depths[j];
    PowerOfDepth result{response.lags[i].z, response.lags[j].z, {}};
    const double stretch = std::log(result.to / result.from);
    result.exponent.reason = !reason(above).empty() ? reason(above) : reason(below);
    if (!result.exponent.reason.empty()) return result;
    result.exponent = estimate(transform([&](double a, double b) { return std::log(b / a) / stretch; },
                                         above.width_squared, below.width_squared));
    return result;
  };
  for (std::size_t i = 0; i + 1 < depths.size(); ++i) {
    const MeasuredDepth &above = depths[i], &below = depths[i + 1];
    const PowerOfDepth of_width = power(i, i + 1);
    const double from = of_width.from, to = of_width.to;
    OctaveOfDepth octave{from, to, of_width.exponent, {}, {}, std::max(above.fit.misfit, below.fit.misfit)};
    const auto slope = [&](double a, double b) { return (b - a) / (to - from); };
    if (octave.exponent.reason.empty()) {
      octave.c = estimate(transform(slope, above.peak, below.peak));
      octave.D = estimate(transform(slope, above.width_squared, below.width_squared));
    } else {
      octave.c.reason = octave.D.reason = octave.exponent.reason;
    }
    response.octaves.push_back(octave);
  }
  const std::size_t last = depths.size() - 1;
  response.shallow = power(1, 2);
  response.deep = power(std::max<std::size_t>(2, last - 2), last);
  response.c_thrust = estimate(thrust_speed(sums, by == DeepMeasurement::loads ? sums.layers.back() : 0),
                               "a block of the ensemble holds no completed pile");
  if (by != DeepMeasurement::loads && response.c_thrust.known())
    response.bands = bands_at_their_depths(sums, response.octaves, response.c_thrust.value);
  return response;
}

namespace {

/// One stretch of depth, judged at the friction coefficient where the power is farthest from 1.
Claim judge_stretch(const std::vector<DeepResponse>& measured, const ClaimSpec& spec, const char* id,
                    const std::string& where, PowerOfDepth DeepResponse::*stretch) {
  Claim claim =
      open_claim(id, fmt::format("The squared width W² grows linearly with z {}.", where), "power of z in W²");
  const DeepResponse* farthest = nullptr;
  double farthest_z = 0;
  std::vector<std::string> all;
  for (const DeepResponse& one : measured) {
    const Estimate& power = (one.*stretch).exponent;
    if (!power.known() || one.by != DeepMeasurement::fluctuations) continue;
    all.push_back(
        fmt::format("{} at μ = {}", value_with_error(power.value, power.standard_error), one.spec.sampler.mu));
    const double z = std::abs(judge_number(power, 1, spec.exponent_tolerance).z_score);
    if (farthest != nullptr && z <= farthest_z) continue;
    farthest = &one;
    farthest_z = z;
  }
  if (farthest == nullptr) {
    claim.paper = 1;
    claim.paper_error = spec.exponent_tolerance;
    leave_open(claim, "no pile was followed so deep: set studies.deep_response.mu; some minutes decide");
    return claim;
  }
  const PowerOfDepth& power = farthest->*stretch;
  judge_by_number(claim, power.exponent, 1, spec.exponent_tolerance,
                  fmt::format("The power of z in W² from z = {:.0f} to {:.0f} at μ = {}, where it is farthest from 1,",
                              power.from, power.to, farthest->spec.sampler.mu));
  if (all.size() > 1) add_sentence(claim, fmt::format("All of them: {}.", fmt::join(all, ", ")));
  return claim;
}

}  // namespace

std::vector<Claim> judge_spreading(const std::vector<DeepResponse>& measured, const ClaimSpec& spec) {
  return {judge_stretch(measured, spec, "spreading-shallow",
                        "as deep as the paper's piles, saturated ones without a load", &DeepResponse::shallow),
          judge_stretch(measured, spec, "spreading-deep", "much deeper than the paper's piles", &DeepResponse::deep)};
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

Json to_json(const PowerOfDepth& power) {
  return {{"z", {power.from, power.to}}, {"exponent", granuscope::to_json(power.exponent)}};
}

Json to_json(const BandOfModes& band) {
  return {{"k", band.k},
          {"band", {band.k_from, band.k_to}},
          {"modes", band.modes},
          {"z", {band.z_from, band.z_to}},
          {"c", granuscope::to_json(band.c)},
          {"D", granuscope::to_json(band.D)}};
}

Json to_json(const DeepResponse& one) {
  Json json{{"measurement", fmt::format("mu = {}, {}, {} columns", one.spec.sampler.mu,
                                        name_of(one.spec.response.estimator), one.spec.lattice.columns)},
            {"mu", one.spec.sampler.mu},
            {"law", name_of(one.spec.sampler.law)},
            {"estimator", name_of(one.spec.response.estimator)},
            {"columns", one.spec.lattice.columns},
            {"layers", one.spec.lattice.layers},
            {"samples", one.samples}};
  if (one.by != DeepMeasurement::loads) {
    const FluctuationPlan plan = fluctuation_plan(one.spec);
    json["reference_lag"] = plan.reference;
    json["base_layers"] = {plan.bases.front(), plan.bases.back()};
    json["bases"] = plan.bases.size();
  }
  json.update(Json{{"lags", list_of(one.lags, to_json)},
                   {"octaves", list_of(one.octaves, to_json)},
                   {"shallow", to_json(one.shallow)},
                   {"deep", to_json(one.deep)},
                   {"dispersion", list_of(one.bands, to_json)},
                   {"c_thrust", granuscope::to_json(one.c_thrust)}});
  return json;
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
        make_key(table(), "samples", "piles", "piles per friction coefficient, at least eight per block", samples_),
        make_key(table(), "wide_mu", "", "those of mu that are measured once more with twice the columns", wide_mu_,
                 friction_range_above_zero()),
        make_key(table(), "loaded_mu", "",
                 "those of mu that are measured once more by loads: estimator multiplexed, each pile and its opposite",
                 loaded_mu_, friction_range_above_zero())};
  }

  bool asked() const override { return !mu_.empty(); }

  Problem find_problem(const MainLine& main) const override {
    for (const auto& [name, checked] : {std::pair("wide_mu", &wide_mu_), std::pair("loaded_mu", &loaded_mu_)}) {
      for (const double mu : *checked) {
        if (std::find(mu_.begin(), mu_.end(), mu) != mu_.end()) continue;
        return problem(key(name), "{} is not in {}, so that nothing would be there to hold it against; add it there",
                       mu, key("mu"));
      }
    }
    for (const StudyEnsemble& one : ensembles(main)) {
      const double mu = one.spec.sampler.mu, needed = columns_needed(mu, last_lag(octaves_));
      if (columns_ < needed) {
        return problem(key("columns"),
                       "{} columns: at mu = {} the two peaks meet behind the ring above {} layers of depth; give at "
                       "least {}, or fewer octaves",
                       columns_, mu, last_lag(octaves_), std::ceil(needed));
      }
      if (auto found = find_lattice_problem(key("columns"), one.spec.lattice.columns, key("octaves"),
                                            one.spec.lattice.layers, bottom_margin + 1, drawing_memory(one.spec))) {
        return found;
      }
    }
    return find_samples_problem(key("samples"), samples_, main.response.blocks);
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
    measured_.push_back(measure_deep_response(ensemble, static_cast<DeepMeasurement>(one.part), threads_));
  }

  void finish() override {
    std::stable_sort(measured_.begin(), measured_.end(), [](const DeepResponse& a, const DeepResponse& b) {
      return a.spec.sampler.mu < b.spec.sampler.mu;
    });
  }

  std::vector<Claim> claims(const ClaimSpec& spec) const override {
    return asked() ? judge_spreading(measured_, spec) : std::vector<Claim>();
  }
  Json json() const override { return list_of(measured_, to_json); }
  std::vector<ReportPart> parts(const Json&) const override { return {table_part()}; }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    if (measured_.empty()) return {};
    return {[this](const std::filesystem::path& folder) { return plot_deep_response(measured_, folder); },
            [this](const std::filesystem::path& folder) { return plot_dispersion(measured_, folder); }};
  }

 private:
  EnsembleSpec spec_at(const MainLine& main, DeepMeasurement by, double mu) const {
    const int columns = by == DeepMeasurement::wide ? std::min(columns_, most_columns / 2) * 2 : columns_;
    EnsembleSpec spec = main.ensemble_at(mu, {columns, last_lag(octaves_)}, samples_);
    for (int octave = 0; octave <= octaves_; ++octave) spec.layers.push_back(last_lag(octave));
    if (by == DeepMeasurement::loads) {
      spec.response.estimator = EstimatorName::multiplexed;
      spec.response.opposite = true;
      spec.response.epsilon = main.response.epsilon;
      spec.lattice.layers += bottom_margin + 1;
    } else {
      spec.response.estimator = EstimatorName::fluctuation;
      // As many bases as the deepest lag has layers: half of each pile.
      spec.lattice.layers = fluctuation_plan(spec).layers_needed + last_lag(octaves_);
    }
    return spec;
  }

  std::vector<double> mu_;                   ///< each above 0; empty: not measured
  std::vector<double> wide_mu_, loaded_mu_;  ///< of those in mu_
  int octaves_ = 4;
  int columns_ = 720;
  std::uint64_t samples_ = 256;  ///< piles per friction coefficient
  int threads_ = 0;
  std::vector<DeepResponse> measured_;  ///< ascending in mu, checks behind what they check
};

}  // namespace

std::unique_ptr<Study> deep_response_study() { return std::make_unique<DeepResponseStudy>(); }

}  // namespace granuscope
