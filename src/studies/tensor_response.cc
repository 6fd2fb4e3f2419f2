#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "analysis/dispersion.h"
#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "analysis/results.h"
#include "ensemble/estimator.h"
#include "ensemble/fluctuation_estimator.h"
#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/plot.h"
#include "report/clean_json.h"
#include "studies/spreading.h"
#include "studies/study.h"
#include "support/error.h"
#include "support/plain_text.h"

// Green's tensor: the mean stresses under a point force that is vertical or horizontal, and whether a closure relation
// ties sigma_xx to the other two. Stresses of a layer n are sums over the contacts that leave its beads, force times
// branch vector over the area sqrt(3)/2 of a bead:
//   sigma_zz = V_R + V_L = w,   sigma_xz = H_R + H_L = H,   sigma_xx = (H_R - H_L)/sqrt(3).
// Balance of horizontal forces hands H down, in Fourier modes exp(-i k x) of true positions, as
//   H_{n+1} = cos(k/2) H_n - i sqrt(3) sin(k/2) sigma_xx,n,
// so that sigma_xx follows from H in successive layers, in each pile and therefore in the mean: div sigma = 0.
namespace granuscope {
namespace {

using Json = nlohmann::ordered_json;

/// One Fourier mode of Green's tensor at one depth. Under a vertical unit load sigma_zz and sigma_xx are real and
/// sigma_xz is i times the number here; under a horizontal one it is the other way round.
struct TensorMode {
  double times = 2;               ///< how often it counts: the mode 0 once, others with their mirror image
  double k = 0;                   ///< 2 sin(k/2), the wave number that differences of neighbouring beads see
  double zz = 0, xz = 0, xx = 0;  ///< of a vertical load
  double zz_horizontal = 0, xz_horizontal = 0, xx_horizontal = 0;  ///< of a horizontal one
};

/// The modes 0, 1, 2, ... that carry weight: without each block, and last without none.
using Tensors = std::vector<std::vector<TensorMode>>;

/// The share of sigma_xx that the best eta misses below a vertical load on an elastic half plane (Boussinesq):
/// sigma_zz ~ 1/(1 + t^2)^2 and sigma_xx ~ t^2/(1 + t^2)^2 of t = x/z, hence sqrt(4/5).
constexpr double elastic_share = 0.8944;

/// What closes the equations at one depth.
enum Coefficient { eta, eta_beside, nu, D_from_nu, coefficients };
using Closure = std::array<double, coefficients>;

/// The share of sigma_xx, root mean square over x, that is missed: by eta below either load, and below the vertical one
/// with a gradient.
enum Share { vertical, horizontal, beside, shares };

struct ClosureAtDepth {
  double z = 0;  ///< of the contacts between two layers, below the reference
  std::array<Estimate, coefficients> found;
  std::array<Estimate, shares> missed;
  Estimate D;  ///< of long waves, from the depth before
};

/// Stress against x at one depth.
struct StressProfile {
  std::vector<double> x;
  /// sigma_zz, sigma_xz, sigma_xx and its standard error, of a vertical and of a horizontal load; per bead
  std::array<std::array<std::vector<double>, 4>, 2> stress;
};

struct TensorResponse {
  EnsembleSpec spec;
  std::uint64_t samples = 0;
  Estimate c_thrust;
  std::vector<ClosureAtDepth> depths;
  std::size_t profile_depth = 0;  ///< number of the depth of `profile`: the second one, if there are so many
  StressProfile profile;
};

/// Of all blocks but `left_out`, or of all; between the recorded lags number `row` and `row` + 1. `ratio`: sigma_xx
/// over sigma_zz of the longest wave, which the thrust ratio is.
std::vector<TensorMode> tensor_without(const BlockSums& sums, std::size_t row, std::size_t left_out, double ratio) {
  const std::vector<double> reference = propagation_without(propagation_at(sums, 0), left_out),
                            above = propagation_without(propagation_at(sums, row), left_out),
                            below = propagation_without(propagation_at(sums, row + 1), left_out);
  const int columns = sums.quantities.at("propagation").width / 2;
  std::vector<TensorMode> modes{{1, 0, 1, 0, ratio, 0, 1, 0}};
  for (std::size_t at = 0; at < std::min({above.size(), below.size(), reference.size()}); at += correlation_parts) {
    const ModePropagator G = mode_propagator(&above[at], &reference[at]),
                         next = mode_propagator(&below[at], &reference[at]);
    const double half_k = std::numbers::pi * static_cast<double>(modes.size()) / columns;
    const double cosine = std::cos(half_k), sine = sqrt3 * std::sin(half_k);
    modes.push_back({2, 2 * std::sin(half_k), G.ww, G.Hw, (cosine * G.Hw - next.Hw) / sine, G.wH, G.HH,
                     (next.HH - cosine * G.HH) / sine});
  }
  return modes;
}

/// Least squares over x of sigma_xx = eta sigma_zz under a vertical load, and of sigma_xx = eta sigma_zz - nu d/dx
/// sigma_xz under both, the horizontal one counting as `weight` of the other. By mirror symmetry sigma_zz is even where
/// sigma_xz is odd, so that a term eta' sigma_xz comes out as 0.
/// With it and sigma_zx = sigma_xz a wave is damped by D = nu + (1 - 3 eta)/(2 sqrt(3)) on this lattice.
Closure close_equations(const std::vector<TensorMode>& modes, double weight) {
  double zz = 0, zg = 0, gg = 0, xz = 0, xg = 0, plain = 0, of_plain = 0;
  for (const TensorMode& m : modes) {
    plain += m.times * m.zz * m.xx;
    of_plain += m.times * m.zz * m.zz;
    const double g = m.k * m.xz, g_horizontal = -m.k * m.xz_horizontal;
    zz += m.times * (m.zz * m.zz + weight * m.zz_horizontal * m.zz_horizontal);
    zg += m.times * (m.zz * g + weight * m.zz_horizontal * g_horizontal);
    gg += m.times * (g * g + weight * g_horizontal * g_horizontal);
    xz += m.times * (m.xx * m.zz + weight * m.xx_horizontal * m.zz_horizontal);
    xg += m.times * (m.xx * g + weight * m.xx_horizontal * g_horizontal);
  }
  const double determinant = zz * gg - zg * zg;
  Closure found{};
  found[eta] = plain / of_plain;
  found[eta_beside] = (xz * gg - xg * zg) / determinant;
  found[nu] = (xg * zz - xz * zg) / determinant;
  found[D_from_nu] = found[nu] + (1 - 3 * found[eta_beside]) / (2 * sqrt3);
  return found;
}

/// The mean square over x of a field, up to a factor: the sum over modes of value(mode, replicate)^2, less what noise
/// adds to it, which is its variance.
template <typename Value>
Replicated power_of(const Tensors& tensors, Value value) {
  const std::size_t blocks = tensors.size() - 1;
  Replicated power{0, std::vector<double>(blocks)};
  for (std::size_t m = 0; m < tensors.back().size(); ++m) {
    const double times = tensors.back()[m].times;
    const auto at = [&](std::size_t replicate) {
      return m < tensors[replicate].size() ? value(tensors[replicate][m], replicate) : 0;
    };
    Replicated one{at(blocks), {}};
    for (std::size_t b = 0; b < blocks; ++b) one.without_block.push_back(at(b));
    const double noise = std::pow(estimate(one).standard_error, 2);
    power.value += times * (one.value * one.value - noise);
    for (std::size_t b = 0; b < blocks; ++b) {
      power.without_block[b] += times * (std::pow(one.without_block[b], 2) - noise);
    }
  }
  return power;
}

/// A field of an even real spectrum, or of i times an odd one, at x.
template <typename Part>
double field_at(double x, const std::vector<TensorMode>& modes, int columns, bool even, Part part) {
  double sum = 0;
  for (std::size_t m = 0; m < modes.size(); ++m) {
    const double angle = 2 * std::numbers::pi * x * static_cast<double>(m) / columns;
    sum += modes[m].times * part(modes[m]) * (even ? std::cos(angle) : -std::sin(angle));
  }
  return sum / columns;
}

StressProfile profile_of(const Tensors& tensors, int columns, double reach) {
  using Part = double TensorMode::*;
  constexpr std::array<std::array<Part, 3>, 2> parts{
      {{&TensorMode::zz, &TensorMode::xz, &TensorMode::xx},
       {&TensorMode::zz_horizontal, &TensorMode::xz_horizontal, &TensorMode::xx_horizontal}}};
  StressProfile profile;
  const int last = std::min(columns / 2, static_cast<int>(reach));
  for (int x = -last; x <= last; ++x) {
    profile.x.push_back(x);
    for (const std::size_t load : {vertical, horizontal}) {
      for (std::size_t part = 0; part < 3; ++part) {
        const bool even = (part == 1) == (load == horizontal);
        Replicated one;
        for (const auto& modes : tensors) {
          one.without_block.push_back(
              field_at(x, modes, columns, even, [&](const TensorMode& m) { return m.*parts[load][part]; }));
        }
        one.value = one.without_block.back();
        one.without_block.pop_back();
        profile.stress[load][part].push_back(one.value);
        if (part == 2) profile.stress[load][3].push_back(estimate(one).standard_error);
      }
    }
  }
  return profile;
}

/// From an ensemble that records the lag 0 and pairs of successive lags.
TensorResponse measure_tensor(const MeasuredEnsemble& ensemble) {
  const BlockSums& sums = ensemble.record.sums;
  const auto blocks = static_cast<std::size_t>(sums.blocks());
  TensorResponse response;
  response.spec = ensemble.spec;
  response.samples = sums.samples();
  const Replicated speed = thrust_speed(sums, 0), ratio = transform([](double c) { return c * c; }, speed);
  response.c_thrust = estimate(speed);
  const double mu = ensemble.spec.sampler.mu;
  const double rough_D = std::pow(expected_width(mu, 1), 2) - 1;
  const std::string unknown = "no mode of the response carries weight";
  for (std::size_t row = 1; row + 1 < sums.layers.size(); row += 2) {
    ClosureAtDepth depth;
    depth.z = sums.rows.spacing * (sums.layers[row] + 0.5);
    Tensors tensors;
    std::vector<Closure> closures;
    for (std::size_t left_out = 0; left_out <= blocks; ++left_out) {
      tensors.push_back(
          tensor_without(sums, row, left_out, left_out < blocks ? ratio.without_block[left_out] : ratio.value));
      closures.push_back(close_equations(tensors.back(), ratio.value));
    }
    for (std::size_t i = 0; i < coefficients; ++i) {
      Replicated number{closures.back()[i], {}};
      for (std::size_t b = 0; b < blocks; ++b) number.without_block.push_back(closures[b][i]);
      depth.found[i] = estimate(number, unknown);
    }
    const auto power = [](const TensorMode& m, std::size_t) { return m.xx; };
    const auto power_horizontal = [](const TensorMode& m, std::size_t) { return m.xx_horizontal; };
    const auto share = [&](const Replicated& rest, const Replicated& all) {
      return estimate(transform([](double a, double b) { return std::sqrt(a / b); }, rest, all), "no more than noise");
    };
    depth.missed[vertical] =
        share(power_of(tensors, [&](const TensorMode& m, std::size_t b) { return m.xx - closures[b][eta] * m.zz; }),
              power_of(tensors, power));
    depth.missed[horizontal] =
        share(power_of(tensors, [&](const TensorMode& m,
                                    std::size_t b) { return m.xx_horizontal - closures[b][eta] * m.zz_horizontal; }),
              power_of(tensors, power_horizontal));
    depth.missed[beside] = share(power_of(tensors,
                                          [&](const TensorMode& m, std::size_t b) {
                                            return m.xx - closures[b][eta_beside] * m.zz - closures[b][nu] * m.k * m.xz;
                                          }),
                                 power_of(tensors, power));
    // Waves that are not damped away by then.
    const double longest = std::sqrt(2 / (rough_D * depth.z));
    const auto bands =
        measure_dispersion(sums, row == 1 ? 0 : row - 2, row, {0, longest}, {response.c_thrust.value, rough_D});
    depth.D = bands.empty() ? Estimate{.reason = unknown} : bands.front().D;
    if (response.depths.size() <= 1) {
      response.profile_depth = response.depths.size();
      const double reach = speed.value * depth.z + 3 * expected_width(mu, depth.z);
      response.profile = profile_of(tensors, ensemble.spec.lattice.columns, reach);
    }
    response.depths.push_back(depth);
  }
  return response;
}

void to_json(Json& json, const ClosureAtDepth& depth) {
  json = {{"z", depth.z},
          {"eta", depth.found[eta]},
          {"missed", depth.missed[vertical]},
          {"missed_horizontal", depth.missed[horizontal]},
          {"eta_beside_gradient", depth.found[eta_beside]},
          {"nu", depth.found[nu]},
          {"missed_beside_gradient", depth.missed[beside]},
          {"D_from_nu", depth.found[D_from_nu]},
          {"D", depth.D}};
}

void to_json(Json& json, const TensorResponse& one) {
  const auto square = [](double c) { return c * c; };
  Estimate ratio = one.c_thrust;
  if (ratio.known()) ratio = {square(one.c_thrust.value), 2 * one.c_thrust.value * one.c_thrust.standard_error, ""};
  json = {{"mu", one.spec.sampler.mu}, {"columns", one.spec.lattice.columns}, {"layers", one.spec.lattice.layers},
          {"samples", one.samples},    {"c_thrust_squared", ratio},           {"depths", one.depths}};
}

/// The stresses under both loads at the largest mu, and below them what a closure misses, against depth.
Figure plot_tensor(const std::vector<TensorResponse>& measured, const std::filesystem::path& run_folder) {
  const TensorResponse& shown = measured.back();
  const ClosureAtDepth& at_depth = shown.depths[shown.profile_depth];
  if (!at_depth.found[eta].known()) {
    throw InputError(
        "the figure of the stresses has nothing to show: no mode of the response was followed; give more piles");
  }
  const auto percent = [](const Estimate& share) {
    return share.known() ? fmt::format("{:.0f} %", 100 * share.value) : "0 %";
  };
  Plot plot;
  plot.id = "tensor-response";
  plot.height = 4.6;
  plot.key = {.inches = 0.5, .lines = 2, .sample = 2, .entries = {}};
  constexpr double lower_row = 2.0;
  const double upper = plot.height - plot.key.inches - lower_row;
  const std::array<Style, 3> styles{
      Style{"lines", "blue", 1.2}, {"lines", "bluish_green", 1.2, 2}, {"yerrorbars", "vermilion", 0.7, 0, 7, 0.3}};
  const Style closed{"lines", "black", 1.2, 3};
  std::array<Panel, 2> profiles{left_panel(), right_panel()};
  for (std::size_t load = 0; load < 2; ++load) {
    Panel& panel = profiles[load];
    Range x, y;
    CsvTable table({"x: bead diameters", "sigma_zz: 1/bead", "sigma_xz: 1/bead", "sigma_xx: 1/bead",
                    "standard_error: 1/bead", "eta_sigma_zz: 1/bead"});
    for (std::size_t i = 0; i < shown.profile.x.size(); ++i) {
      const auto at = [&](std::size_t part) { return shown.profile.stress[load][part][i]; };
      table.add_row({shown.profile.x[i], at(0), at(1), at(2), at(3), at_depth.found[eta].value * at(0)});
      x.add(shown.profile.x[i]);
      for (std::size_t part = 0; part < 3; ++part) y.add(at(part));
    }
    const std::string file = plot.add_data(load == 0 ? "vertical" : "horizontal", table);
    panel.x = linear_axis("x  (bead diameters)", x, 6);
    panel.y = linear_axis(load == 0 ? "stress, load ↓" : "stress, load →", widened(y, 0.06), 6, y);
    panel.bottom = lower_row + 0.48;
    panel.name_height = 0.5;
    panel.add(file, "1:2", styles[0]);
    panel.add(file, "1:3", styles[1]);
    panel.add(file, "1:6", closed);
    panel.add(file, "1:4:5", styles[2]);
  }
  plot.add_key("σzz", styles[0]);
  plot.add_key("σxz", styles[1]);
  plot.add_key("σxx", Ink{"vermilion", 7}.points(0.5));
  plot.add_key("η σzz", closed);
  Panel share = left_panel(), ratio = right_panel();
  Range z, missed_range, ratio_range;
  ratio_range.add(1);
  missed_range.add(0);
  missed_range.add(elastic_share);
  for (const TensorResponse& one : measured) {
    CsvTable table({"z: bead diameters", "missed: dimensionless", "standard_error: dimensionless",
                    "missed_beside_gradient: dimensionless", "3_eta_over_kappa: dimensionless",
                    "standard_error: dimensionless"});
    for (const ClosureAtDepth& depth : one.depths) {
      if (!depth.found[eta].known()) continue;
      const double c2 = std::pow(one.c_thrust.value, 2);
      table.add_row({depth.z, depth.missed[vertical].value, depth.missed[vertical].standard_error,
                     depth.missed[beside].value, depth.found[eta].value / c2, depth.found[eta].standard_error / c2});
      z.add(depth.z);
      missed_range.add(depth.missed[vertical].value);
      missed_range.add(depth.missed[beside].value);
      ratio_range.add(depth.found[eta].value / c2, depth.found[eta].standard_error / c2);
    }
    if (table.empty()) continue;
    const Ink ink = ink_of_value(share.curves.size() / 2);
    const std::string file = plot.add_data("mu-" + exact(one.spec.sampler.mu), table);
    share.add(file, "1:2:3", ink.joined_bars(0.9, 0.5));
    share.add(file, "1:4", ink.line(0.8, 2));
    ratio.add(file, "1:5:6", ink.joined_bars(0.9, 0.5));
    plot.add_key("below: μ = " + caption_number(one.spec.sampler.mu), ink.joined(0.9, 0.5));
  }
  for (Panel* panel : {&share, &ratio}) {
    panel->top = upper + 0.12;
    panel->x = log_axis("depth z  (bead diameters)", widened_by_factor(z, 1.2));
  }
  share.y = linear_axis("share of σxx missed", widened(missed_range, 0.06), 6, missed_range);
  ratio.y = linear_axis("3 η / κ", widened(ratio_range, 0.08), 5, ratio_range);
  share.add_level(elastic_share, {"lines", "black", 1.0, 3});
  ratio.add_level(1, {"lines", "frame", 0.8});
  plot.panels = {profiles[0], profiles[1], share, ratio};
  return plot_figure(plot,
                     {"studies/tensor_response.captions",
                      {{"mu", caption_number(shown.spec.sampler.mu)},
                       {"z", fmt::format("{:.0f}", at_depth.z)},
                       {"eta", value_with_error(at_depth.found[eta])},
                       {"missed", percent(at_depth.missed[vertical])},
                       {"beside", percent(at_depth.missed[beside])},
                       {"elastic", fmt::format("{:.0f} %", 100 * elastic_share)}}},
                     run_folder);
}

class TensorResponseStudy final : public CopiedStudy<TensorResponseStudy> {
 public:
  std::string id() const override { return "tensor_response"; }

