#include "studies/spreading.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/claims.h"
#include "analysis/double_gaussian.h"
#include "analysis/mean_response.h"
#include "analysis/measured_depth.h"
#include "analysis/shape_fit.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/estimator.h"
#include "ensemble/fluctuation_estimator.h"
#include "model/lattice.h"
#include "report/clean_json.h"
#include "studies/study.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr int most_first_lag = 1024;
constexpr double least_width = 0.3;  ///< bead diameters

/// What a fit gives of x_p on a ring is the image of either peak that is nearest to the load. Of all images, the one
/// nearest to `expected`.
double unwrapped(double peak, double expected, int columns) {
  const auto image = [&](double of) { return of + columns * std::round((expected - of) / columns); };
  const double right = image(peak), left = image(-peak);
  return std::abs(left - expected) < std::abs(right - expected) ? left : right;
}

void unwrap(Replicated& peak, double expected, int columns) {
  peak.value = unwrapped(peak.value, expected, columns);
  for (double& without : peak.without_block) without = unwrapped(without, peak.value, columns);
}

/// What a background between the peaks takes of the response at recorded layer number `row`, whatever the verdict on
/// their shape. By cosines alone, since it is not known which peak a background belongs to; unknown where they leave
/// it open. On a ring it goes around as the peaks do.
ShapeDiagnostics background_at(const MeasuredEnsemble& ensemble, std::size_t row, const MeasuredDepth& depth) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const LayerSpectrum spectrum = layer_spectrum(ensemble.record.sums, row, ensemble.spec.response.overload);
  const int columns = ensemble.spec.lattice.columns;
  if (std::isfinite(depth.peak.value) && !spectrum.exact) {
    auto fit = fit_shape(spectrum, {std::abs(std::remainder(depth.peak.value, columns)), depth.width.value});
    if (fit) fit->shape.peak = unwrapped(fit->shape.peak, depth.peak.value, columns);
    if (fit && fit->shape.peak > 0) return diagnose_shape(spectrum, *fit, {depth.peak.value, depth.width.value});
  }
  const Replicated unknown{nan, std::vector<double>(spectrum.without_block.size(), nan)};
  return {unknown, unknown, nan, unknown, unknown};
}

}  // namespace

Key first_lag_key(const std::string& table, int& first_lag) {
  return make_key(table, "first_lag", "layers",
                  "depth from which it is doubled; piles are kept in memory one layer in so many", first_lag,
                  KeyRange{}.within(1, most_first_lag));
}

Key loaded_run_key(const std::string& table, int& run) {
  return make_key(table, "loaded_run", "beads",
                  "by loads: so many neighbouring top beads, or one more, are raised or lowered together; as many as a "
                  "peak is wide make errors several times smaller down there, and larger where peaks are narrower; "
                  "epsilon² times this is what long waves of the loads carry, and must not exceed what those of piles "
                  "carry by themselves (C_w, some 0.1 to 0.3), or else the loads spread the peaks",
                  run, KeyRange{.least = 1});
}

Problem find_run_problem(const std::string& key, int run, int columns) {
  const int most = longest_run({columns, 1});
  if (run <= most) return {};
  return problem(key, "{} beads: on a ring of {} beads that leaves too few loads; give at most {}", run, columns, most);
}

EnsembleSpec spec_of_lags(EnsembleSpec spec, int first_lag, int octaves) {
  spec.response.estimator = EstimatorName::fluctuation;
  for (int octave = 0; octave <= octaves; ++octave) spec.layers.push_back(first_lag << octave);
  spec.lattice.layers = spec.layers.back();
  spec.lattice.layers += fluctuation_plan(spec).layers_needed;
  return spec;
}

Problem find_ring_problem(const std::string& columns_key, int columns, const std::vector<double>& mu,
                          const std::vector<int>& lags) {
  for (const double one : mu) {
    if (columns_apart({one}, lags, columns) == columns) continue;
    return problem(
        columns_key,
        "{} columns: at mu = {} the two peaks meet on the ring at one of the depths that are measured, so that their "
        "position and width could not be told apart; give {} columns, or another number of octaves",
        columns, one, columns_apart(mu, lags, columns));
  }
  return {};
}

