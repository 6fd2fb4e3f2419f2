#include <array>
#include <numbers>
#include <set>

#include "analysis/dispersion.h"
#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "ensemble/estimator.h"
#include "plot/plot.h"
#include "studies/spreading.h"
#include "studies/study.h"

// Green's tensor: the mean stresses under a point force that is vertical or horizontal, and whether a closure relation
// ties sigma_xx to the other two. Stresses of a layer are sums over the contacts that leave its beads, force times
// branch vector over the area of a bead, times the distance of neighbours; with a the angle of contacts
//   sigma_zz = V_R + V_L = w,   sigma_xz = H_R + H_L = H,   sigma_xx = tan(a) (H_R - H_L).
// Balance of horizontal forces hands H down, in Fourier modes exp(-i k x), x and k by columns, as
//   H_{n+1} = cos(k/2) H_n - i cot(a) sin(k/2) sigma_xx,n,
// so that sigma_xx follows from H in successive layers, in each pile and therefore in the mean: div sigma = 0. (Legs of
// the three-leg model lead to the next column, k for k/2.)
namespace granuscope {
namespace {

/// Beside a vertical one a horizontal one, or in its place, by loads, a torque of one bead radius: at 1, the load's
/// offset, whose response has the same symmetry.
enum PointLoad { vertical, horizontal, loads };
enum StressPart { zz, xz, xx, stresses };

/// One Fourier mode of Green's tensor at one depth. Under a vertical unit load sigma_zz and sigma_xx are real and
/// sigma_xz is i times the number here; under a horizontal one it is the other way round.
struct TensorMode {
  double times = 2;  ///< how often it counts: the mode 0 once, others with their mirror image
  double k = 0;      ///< 2 sin(k/2) over the distance of neighbours: what differences of neighbouring beads see
  std::array<std::array<double, stresses>, loads> under{};
};

/// The modes 0, 1, 2, ... that carry weight: without each block, and last without none.
using Tensors = std::vector<std::vector<TensorMode>>;

/// The share of sigma_xx that the best eta misses below a vertical load on an elastic half plane (Boussinesq):
/// sigma_zz ~ 1/(1 + t^2)^2 and sigma_xx ~ t^2/(1 + t^2)^2 of t = x/z, hence sqrt(4/5).
constexpr double elastic_share = 0.8944;

/// What closes the equations at one depth.
enum Coefficient { eta, eta_beside, nu, D_from_nu, coefficients };
using Closure = std::array<double, coefficients>;

/// StressPart per bead against x at one depth, in bead diameters.
struct StressProfile {
  std::vector<double> x;
  /// Empty below a load of which nothing is known.
  std::array<std::array<std::vector<Estimate>, stresses>, loads> under;
};

struct ClosureAtDepth {
  double z = 0;  ///< of the contacts between two layers, below the reference
  std::array<Estimate, coefficients> found;
  /// The share of sigma_xx, root mean square over x, that is missed: by eta below either load, and below the vertical
  /// one with a gradient.
  Estimate missed, missed_horizontal, missed_beside;
  Estimate D;  ///< of long waves, from the depth before
  StressProfile profile;
};

/// Which the excess of its loads bears, in bead radii times that excess; 0: they act through the centres.
double torque_of(const EnsembleSpec& spec) { return spec.sampler.lean_excess ? spec.sampler.load_offset : 0; }

struct TensorResponse {
  DeepMeasurement by = DeepMeasurement::fluctuations;
  EnsembleSpec spec;
  std::uint64_t samples = 0;
  Estimate c_thrust;
  std::vector<ClosureAtDepth> depths;