  std::vector<Key> keys() override {
    return {
        make_key(table(), "mu", "",
                 "friction coefficients at which all stresses below a vertical and below a horizontal point load "
                 "are measured, by the fluctuations of uniformly loaded piles; none: not at all",
                 mu_, friction_range_above_zero()),
        first_lag_key(table(), first_lag_),
        make_key(table(), "octaves", "octaves", "doublings of the depth, from first_lag on", octaves_,
                 KeyRange{}.within(0, most_octaves)),
        make_key(table(), "columns", "beads", "beads per layer of these piles", columns_),
        make_key(table(), "samples", "piles", "piles per friction coefficient, at least eight per block", samples_)};
  }

  bool asked() const override { return !mu_.empty(); }

  Problem find_problem(const MainLine& main) const override {
    const int deepest = first_lag_ << octaves_;
    if (const double least = columns_needed(mu_.back(), deepest); columns_ < least) {
      return problem(key("columns"),
                     "{} columns: at mu = {} the response goes around the ring within {} layers, so that its stresses "
                     "could not be told apart; give {:.0f} columns, or fewer octaves",
                     columns_, mu_.back(), deepest, std::ceil(least));
    }
    for (const StudyEnsemble& one : ensembles(main)) {
      if (auto found = find_lattice_problem(key("columns"), columns_, key("octaves"), one.spec.lattice.layers,
                                            bottom_margin + 1, drawing_memory(one.spec))) {
        return found;
      }
    }
    return find_samples_problem(key("samples"), samples_, main.response.blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const double mu : mu_) {
      EnsembleSpec spec = spec_of_lags(main.ensemble_at(mu, {columns_, 1}, samples_), first_lag_, octaves_);
      const std::vector<int> lags = std::move(spec.layers);
      spec.layers.clear();
      for (const int lag : lags) spec.layers.insert(spec.layers.end(), {lag, lag + 1});
      spec.lattice.layers += 1;
      all.push_back(
          {fmt::format("tensor response, mu = {}", mu), fmt::format("tensor-response-mu-{}", exact(mu)), spec});
    }
    return all;
  }

  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override {
    measured_.push_back(measure_tensor(ensemble));
  }

  Json json() const override { return measured_; }
  std::vector<ReportPart> parts() const override { return {table_part()}; }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    if (measured_.empty()) return {};
    return {[this](const std::filesystem::path& folder) { return plot_tensor(measured_, folder); }};
  }

 private:
  static constexpr int most_octaves = 8;

  std::vector<double> mu_;  ///< each above 0; empty: not measured
  int first_lag_ = 16, octaves_ = 3, columns_ = 240;
  std::uint64_t samples_ = 512;           ///< piles per friction coefficient
  std::vector<TensorResponse> measured_;  ///< ascending in mu
};

}  // namespace

std::unique_ptr<Study> tensor_response_study() { return std::make_unique<TensorResponseStudy>(); }

}  // namespace granuscope