EnsembleSpec spec_of_check(EnsembleSpec spec, DeepMeasurement by, double epsilon, int run) {
  if (by == DeepMeasurement::wide) spec.lattice.columns = 2 * std::min(spec.lattice.columns, most_columns / 2);
  if (by == DeepMeasurement::loads) {
    ResponseSpec loads = multiplexed_response(epsilon, true, run);
    loads.overload = spec.response.overload;
    loads.samples = spec.response.samples;
    loads.blocks = spec.response.blocks;
    spec.response = loads;
    spec.record_H = !is_scalar(spec.sampler.model);
    spec.lattice.layers = spec.layers.back() + bottom_margin + 1;
  }
  return spec;
}

DeepResponse measure_spreading(const MeasuredEnsemble& ensemble, DeepMeasurement by, int threads) {
  const BlockSums& sums = ensemble.record.sums;
  // Recorded first are the lag 0, which others are referred to, or the loads.
  constexpr std::size_t first = 1;
  DeepResponse response;
  response.by = by;
  response.spec = ensemble.spec;
  response.samples = sums.samples();
  FitSpec fit;
  fit.min_identifiable_width = least_width;
  std::vector<MeasuredDepth> depths(sums.layers.size() - first);
  for_each_index(depths.size(), threads, [&](std::size_t i) { depths[i] = measure_depth(ensemble, fit, i + first); });
  const Replicated thrust = thrust_speed(sums, by == DeepMeasurement::loads ? sums.layers.back() : 0);
  response.c_thrust = estimate(thrust, "a block of the ensemble holds no completed pile");
  for (MeasuredDepth& depth : depths) {
    const double expected = response.c_thrust.value * (depth.fit.z - Lattice::depth(0));
    if (response.c_thrust.known()) unwrap(depth.peak, expected, ensemble.spec.lattice.columns);
  }
  std::vector<ShapeDiagnostics> beside(depths.size());
  for_each_index(depths.size(), threads,
                 [&](std::size_t i) { beside[i] = background_at(ensemble, i + first, depths[i]); });
  // Another shape than two Gaussians is told by the misfit, and no reason to be silent.
  const auto reason = [&](const MeasuredDepth& depth) -> std::string {
    if (by != DeepMeasurement::loads && widths_of_ring * depth.width.value > ensemble.spec.lattice.columns) {
      return fmt::format(
          "a peak of W = {:.1f} is wider than a sixth of the ring, which has no waves long enough for it",
          depth.width.value);
    }
    if (depth.width.value < least_width) return "the width of a bead hides that of the peaks";
    return depth.other_shape ? std::string() : depth.fit.reason;
  };
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const MeasuredDepth& depth = depths[i];
    response.lags.push_back({depth.fit.layer, depth.fit.z - Lattice::depth(0), estimate(depth.peak, reason(depth)),
                             estimate(depth.width_squared, reason(depth)), depth.fit.chi2_per_dof, depth.fit.misfit,
                             estimate(beside[i].background, no_extended_fit),
                             beside[i].chi2_beside / (depth.fit.degrees_of_freedom - 1)});
    if (!reason(depth).empty()) response.lags.back().between = {.reason = reason(depth)};
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
    OctaveOfDepth octave;
    octave.from = from;
    octave.to = to;
    octave.exponent = of_width.exponent;
    octave.misfit = std::max(above.fit.misfit, below.fit.misfit);
    const auto slope = [&](double a, double b) { return (b - a) / (to - from); };
    if (octave.exponent.reason.empty()) {
      octave.c = estimate(transform(slope, above.peak, below.peak));
      response.slopes_of_width.push_back(transform(slope, above.width_squared, below.width_squared));
      octave.D = estimate(response.slopes_of_width.back());
      octave.c_minus_c_thrust = estimate(transform([](double c, double of_thrust) { return c - of_thrust; },
                                                   transform(slope, above.peak, below.peak), thrust),
                                         "a block of the ensemble holds no completed pile");
      octave.c_beside = estimate(transform(slope, beside[i].peak, beside[i + 1].peak), no_extended_fit);
      octave.D_beside =
          estimate(transform(slope, beside[i].width_squared, beside[i + 1].width_squared), no_extended_fit);
    } else {
      response.slopes_of_width.emplace_back();
      for (Estimate* one : {&octave.c, &octave.D, &octave.c_minus_c_thrust, &octave.c_beside, &octave.D_beside}) {
        one->reason = octave.exponent.reason;
      }
    }
    octave.between = response.lags[i + 1].between;
    response.octaves.push_back(octave);
  }
  const std::size_t last = depths.size() - 1;
  response.shallow = power(1, 2);
  response.deep = power(std::max<std::size_t>(2, last - 2), last);
  if (by != DeepMeasurement::loads && response.c_thrust.known()) {
    std::vector<double> D;
    for (const OctaveOfDepth& octave : response.octaves) D.push_back(octave.D.value);
    response.bands = dispersion_of_lags(sums, response.c_thrust.value, D);
  }
  return response;
}