  bool has_couple() const { return by == DeepMeasurement::loads && torque_of(spec) != 0; }
  const char* second() const { return has_couple() ? "couple" : "horizontal"; }
  bool has(PointLoad load) const { return !shown().profile.under[load][zz].empty(); }
  /// The one that is shown: the second, if there are so many.
  const ClosureAtDepth& shown() const { return depths[depths.size() > 1 ? 1 : 0]; }
};

std::size_t row_of(const BlockSums& sums, int lag) {
  return static_cast<std::size_t>(std::ranges::find(sums.layers, lag) - sums.layers.begin());
}

/// Of all blocks but `left_out`, or of all: the four parts (correlation_parts) of what the modes 1, 2, ... of a layer
/// have to do with those of the lag 0, as far as they carry weight. Loads are layer 0 themselves: what they do to w is
/// even and to H odd in x, but for their torque, with which it is the other way round. Of that waves of one bead are
/// most, so that of such loads all modes are given.
std::vector<double> parts_at(const MeasuredEnsemble& ensemble, int lag, std::size_t left_out) {
  const BlockSums& sums = ensemble.record.sums;
  const std::size_t row = row_of(sums, lag);
  if (holds_propagation(sums)) return propagation_without(propagation_at(sums, row), left_out);
  const LayerSums of_w = sums.layer("correlation", row), of_H = sums.layer("correlation_H", row),
                  of_loads = sums.layer("correlation", 0);
  std::vector<double> w(of_w.width()), H(w), load(w), parts;
  for (std::size_t b = 0; b < of_w.blocks(); ++b) {
    if (b == left_out) continue;
    for (std::size_t i = 0; i < w.size(); ++i) {
      w[i] += of_w.block(b)[i];
      H[i] += of_H.block(b)[i];
      load[i] += of_loads.block(b)[i];
    }
  }
  const double offset = torque_of(ensemble.spec);
  const int modes = offset == 0 ? fluctuation_plan(ensemble.spec).modes[row] : (ensemble.spec.lattice.columns - 1) / 2;
  const auto by_torque = [&](double odd) { return offset == 0 ? 0 : odd / offset; };
  for (int m = 1; m <= modes; ++m) {
    // Spectra count whole beads; every other layer lies half a bead farther.
    const double half_k = sums.rows.shifted(lag) ? std::numbers::pi * m / static_cast<double>(w.size()) : 0;
    const std::size_t re = 2 * static_cast<std::size_t>(m) - 1, im = re + 1;
    const double cosine = std::cos(half_k) / load[re], sine = std::sin(half_k) / load[re];
    parts.insert(parts.end(), {cosine * w[re] + sine * w[im], lag == 0 ? 1.0 : by_torque(cosine * H[re] + sine * H[im]),
                               by_torque(cosine * w[im] - sine * w[re]), cosine * H[im] - sine * H[re]});
  }
  return parts;
}

/// Of all blocks but `left_out`, or of all, `lag` layers below the lag 0. `ratio`: sigma_xx over sigma_zz of the
/// longest wave, which the thrust ratio is.
std::vector<TensorMode> tensor_without(const MeasuredEnsemble& ensemble, int lag, std::size_t left_out, double ratio) {
  const std::vector<double> reference = parts_at(ensemble, 0, left_out), above = parts_at(ensemble, lag, left_out),
                            below = parts_at(ensemble, lag + 1, left_out);
  const BeadGeometry geometry(ensemble.spec.lattice.angle);
  const BlockSums& sums = ensemble.record.sums;
  const bool couple = !holds_propagation(sums) && torque_of(ensemble.spec) != 0;
  std::vector<TensorMode> modes{{1, 0, {{{1, 0, ratio}, {0, couple ? 0.0 : 1.0, 0}}}}};
  for (std::size_t at = 0; at < std::min({above.size(), below.size(), reference.size()}); at += correlation_parts) {
    const ModePropagator G = mode_propagator(&above[at], &reference[at]),
                         next = mode_propagator(&below[at], &reference[at]);
    const double half_k = std::numbers::pi * static_cast<double>(modes.size()) / ensemble.spec.lattice.columns *
                          (sums.rows.staggered ? 1 : 2);
    const double cosine = std::cos(half_k), sine = geometry.cotangent * std::sin(half_k);
    modes.push_back(
        {2,
         2 * std::sin(half_k) / geometry.twice_sine,
         {{{G.ww, G.Hw, (cosine * G.Hw - next.Hw) / sine}, {G.wH, G.HH, (next.HH - cosine * G.HH) / sine}}}});
  }
  return modes;
}

/// Least squares over x of sigma_xx = eta sigma_zz under a vertical load, and of sigma_xx = eta sigma_zz - nu d/dx
/// sigma_xz under both, the horizontal one counting as `weight` of the other. By mirror symmetry sigma_zz is even where
/// sigma_xz is odd, so that a term eta' sigma_xz comes out as 0. With it and sigma_zx = sigma_xz a wave is damped by
/// D = nu + sin(a)^2 (1 - eta/tan(a)^2)/cos(a) on this lattice.
Closure close_equations(const std::vector<TensorMode>& modes, double weight, const BeadGeometry& geometry) {
  double Z_Z = 0, Z_G = 0, G_G = 0, X_Z = 0, X_G = 0, plain = 0, of_plain = 0;
  for (const TensorMode& m : modes) {
    for (const PointLoad load : {vertical, horizontal}) {
      const auto& [Z, slope, X] = m.under[load];
      const double G = load == vertical ? m.k * slope : -m.k * slope, times = m.times * (load == vertical ? 1 : weight);
      Z_Z += times * Z * Z;
      Z_G += times * Z * G;
      G_G += times * G * G;
      X_Z += times * X * Z;
      X_G += times * X * G;
      if (load == horizontal) continue;
      plain += times * X * Z;
      of_plain += times * Z * Z;
    }
  }
  const double determinant = Z_Z * G_G - Z_G * Z_G;
  Closure found{};
  found[eta] = plain / of_plain;
  found[eta_beside] = (X_Z * G_G - X_G * Z_G) / determinant;
  found[nu] = (X_G * Z_Z - X_Z * Z_G) / determinant;
  found[D_from_nu] = found[nu] + (1 - found[eta_beside] * std::pow(geometry.cotangent, 2)) *
                                     std::pow(geometry.twice_sine, 2) / (2 * geometry.twice_cosine);
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

/// Below the loads from `first` to before `end`, at the beads of a layer, as far as `reach` from the load, in bead
/// diameters.
StressProfile profile_of(const Tensors& tensors, PointLoad first, PointLoad end, const EnsembleSpec& spec, bool shifted,
                         double reach) {
  const int columns = spec.lattice.columns;
  const double pitch = BeadGeometry(spec.lattice.angle).twice_sine;
  const int last = std::min(columns / 2, static_cast<int>(reach / pitch));
  StressProfile profile;
  for (int i = shifted ? -last - 1 : -last; i <= last; ++i) {
    const double x = shifted ? i + 0.5 : i;
    profile.x.push_back(pitch * x);
    // Of an even real spectrum, and of i times an odd one.
    std::vector<double> even, odd;
    for (std::size_t m = 0; m < tensors.back().size(); ++m) {
      const double angle = 2 * std::numbers::pi * x * static_cast<double>(m) / columns;
      even.push_back(std::cos(angle) / columns);
      odd.push_back(-std::sin(angle) / columns);
    }
    for (std::size_t load = first; load < end; ++load) {
      for (std::size_t stress = 0; stress < stresses; ++stress) {
        Replicated one;
        for (const auto& modes : tensors) {
          double sum = 0;
          for (std::size_t m = 0; m < std::min(modes.size(), even.size()); ++m) {
            sum +=
                modes[m].times * modes[m].under[load][stress] * ((load == vertical) == (stress == xz) ? odd : even)[m];
          }
          one.without_block.push_back(sum);
        }
        one.value = one.without_block.back();
        one.without_block.pop_back();
        profile.under[load][stress].push_back(estimate(one));
      }
    }
  }
  return profile;
}

/// From an ensemble that records these lags, or layers below loads, and the ones that follow.
TensorResponse measure_tensor(const MeasuredEnsemble& ensemble, DeepMeasurement by, const std::vector<int>& lags) {
  const BlockSums& sums = ensemble.record.sums;
  const auto blocks = static_cast<std::size_t>(sums.blocks());
  TensorResponse response{.by = by, .spec = ensemble.spec, .samples = sums.samples(), .c_thrust = {}, .depths = {}};
  const Replicated speed = thrust_speed(sums, by == DeepMeasurement::loads ? lags.front() : 0);
  const Replicated ratio = transform([](double c) { return c * c; }, speed);
  response.c_thrust = estimate(speed);
  const BeadGeometry geometry(ensemble.spec.lattice.angle);
  const double mu = like_at_30(ensemble.spec).mu, rough_D = std::pow(expected_width(mu, 1), 2) - 1;
  const std::string unknown = "no mode of the response carries weight";
  for (const int lag : lags) {
    ClosureAtDepth depth;
    depth.z = sums.rows.spacing * (lag + 0.5);
    Tensors tensors;
    std::vector<Closure> closures;
    for (std::size_t left_out = 0; left_out <= blocks; ++left_out) {
      const double of_waves = left_out < blocks ? ratio.without_block[left_out] : ratio.value;
      tensors.push_back(tensor_without(ensemble, lag, left_out, of_waves));
      closures.push_back(close_equations(tensors.back(), response.has_couple() ? 0 : of_waves, geometry));
    }
    for (std::size_t i = 0; i < coefficients; ++i) {
      Replicated number{closures.back()[i], {}};
      for (std::size_t b = 0; b < blocks; ++b) number.without_block.push_back(closures[b][i]);
      depth.found[i] = estimate(number, unknown);
    }
    const auto missed = [&](PointLoad load, auto told) {
      const auto rest = [&](const TensorMode& m, std::size_t b) { return m.under[load][xx] - told(m, closures[b]); };
      const auto all = [&](const TensorMode& m, std::size_t) { return m.under[load][xx]; };
      return estimate(transform([](double a, double b) { return std::sqrt(a / b); }, power_of(tensors, rest),
                                power_of(tensors, all)),
                      "no more than noise");
    };
    depth.missed =
        missed(vertical, [](const TensorMode& m, const Closure& c) { return c[eta] * m.under[vertical][zz]; });
    depth.missed_horizontal.reason = "its loads are vertical";
    if (by != DeepMeasurement::loads)
      depth.missed_horizontal =
          missed(horizontal, [](const TensorMode& m, const Closure& c) { return c[eta] * m.under[horizontal][zz]; });
    depth.missed_beside = missed(vertical, [](const TensorMode& m, const Closure& c) {
      return c[eta_beside] * m.under[vertical][zz] + c[nu] * m.k * m.under[vertical][xz];
    });
    // Waves that are not damped away by then.
    const double longest = geometry.twice_sine * std::sqrt(2 / (rough_D * depth.z));
    std::vector<BandOfModes> bands;
    if (by == DeepMeasurement::fluctuations) {
      const int before = response.depths.empty() ? 0 : lags[response.depths.size() - 1];
      bands = measure_dispersion(sums, row_of(sums, before), row_of(sums, lag), {0, longest},
                                 {response.c_thrust.value / geometry.twice_sine, rough_D});
    }
    depth.D = bands.empty() ? Estimate{.reason = by == DeepMeasurement::loads ? "loads do not measure it" : unknown}
                            : bands.front().D;
    depth.D.value *= std::pow(geometry.twice_sine, 2);
    depth.D.standard_error *= std::pow(geometry.twice_sine, 2);
    const bool of_forces = by != DeepMeasurement::loads, couple = response.has_couple();
    depth.profile =
        profile_of(tensors, couple ? horizontal : vertical, of_forces || couple ? loads : horizontal, ensemble.spec,
                   sums.rows.shifted(lag), speed.value * depth.z + 3 * expected_width(mu, depth.z));
    response.depths.push_back(depth);
  }
  return response;
}

void to_json(Json& json, const ClosureAtDepth& depth) {
  json = {{"z", depth.z},
          {"eta", depth.found[eta]},
          {"missed", depth.missed},
          {"missed_horizontal", depth.missed_horizontal},
          {"eta_beside_gradient", depth.found[eta_beside]},
          {"nu", depth.found[nu]},
          {"missed_beside_gradient", depth.missed_beside},
          {"D_from_nu", depth.found[D_from_nu]},
          {"D", depth.D}};
}

void to_json(Json& json, const TensorResponse& one) {
  const auto square = [](double c) { return c * c; };
  Estimate ratio = one.c_thrust;
  if (ratio.known()) ratio = {square(one.c_thrust.value), 2 * one.c_thrust.value * one.c_thrust.standard_error, ""};
  json = {{"mu", one.spec.sampler.mu},
          {"estimator", name_of(one.spec.response.estimator)},
          {"columns", one.spec.lattice.columns},
          {"layers", one.spec.lattice.layers},
          {"samples", one.samples},
          {"c_thrust_squared", ratio},
          {"depths", one.has_couple() ? Json::array() : Json(one.depths)},
          {"stresses", Json::array()}};
  if (one.by == DeepMeasurement::loads) json["by"] = one.has_couple() ? "couples" : "loads";
  // Where each load presses most.
  for (const ClosureAtDepth& depth : one.depths) {
    for (const auto& [symbol, load] : {std::pair("↓", vertical), {one.has_couple() ? "↻" : "→", horizontal}}) {
      if (!one.has(load)) continue;
      const auto& [pressure, shear, across] = depth.profile.under[load];
      const auto at =
          static_cast<std::size_t>(std::ranges::max_element(pressure, {}, &Estimate::value) - pressure.begin());
      constexpr double surest_noise = 4;  // standard errors, of the most out of hundreds of places
      if (!(pressure[at].value > surest_noise * pressure[at].standard_error)) continue;
      json["stresses"].push_back({{"z", depth.z},
                                  {"load", symbol},
                                  {"x", depth.profile.x[at]},
                                  {"zz", pressure[at]},
                                  {"xz", shear[at]},
                                  {"xx", across[at]}});
    }
  }
}

/// All stresses of all depths, with their errors.
CsvTable stress_table(const TensorResponse& one) {
  std::vector<std::string> columns{"z: bead diameters", "x: bead diameters"};
  for (const auto& [load, name] : {std::pair(vertical, "vertical"), {horizontal, one.second()}}) {
    if (!one.has(load)) continue;
    for (const char* const part : {"zz", "xz", "xx"}) {
      columns.push_back(fmt::format("sigma_{}_{}: 1/bead", part, name));
      columns.emplace_back("standard_error: 1/bead");
    }
  }
  CsvTable table(columns);
  for (const ClosureAtDepth& depth : one.depths) {
    for (std::size_t i = 0; i < depth.profile.x.size(); ++i) {
      std::vector<double> row{depth.z, depth.profile.x[i]};
      for (const PointLoad load : {vertical, horizontal}) {
        if (!one.has(load)) continue;
        for (const auto& part : depth.profile.under[load])
          row.insert(row.end(), {part[i].value, part[i].standard_error});
      }
      table.add_row(row);
    }
  }
  return table;
}

/// The stresses under both loads at the largest mu, under a torque, and beside them what a closure misses, by depth.
Figure plot_tensor(const std::vector<TensorResponse>& measured, const std::filesystem::path& run_folder) {
  const auto fluctuating =
      std::ranges::find(measured.rbegin(), measured.rend(), DeepMeasurement::fluctuations, &TensorResponse::by);
  const TensorResponse& shown = *fluctuating;
  const ClosureAtDepth& at_depth = shown.shown();
  if (!at_depth.found[eta].known()) {
    throw InputError(
        "the figure of the stresses has nothing to show: no mode of the response was followed; give more piles");
  }
  const auto percent = [](const Estimate& share) {
    return share.known() ? fmt::format("{:.0f} %", 100 * share.value) : "0 %";
  };
  Plot plot;
  plot.id = "tensor-response";
  plot.key = {.inches = 0.72, .lines = 4, .sample = 2, .entries = {}};
  const std::array<Style, 3> styles{
      Style{"lines", "bright_blue", 1.2}, {"lines", "light_blue", 1.2, 2}, {"yerrorbars", "dark_blue", 0.7, 0, 7, 0.3}};
  const Style closed{"lines", "black", 1.2}, elastic{"lines", "black", 1.0, 2};
  struct Shown {
    const TensorResponse* of;
    PointLoad load;
    const char *file, *axis;
  };
  std::vector<Shown> profiles{{&shown, vertical, "vertical", "σ, load along z"},
                              {&shown, horizontal, "horizontal", "σ, load along x"}};
  // Below a torque at the smallest mu, where noise hides it least.
  if (const auto couple = std::ranges::find_if(measured, &TensorResponse::has_couple); couple != measured.end())
    profiles.push_back({&*couple, horizontal, "torque", "σ, torque"});
  const double rows = static_cast<double>(profiles.size()), room = rows == 2 ? 4.1 : 5.2;
  plot.height = plot.key.inches + room;
  const auto place = [&](Panel& panel, double row, double of_rows) {
    panel.top = room * row / of_rows + 0.1;
    panel.bottom = room * (of_rows - 1 - row) / of_rows + 0.48;
    plot.panels.push_back(panel);
  };
  for (const auto& [one, load, name, axis] : profiles) {
    const double ratio = one->has_couple() ? std::pow(one->c_thrust.value, 2) : at_depth.found[eta].value;
    const StressProfile& profile = one->shown().profile;
    const auto& under = profile.under[load];
    Panel panel = left_panel();
    Range x, y;
    CsvTable table({"x: bead diameters", "sigma_zz: 1/bead", "sigma_xz: 1/bead", "sigma_xx: 1/bead",
                    "standard_error: 1/bead", "eta_sigma_zz: 1/bead"});
    for (std::size_t i = 0; i < profile.x.size(); ++i) {
      const auto at = [&](StressPart stress) { return under[stress][i].value; };
      table.add_row({profile.x[i], at(zz), at(xz), at(xx), under[xx][i].standard_error, ratio * at(zz)});
      x.add(profile.x[i]);
      for (const StressPart stress : {zz, xz, xx}) y.add(at(stress));
    }
    const std::string file = plot.add_data(name, table);
    panel.x = linear_axis("x  (bead diameters)", x, 6);
    panel.y = linear_axis(axis, widened(y, 0.06), 4, y);
    panel.texts.push_back({"μ = " + caption_number(one->spec.sampler.mu), 0.5, 0.88, "center", "black"});
    panel.add(file, "1:2", styles[0]);
    panel.add(file, "1:3", styles[1]);
    panel.add(file, "1:6", closed);
    panel.add(file, "1:4:5", styles[2]);
    place(panel, static_cast<double>(plot.panels.size()), rows);
  }
  plot.add_key("σzz", styles[0]);
  plot.add_key("σxz", styles[1]);
  plot.add_key("σxx", Ink{"dark_blue", 7}.points(0.5));
  plot.add_key("η σzz", closed);
  Panel share = right_panel(), ratio = right_panel();
  Range z, missed_range, ratio_range;
  ratio_range.add(1);
  missed_range.add(0);
  missed_range.add(elastic_share);
  std::size_t series = 0;
  bool loaded = false;
  for (const TensorResponse& one : measured) {
    if (one.has_couple()) {
      plot.add_data("stresses-couples-mu-" + exact(one.spec.sampler.mu), stress_table(one));
      continue;
    }
    CsvTable table({"z: bead diameters", "missed: dimensionless", "standard_error: dimensionless",
                    "missed_beside_gradient: dimensionless", "eta_over_c_thrust_squared: dimensionless",
                    "standard_error: dimensionless"});
    for (const ClosureAtDepth& depth : one.depths) {
      if (!depth.found[eta].known()) continue;
      const double c2 = std::pow(one.c_thrust.value, 2);
      table.add_row({depth.z, depth.missed.value, depth.missed.standard_error, depth.missed_beside.value,
                     depth.found[eta].value / c2, depth.found[eta].standard_error / c2});
      z.add(depth.z);
      missed_range.add(depth.missed.value);
      missed_range.add(depth.missed_beside.value);
      ratio_range.add(depth.found[eta].value / c2, depth.found[eta].standard_error / c2);
    }
    if (table.empty()) continue;
    const bool by_loads = one.by == DeepMeasurement::loads;
    if (!by_loads) ++series;
    const Ink ink = ink_of_value(series - 1);
    const std::string mu = (by_loads ? "loads-mu-" : "mu-") + exact(one.spec.sampler.mu),
                      file = plot.add_data(mu, table);
    plot.add_data("stresses-" + mu, stress_table(one));
    const std::string told = "μ = " + caption_number(one.spec.sampler.mu) + (by_loads ? ", by loads" : "");
    share.add(file, "1:2:3", ink.joined_bars(0.9, 0.5, by_loads ? 3 : 0), told);
    if (!by_loads) share.add(file, "1:4", ink.joined(0.8, 0.2, 2));
    ratio.add(file, "1:5:6", ink.joined_bars(0.9, 0.5, by_loads ? 3 : 0), told);
    if (!by_loads) plot.add_key(told, ink.joined(0.9, 0.5));
    loaded = loaded || by_loads;
  }
  if (loaded) plot.add_key("by loads", {.colour = "frame", .width = 0.9, .dash = 3});
  plot.add_key("with a gradient", {.colour = "frame", .width = 0.8, .dash = 2});
  plot.add_key("elastic half plane", elastic);
  share.x = ratio.x = log_axis("depth z  (bead diameters)", widened_by_factor(z, 1.2));
  share.y = linear_axis("share of σxx missed", widened(missed_range, 0.06), 6, missed_range);
  ratio.y = linear_axis("η / (c₀² κ)", widened(ratio_range, 0.08), 5, ratio_range);
  share.add_level(elastic_share, elastic);
  ratio.add_level(1, {"lines", "frame", 0.8});
  place(share, 0, 2);
  place(ratio, 1, 2);
  return plot_figure(plot,
                     {"studies/tensor_response.captions",
                      {{"mu", caption_number(shown.spec.sampler.mu)},
                       {"z", fmt::format("{:.0f}", at_depth.z)},
                       {"eta", value_with_error(at_depth.found[eta])},
                       {"missed", percent(at_depth.missed)},
                       {"beside", percent(at_depth.missed_beside)},
                       {"torque", rows == 2 ? "" : caption_number(profiles.back().of->spec.sampler.mu)},
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
        make_key(table(), "loaded_mu", "",
                 "those of mu that are measured once more by vertical loads: estimator multiplexed, each pile and its "
                 "opposite",
                 loaded_mu_, friction_range_above_zero()),
        make_key(table(), "couple_mu", "",
                 "those of mu that are measured once more by vertical loads whose excess acts beside the centres, for "
                 "the stresses below a torque",
                 couple_mu_, friction_range_above_zero()),
        first_lag_key(table(), first_lag_),
        make_key(table(), "octaves", "octaves", "doublings of the depth, from first_lag on", octaves_,
                 KeyRange{}.within(0, most_octaves)),
        make_key(table(), "columns", "beads", "beads per layer of these piles", columns_),
        make_key(table(), "samples", "piles", "piles per friction coefficient, at least eight per block", samples_)};
  }

  bool asked() const override { return !mu_.empty(); }
  bool suits_any_angle() const override { return true; }

  Problem find_problem(const MainLine& main) const override {
    if (auto found = find_check_problem(key("loaded_mu"), loaded_mu_, key("mu"), mu_)) return found;
    if (auto found = find_check_problem(key("couple_mu"), couple_mu_, key("mu"), mu_)) return found;
    if (!couple_mu_.empty() && main.lattice.angle != usual_angle)
      return problem(key("couple_mu"), "torques are known at 30 degrees only; leave lattice.angle at that");
    for (const StudyEnsemble& one : ensembles(main)) {
      if (const double least = columns_needed(like_at_30(one.spec), lags().back()); columns_ < least) {
        return problem(key("columns"),
                       "{} columns: at mu = {} the response goes around the ring within {} layers, so that its "
                       "stresses could not be told apart; give {:.0f} columns, or fewer octaves",
                       columns_, one.spec.sampler.mu, lags().back(), std::ceil(least));
      }
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
      EnsembleSpec spec =
          spec_of_lags(main.ensemble_at(mu, {columns_, 1, main.lattice.angle}, samples_), first_lag_, octaves_);
      std::set<int> layers;
      for (const int lag : spec.layers) layers.insert({lag, lag + 1});
      spec.layers.assign(layers.begin(), layers.end());
      spec.lattice.layers += 1;
      const auto add = [&](DeepMeasurement by, const char* label, const char* file) {
        all.push_back({fmt::format("tensor response{}, mu = {}", label, mu),
                       fmt::format("tensor-response{}-mu-{}", file, exact(mu)),
                       spec_of_check(spec, by, main.response.epsilon), static_cast<int>(by)});
      };
      add(DeepMeasurement::fluctuations, "", "");
      if (std::ranges::find(loaded_mu_, mu) != loaded_mu_.end()) add(DeepMeasurement::loads, " to loads", "-loads");
      if (std::ranges::find(couple_mu_, mu) == couple_mu_.end()) continue;
      add(DeepMeasurement::loads, " to couples", "-couples");
      // Far beside the centre and thus small, since loads of other sizes turn beads, too, and the response is linear
      // only far below what friction bears, T of each upper contact being mu N: at an eighth of that.
      EnsembleSpec& couples = all.back().spec;
      couples.sampler.lean_excess = true;
      couples.sampler.load_offset = largest_offset;
      couples.response.epsilon = mu / (4 * sqrt3 * largest_offset);
    }
    return all;
  }

  void add(const StudyEnsemble& one, const MeasuredEnsemble& ensemble) override {
    measured_.push_back(measure_tensor(ensemble, static_cast<DeepMeasurement>(one.part), lags()));
  }

  Json json() const override { return measured_; }
  std::vector<ReportPart> parts() const override { return {part()}; }

  std::vector<FigurePlot> figures(const Analysis&) const override { return figures_of(measured_, plot_tensor); }

 private:
  static constexpr int most_octaves = 8;
  static constexpr double largest_offset = 2;  ///< of a load, bead radii

  std::vector<int> lags() const {
    std::vector<int> all;
    for (int octave = 0; octave <= octaves_; ++octave) all.push_back(first_lag_ << octave);
    return all;
  }

  std::vector<double> mu_, loaded_mu_, couple_mu_;  ///< each above 0; empty: not measured
  int first_lag_ = 16, octaves_ = 3, columns_ = 240;
  std::uint64_t samples_ = 512;           ///< piles per friction coefficient
  std::vector<TensorResponse> measured_;  ///< ascending in mu, by loads behind what they check
};

}  // namespace

std::unique_ptr<Study> tensor_response_study() { return std::make_unique<TensorResponseStudy>(); }

}  // namespace granuscope
