#include "studies/spreading.h"

#include <fmt/ranges.h>

#include <map>
#include <set>

#include "analysis/claims.h"
#include "analysis/double_gaussian.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/estimator.h"
#include "plot/plot.h"

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
  if (ensemble.spec.sampler.law == Law::polytope) response.effective_samples = effective_samples(sums);
  response.flat = test_flat_law(sums);
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
  if (one.by != DeepMeasurement::fluctuations)  // two of the same mu have names of their own
    json["by"] = one.by == DeepMeasurement::wide ? "wide-rings" : "loads";
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
  if (one.spec.sampler.law == Law::polytope) json["effective_samples"] = one.effective_samples;
  if (!one.flat.means.empty()) json["flat_law"] = one.flat;
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

Json spreading_page_1(const std::vector<DeepResponse>& measured, const ClaimSpec& spec, const std::string& pointer) {
  const PaperNumber diffusion{.value = 1, .tolerance = spec.exponent_tolerance};
  std::vector<std::string> deep;
  std::vector<double> fast, slow;  // friction, as the claim would judge each alone
  std::size_t octaves = 0;
  double apart = 0;
  const DeepResponse* at_mu = nullptr;  // the measurement that checks are held against
  bool checked = false;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const DeepResponse& one = measured[i];
    const Estimate& exponent = one.deep.exponent;
    if (at_mu != nullptr && at_mu->spec.sampler.mu == one.spec.sampler.mu) {
      if (!exponent.known() || !at_mu->deep.exponent.known()) continue;
      const Estimate& other = at_mu->deep.exponent;
      apart = std::max(
          apart, std::abs(exponent.value - other.value) / std::hypot(exponent.standard_error, other.standard_error));
      checked = true;
      continue;
    }
    at_mu = &one;
    if (!exponent.known()) continue;
    deep.push_back(fmt::format("{}/{}", pointer, i));
    const std::string verdict = one.deep.from < deep_from ? not_tested : judge_number(exponent, diffusion).verdict;
    if (verdict == not_reproduced && exponent.value > 1) fast.push_back(one.spec.sampler.mu);
    if (verdict == reproduced) slow.push_back(one.spec.sampler.mu);
    octaves = one.octaves.size();
  }
  if (deep.empty()) return nullptr;
  const std::string largest = deep.back();  // friction
  return {{"deep", enumerated(deep)},
          {"all_fast", fast.size() == deep.size()},
          {"some_fast", !fast.empty() && fast.size() < deep.size()},
          {"none_fast", fast.empty() && slow.size() == deep.size()},
          {"open", fast.empty() && slow.size() < deep.size()},
          {"fast", list_of_values(fast)},
          {"some_slow", !slow.empty()},
          {"slow", list_of_values(slow)},
          {"largest", {{"key", largest}}},
          {"first_octave", {{"key", largest + "/octaves/0"}}},
          {"last_octave", {{"key", fmt::format("{}/octaves/{}", largest, octaves - 1)}}},
          {"checked", checked},
          {"apart", fmt::format("{:.1f}", apart)}};
}

namespace {

constexpr int fewest_octaves = 3, most_octaves = 11;

/// Error of a D that is shown, relative to the D of the peaks in the first octave.
constexpr double noisiest = 0.25;

/// Columns 1, `value` and `value` + 1 of a data file; y errors are one standard error.
void add_curve(Panel& panel, const std::string& file, int value, const Ink& ink, int dash) {
  panel.add(file, fmt::format("1:{}", value), ink.line(0.8, dash));
  panel.add(file, fmt::format("1:{}:{}", value, value + 1), ink.bars(0.9, 0.55));
}

void extend(Range& range, const Estimate& one) { range.add(one.value, one.standard_error); }

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
      key.entries.push_back({by == DeepMeasurement::wide ? "twice the columns" : "by loads",
                             {.colour = "frame", .width = 0.9, .dash = dashes(by)}});
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
  std::vector<std::string> powers;
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
      extend(exponent, octave.exponent);
    }
    if (table.empty()) continue;
    const Estimate& last = one.octaves.back().exponent;
    if (one.by == DeepMeasurement::fluctuations && last.known())
      powers.push_back(fmt::format("{} at μ = {}", value_with_error(last), caption_number(one.spec.sampler.mu)));
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
  if (powers.size() > 2) powers.erase(powers.begin() + 1, powers.end() - 1);
  Wording words = wording("studies/deep_response.captions", measured);
  words.variables["powers"] = enumeration(powers);
  words.variables["last_from"] = caption_number(std::round(measured.front().octaves.back().from));
  return plot_figure(plot, words, run_folder);
}

Figure plot_dispersion(const std::vector<DeepResponse>& measured, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "dispersion";
  plot.height = 2.3;
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
      extend(diffusion, band.D);
      extend(speed, above);
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
  diffusions.y = log_axis("D(k)  (bead diameters)", D_axis);
  const Style guide{.width = 0.9, .dash = 4};
  speeds.add_level(0, {.colour = "frame", .width = 0.8});
  diffusions.curves.insert(diffusions.curves.begin(),
                           {"", "", fmt::format("{} * sqrt({} / $1)", exact(0.5 * D_axis.high), exact(axis.low)),
                            axis.low, axis.high, guide});
  plot.panels = {speeds, diffusions};
  plot.key = key.key();
  return plot_figure(plot, wording("studies/dispersion.captions", measured), run_folder);
}

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
                 KeyRange{}.within(fewest_octaves, most_octaves)),
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
        make_key(table(), "effective_samples", "piles",
                 "independent piles that each ensemble is to be worth, by the errors of thrust and weights: it grows "
                 "until then, as far as samples; 0: all samples are drawn",
                 effective_samples_, KeyRange{.least = 0}),
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
                       static_cast<int>(by), effective_samples_});
      }
    };
    add(DeepMeasurement::fluctuations, mu_, "", "");
    add(DeepMeasurement::wide, wide_mu_, " in wide piles", "-wide");
    add(DeepMeasurement::loads, loaded_mu_, " to loads", "-loads");
    return all;
  }

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
    const Json told = spreading_page_1(measured_, main_.claims, "/studies/" + id());
    return told.is_null() ? std::vector{table_part()} : std::vector{page_1(told), table_part()};
  }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    return figures_of(measured_, plot_deep_response, plot_dispersion);
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
  double effective_samples_ = 0;
  std::uint64_t loaded_samples_ = 0;
  int loaded_run_ = 1;
  std::vector<DeepResponse> measured_;  ///< ascending in mu, checks behind what they check
};

}  // namespace

std::unique_ptr<Study> deep_response_study() { return std::make_unique<DeepResponseStudy>(); }

}  // namespace granuscope
