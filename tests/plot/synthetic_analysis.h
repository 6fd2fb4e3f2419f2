#pragma once
// A made-up Analysis for tests of plots and reports: no pile was ever computed for it. Its c and D are rounded values
// of the order the model has; peak positions, widths and profiles follow from them by the fitted forms plus a fixed
// pattern of noise. One coefficient is exact (mu = 0), one D is unknown, one sample failed.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "analysis/results.h"
#include "kit/estimates.h"
#include "model/lattice.h"

namespace granuscope::synthetic {

/// A reproducible pattern between -1 and 1 (a linear congruential generator), roughly of variance 1/3.
class Pattern {
 public:
  explicit Pattern(std::uint64_t seed) : state_(seed * 2862933555777941757ULL + 3037000493ULL) {}
  double next() {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state_ >> 11) * 0x1p-52 - 1;
  }

 private:
  std::uint64_t state_;
};

using test::known;
using test::unknown;

struct Row {
  double mu, c, c_error, D, D_error, c_thrust, draws, repaired, backtracked;
};

inline const std::vector<Row>& rows() {
  static const std::vector<Row> table = {
      {0.10, 0.5748, 0.0002, 0.0048, 0.0003, 0.5748, 1.1093, 0.0312, 0.0025},
      {0.15, 0.5722, 0.0004, 0.0127, 0.0007, 0.5716, 1.1911, 0.0604, 0.0021},
      {0.20, 0.5690, 0.0006, 0.0257, 0.0012, 0.5674, 1.2702, 0.0841, 0.0018},
      {0.30, 0.5600, 0.0010, 0.0780, 0.0050, 0.5560, 1.4023, 0.1304, 0.0016},
      {0.40, 0.5522, 0.0019, 0.1710, 0.0160, 0.5424, 1.5702, 0.1912, 0.0012},
      {0.60, 0.5371, 0.0044, 0.4600, 0.0600, 0.5122, 1.9508, 0.3209, 0.0004},
  };
  return table;
}

inline constexpr double x_0 = -0.12;
inline constexpr double w_0 = 0.35;

/// The double Gaussian integrated over the bead [x - 1/2, x + 1/2].
inline double double_gaussian(double x, double peak, double width) {
  const auto share = [&](double centre) {
    const double scale = std::sqrt(2.0) * width;
    return 0.25 * (std::erf((x + 0.5 - centre) / scale) - std::erf((x - 0.5 - centre) / scale));
  };
  return share(peak) + share(-peak);
}

inline ResponseProfile profile_at(int layer, double c, double D, std::uint64_t seed) {
  ResponseProfile profile;
  profile.layer = layer;
  profile.z = Lattice::depth(layer);
  const double peak = x_0 + c * profile.z;
  const double width = std::sqrt(w_0 + D * profile.z);
  Pattern pattern(seed);
  std::vector<double> noise(251);
  for (double& value : noise) value = pattern.next();
  for (int i = -250; i < 250; ++i) {
    const double x = i;
    const double g = double_gaussian(x, peak, width);
    const double error = 0.0012 + 0.02 * g;
    profile.x.push_back(x);
    profile.pressure.push_back(g + 1.7 * error * noise[static_cast<std::size_t>(std::abs(i))]);
    profile.standard_error.push_back(error);
    profile.fit.push_back(g);
  }
  return profile;
}

inline DepthFit depth_fit(int layer, const Row& row, Pattern& pattern) {
  DepthFit fit;
  fit.layer = layer;
  fit.z = Lattice::depth(layer);
  const double position_error = 0.02 + 0.6 * row.c_error * fit.z;
  const double width_error = 0.02 + 0.6 * row.D_error * fit.z;
  fit.peak_position = known(x_0 + row.c * fit.z + position_error * pattern.next(), position_error);
  fit.width_squared = known(w_0 + row.D * fit.z + width_error * pattern.next(), width_error);
  const double width = std::sqrt(fit.width_squared.value);
  fit.width = known(width, width_error / (2 * width));
  fit.thrust_ratio = known(std::pow(row.c_thrust / tan30, 2), 2e-5);
  fit.chi2_per_dof = 1 + 0.1 * pattern.next();
  fit.degrees_of_freedom = 248;
  fit.identifiable = width > 0.75;
  if (!fit.identifiable) {
    fit.reason = "W is below 0.5 bead diameters";
    fit.peak_position = fit.width = fit.width_squared = unknown(fit.reason);
  }
  return fit;
}