using Json = nlohmann::ordered_json;

void to_json(Json& json, const LagResponse& lag) {
  json = {{"lag", lag.lag},
          {"z", lag.z},
          {"peak_position", lag.peak_position},
          {"width_squared", lag.width_squared},
          {"chi2_per_dof", finite_or_null(lag.chi2_per_dof)},
          {"misfit", finite_or_null(lag.misfit)},
          {"between", lag.between},
          {"chi2_per_dof_beside_background", finite_or_null(lag.chi2_beside_per_dof)}};
}

void to_json(Json& json, const OctaveOfDepth& octave) {
  json = {{"z", {octave.from, octave.to}},
          {"exponent", octave.exponent},
          {"c", octave.c},
          {"D", octave.D},
          {"misfit", finite_or_null(octave.misfit)},
          {"c_minus_c_thrust", octave.c_minus_c_thrust},
          {"between", octave.between},
          {"c_beside_background", octave.c_beside},
          {"D_beside_background", octave.D_beside}};
}

void to_json(Json& json, const PowerOfDepth& power) {
  json = {{"z", {power.from, power.to}}, {"exponent", power.exponent}};
}

void to_json(Json& json, const BandOfModes& band) {
  json = {{"k", band.k},         {"band", {band.k_from, band.k_to}},
          {"modes", band.modes}, {"z", {band.z_from, band.z_to}},
          {"c", band.c},         {"D", band.D}};
}