inline Transport frictionless() {
  Transport result;
  result.spec.sampler.mu = 0;
  result.samples = 256;
  result.exact = true;
  result.c = known(tan30, 0);
  result.D = known(0, 0);
  result.position_offset = known(0, 0);
  result.width_offset = known(0, 0);
  result.alpha_thrust = known(1, 0);
  result.c_thrust = known(tan30, 0);
  result.c_minus_c_thrust = known(0, 0);
  result.window_layers = {58, 179};
  result.depths_in_window = 41;
  result.draws_per_bead = 1;
  for (const int layer : {110, 170}) {
    DepthFit fit;
    fit.layer = layer;
    fit.z = Lattice::depth(layer);
    fit.peak_position = known(tan30 * fit.z, 0);
    fit.width = known(0, 0);
    fit.width_squared = known(0, 0);
    fit.thrust_ratio = known(1, 0);
    fit.reason = "all the response stands on two beads: the moments are exact, nothing is fitted";
    result.depths.push_back(fit);
  }
  return result;
}

inline Transport transport(const Row& row) {
  Transport result;
  result.spec.sampler.mu = row.mu;
  result.samples = 3456;
  result.c = known(row.c, row.c_error);
  result.D = known(row.D, row.D_error);
  result.position_offset = known(x_0, 0.03);
  result.width_offset = known(w_0, 0.08);
  const double alpha = std::pow(row.c_thrust / tan30, 2);
  result.alpha_thrust = known(alpha, 2.1e-5);
  result.c_thrust = known(row.c_thrust, 8e-6);
  result.c_minus_c_thrust = known(row.c - row.c_thrust, row.c_error * 0.98);
  result.window_layers = {58, 179};
  result.depths_in_window = 41;
  result.draws_per_bead = row.draws;
  result.repaired_per_bead = row.repaired;
  result.backtracked_per_bead = row.backtracked;
  const auto seed = static_cast<std::uint64_t>(std::lround(1000 * row.mu));
  Pattern pattern(seed);
  for (int layer = 16; layer <= 179; layer += 3) result.depths.push_back(depth_fit(layer, row, pattern));
  for (const int layer : {110, 170}) {
    result.depths.push_back(depth_fit(layer, row, pattern));
    result.profiles.push_back(profile_at(layer, row.c, row.D, seed + static_cast<std::uint64_t>(layer)));
  }
  std::sort(result.depths.begin(), result.depths.end(),
            [](const DepthFit& a, const DepthFit& b) { return a.layer < b.layer; });
  return result;
}

inline ScalingFit power_law(double exponent, double error, double ln_prefactor, std::array<double, 2> window) {
  ScalingFit fit;
  fit.exponent = known(exponent, error);
  fit.intercept = known(ln_prefactor, 0.1);
  fit.window = window;
  fit.points = 4;
  return fit;
}

inline ScalingFits scaling(std::array<double, 2> window) {
  // Slopes through the first and the last point of the window's table rows.
  ScalingFits fits;
  fits.beta = power_law(2.538, 0.081, 0.51, window);
  fits.gamma = power_law(1.743, 0.092, -1.95, window);
  fits.alpha = power_law(0.688, 0.043, -2.295, window);
  return fits;
}