void to_json(Json& json, const DeepResponse& one) {
  json = {{"measurement", fmt::format("mu = {}, {}, {} columns", one.spec.sampler.mu,
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
  json.update(Json{{"lags", one.lags},
                   {"octaves", one.octaves},
                   {"shallow", one.shallow},
                   {"deep", one.deep},
                   {"dispersion", one.bands},
                   {"c_thrust", one.c_thrust}});
}

namespace {

/// Where the stretches begin that the claims speak of, bead diameters: about where the paper's window does, and below
/// it.
constexpr double shallow_from = 40, deep_from = 80;

/// One stretch of depth, judged at the friction coefficient where the power is farthest from 1.
Claim judge_stretch(const std::vector<DeepResponse>& measured, const ClaimSpec& spec, const char* id,
                    const std::string& where, PowerOfDepth DeepResponse::*stretch, double from) {
  Claim claim =
      open_claim(id, fmt::format("The squared width W² grows linearly with z {}.", where), "power of z in W²");
  claim.beyond_paper = true;
  const PaperNumber paper{.value = 1, .tolerance = spec.exponent_tolerance};
  const DeepResponse* farthest = nullptr;
  double farthest_z = 0;
  std::vector<std::string> all;
  for (const DeepResponse& one : measured) {
    const Estimate& power = (one.*stretch).exponent;
    if (!power.known() || one.by != DeepMeasurement::fluctuations || (one.*stretch).from < from) continue;
    all.push_back(fmt::format("{} at μ = {}", value_with_error(power), one.spec.sampler.mu));
    const double z = std::abs(judge_number(power, paper).z_score);
    if (farthest != nullptr && z <= farthest_z) continue;
    farthest = &one;
    farthest_z = z;
  }
  if (farthest == nullptr) {
    leave_open(claim, "no power of z is known there: give the study of spreading more piles, or more octaves");
    return claim;
  }
  const PowerOfDepth& power = farthest->*stretch;
  judge_by_number(claim, power.exponent, paper, {},
                  fmt::format("The power of z in W² from z = {:.0f} to {:.0f} at μ = {}, where it is farthest from 1,",
                              power.from, power.to, farthest->spec.sampler.mu));
  claim.quantity += fmt::format(" at μ = {}, where it is farthest from 1", farthest->spec.sampler.mu);
  if (all.size() > 1) add_sentence(claim, "All of them: {}.", fmt::join(all, ", "));
  return claim;
}

/// Where the deep stretch was followed, in numbers: with three octaves it ends at z = 222, and piles of 200 layers,
/// as the paper has them, at z = 173.
std::string spreading_depths(const std::vector<DeepResponse>& measured) {
  double from = 0, to = 0;
  for (const DeepResponse& one : measured) {
    if (one.by != DeepMeasurement::fluctuations || !one.deep.exponent.known() || one.deep.to <= to) continue;
    from = one.deep.from;
    to = one.deep.to;
  }
  if (to == 0) return "deeper below saturated layers";
  return fmt::format("from z = {:.0f} to {:.0f} below saturated layers", from, to);
}

}  // namespace

std::vector<Claim> judge_spreading(const std::vector<DeepResponse>& measured, const ClaimSpec& spec) {
  return {judge_stretch(measured, spec, "spreading-shallow", "at the paper's depths, below saturated layers",
                        &DeepResponse::shallow, shallow_from),
          judge_stretch(measured, spec, "spreading-deep", spreading_depths(measured), &DeepResponse::deep, deep_from)};
}

namespace {

constexpr double sure = 3;  ///< standard errors

double distance(const Estimate& one, const Estimate& other) {
  return std::abs(one.value - other.value) / std::hypot(one.standard_error, other.standard_error);
}

}  // namespace

Json spreading_page_1(const std::vector<DeepResponse>& measured, const std::string& pointer) {
  const Estimate diffusion{1, 0, {}};
  std::vector<std::string> deep;
  std::size_t slow = 0, fast = 0, octaves = 0;
  double apart = 0;
  const DeepResponse* at_mu = nullptr;  // the measurement that checks are held against
  bool checked = false;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const DeepResponse& one = measured[i];
    const Estimate& exponent = one.deep.exponent;
    if (at_mu != nullptr && at_mu->spec.sampler.mu == one.spec.sampler.mu) {
      if (!exponent.known() || !at_mu->deep.exponent.known()) continue;
      apart = std::max(apart, distance(exponent, at_mu->deep.exponent));
      checked = true;
      continue;
    }
    at_mu = &one;
    if (!exponent.known()) continue;
    deep.push_back(fmt::format("{}/{}", pointer, i));
    (exponent.value > 1 && distance(exponent, diffusion) > sure ? fast : slow) += 1;
    octaves = one.octaves.size();
  }
  if (deep.empty()) return nullptr;
  const std::string largest = deep.back();  // friction
  return {{"deep", enumerated(deep)},
          {"all_fast", slow == 0},
          {"some_fast", fast > 0 && slow > 0},
          {"none_fast", fast == 0},
          {"largest", {{"key", largest}}},
          {"first_octave", {{"key", largest + "/octaves/0"}}},
          {"last_octave", {{"key", fmt::format("{}/octaves/{}", largest, octaves - 1)}}},
          {"checked", checked},
          {"apart", fmt::format("{:.1f}", apart)}};
}

}  // namespace granuscope