inline Claim claim(const std::string& id, const std::string& statement, const std::string& verdict,
                   const Estimate& measured, double paper, double paper_error, double z_score,
                   const std::string& explanation) {
  Claim made;
  made.id = id;
  made.statement = statement;
  made.quantity = "measured number";
  made.verdict = verdict;
  made.expected = verdict;
  made.measured = measured;
  made.paper = paper;
  made.paper_error = paper_error;
  made.z_score = z_score;
  made.rival = made.rival_distance = std::numeric_limits<double>::quiet_NaN();
  made.explanation = explanation;
  return made;
}

inline std::vector<Claim> claims() {
  const double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<Claim> list;
  list.push_back(claim("frictionless", "Without friction c = tan 30° and D = 0.", "reproduced", known(0, 0), 0, 0, 0,
                       "The frictionless pile is exact: its forces run along straight lines."));
  list.push_back(claim("D-of-mu", "D grows as μ^β with β ≈ 2.5.", "reproduced", known(2.538, 0.081), 2.5, 0.05, 0.4,
                       "The exponent over the primary window agrees with the paper's."));
  list.push_back(
      claim("c-of-mu", "c₀ − c is proportional to μ at small μ.", "not reproduced", known(1.743, 0.092), 1, 0.5, 8.07,
            "Over this window c₀ − c grows faster than linearly; the exponent falls as the window moves up."));
  list.push_back(claim("c-of-D", "c₀ − c grows as D^α with α = 0.4 ± 0.01.", "not reproduced", known(0.688, 0.043), 0.4,
                       0.01, 6.52, "The exponent follows γ/β, and γ is not 1 over this window."));
  list.push_back(claim("amplitude", "The height of the peaks falls as 1/√z.", "not tested",
                       unknown("no claim about heights is evaluated with fewer than eight depths"), none, none, none,
                       "Too few depths are identified for a slope of the height."));
  list.back().expected.clear();
  return list;
}

inline Analysis analysis() {
  Analysis made;
  made.results.push_back(frictionless());
  for (const Row& row : rows()) made.results.push_back(transport(row));
  made.results.back().D = unknown("the widths at 7 of 41 depths are not identified");
  made.results.back().width_offset = made.results.back().D;
  FailedSample failed;
  failed.sample = 17;
  failed.layer = 40;
  failed.replay =
      "granuscope sample --mu 0.3 --columns 500 --layers 200 --law granusolve --load point --seed 20020604 --samples "
      "18 "
      "--out failed.h5 --sample 17";
  made.results[4].failed.push_back(failed);
  made.results[4].samples = 3455;
  made.scaling = scaling({0.1, 0.3});
  ScalingFits other = scaling({0.15, 0.6});
  other.beta.exponent = known(2.79, 0.07);
  other.gamma.exponent = unknown("D is unknown at μ = 0.6");
  other.gamma.intercept = other.gamma.exponent;
  made.other_windows.push_back(other);
  made.readings = {{"at_one_depth", "at z = 95.8", {}, made.scaling}, {"small_friction", "small friction", {}, {}}};
  made.readings[0].fits.beta.exponent = known(2.79, 0.07);
  made.readings[0].fits.gamma = power_law(0.98, 0.03, -2.7, {0.1, 0.3});
  made.readings[0].fits.alpha = power_law(0.398, 0.018, -2.9, {0.1, 0.3});
  for (const Row& row : rows()) {
    made.readings[0].points.push_back(
        {row.mu, known(tan30 - 0.067 * std::pow(row.mu, 0.98), 4e-4), known(row.D, 0.05 * row.D)});
  }
  made.readings[1].fits = {power_law(2.06, 0.07, -0.5, {0.05, 0.1}), power_law(1.95, 0.04, -1.5, {0.05, 0.1}),
                           power_law(0.95, 0.03, -1, {0.05, 0.1})};
  for (const double mu : {0.05, 0.07, 0.1}) {
    made.readings[1].points.push_back({mu, known(tan30 - 0.26 * mu * mu, 2e-5), known(0.6 * mu * mu, 0.02 * mu * mu)});
  }
  made.mean_position_offset = known(-0.2874, 0.0059);
  made.claims = claims();
  return made;
}

}  // namespace granuscope::synthetic
