#include "studies/model_classes/results.h"

#include <map>

#include "analysis/claims.h"
#include "plot/bead_forces.h"
#include "plot/growing_panel.h"
#include "plot/plot.h"

namespace granuscope {
namespace {
/// How much of c0 - c the mean must give to explain it. Named by no paper.
constexpr double nearly_all = 0.1;

/// Of the classes, not of what has figures of its own.
template <class Use>
void for_each(const std::vector<ModelSeries>& series, const std::string& model, Use use) {
  for (const ModelSeries& one : series) {
    if (one.aside) continue;
    for (const ModelResponse& response : one.responses) {
      if (response.model == model) use(one, response);
    }
  }
}

void judge_growth(const std::vector<ModelSeries>& series, std::vector<Claim>& claims) {
  const ModelResponse* nearest = nullptr;
  const auto distance = [](const ModelResponse& one) {
    return (2 - one.width_exponent.value) / one.width_exponent.standard_error;
  };
  bool measured = false;
  for_each(series, "frictional-beads", [&](const ModelSeries&, const ModelResponse& one) {
    measured = true;
    if (!one.width_exponent.known()) return;
    if (nearest == nullptr || distance(one) < distance(*nearest)) nearest = &one;
  });
  if (!measured) return;
  Claim claim = open_claim("models-not-elastic", "The width of the response does not scale as in an elastic medium.",
                           "power of z in W² of the beads");
  if (nearest == nullptr) {
    leave_open(claim, "the power of z in W² is not known for any friction coefficient: ask for more samples");
  } else {
    judge_by_exclusion(
        claim, nearest->width_exponent, {.value = 1}, {2, "elastic"},
        fmt::format("The power of z in W² at {}, where it is nearest to 2 in its errors,", nearest->parameter));
  }
  claims.push_back(std::move(claim));
}

/// Root of the mean square distance from below the load, W of one Gaussian and sqrt(x_p^2 + W^2) of two, at z by the
/// slopes.
Estimate reach_at(const ModelResponse& one, double z) {
  Estimate reach;
  const double c = one.peaks == 2 ? one.c.value : 0;
  reach.value = std::sqrt(c * c * z * z + one.D.value * z);
  const double c_error = one.peaks == 2 ? one.c.standard_error : 0;
  reach.standard_error = std::hypot(c * z * z * c_error, z * one.D.standard_error / 2) / reach.value;
  return reach;
}

void judge_q_model(const std::vector<ModelSeries>& series, std::vector<Claim>& claims) {
  const ModelResponse *q_model = nullptr, *beads = nullptr;
  bool single = true;
  for_each(series, "q-model", [&](const ModelSeries&, const ModelResponse& one) {
    q_model = &one;
    single = single && one.peaks == 1;
  });
  for_each(series, "frictional-beads", [&](const ModelSeries&, const ModelResponse& one) {
    if (one.c.known() && one.D.known()) beads = &one;
  });
  if (q_model == nullptr || beads == nullptr) return;
  Claim claim = open_claim("q-model-too-narrow", "The response of the q-model is a single peak, and too narrow.",
                           "root mean square distance of the q-model’s response from below the load, over the beads’");
  if (!q_model->D.known()) {
    leave_open(claim, "the width of the q-model is not known: " + q_model->D.reason);
  } else {
    const double z = std::min(q_model->z[1], beads->z[1]);
    const Estimate narrow = reach_at(*q_model, z), wide = reach_at(*beads, z);
    Estimate ratio;
    ratio.value = narrow.value / wide.value;
    ratio.standard_error =
        ratio.value * std::hypot(narrow.standard_error / narrow.value, wide.standard_error / wide.value);
    judge_by_exclusion(claim, ratio, {.value = 0}, {1, "as wide"},
                       fmt::format("The ratio to the beads at {} and z = {:.0f}", beads->parameter, z));
    if (ratio.value > 1 && claim.verdict == reproduced) claim.verdict = not_reproduced;
    if (!single) claim.verdict = not_reproduced;
    add_sentence(claim, single ? "It has one peak under every law of q." : "Under some law of q it has two peaks.");
  }
  claims.push_back(std::move(claim));
}

void judge_scaling(const std::vector<ModelSeries>& series, std::vector<Claim>& claims) {
  const ModelSeries *beads = nullptr, *osl = nullptr;
  for_each(series, "frictional-beads", [&](const ModelSeries& one, const ModelResponse&) { beads = &one; });
  for_each(series, "stochastic-osl", [&](const ModelSeries& one, const ModelResponse&) { osl = &one; });
  if (beads == nullptr) return;
  Claim claim = open_claim("models-c-of-D", "c₀ − c of the beads does not follow D as the stochastic theory has it.",
                           "exponent of c₀ − c against D of the beads, linear response");
  if (!beads->alpha.exponent.known()) {
    leave_open(claim, "the exponent is not known: " + beads->alpha.exponent.reason);
  } else {
    judge_by_exclusion(claim, beads->alpha.exponent, {.value = 0.4, .error = 0.01}, {1, "stochastic theory"},
                       "The exponent");
    if (osl != nullptr && osl->alpha.exponent.known()) {
      const Estimate& alpha = osl->alpha.exponent;
      add_sentence(claim, "Stochastic OSL itself has {} by the same fits.", value_with_error(alpha));
    }
  }
  claims.push_back(std::move(claim));
}

void judge_mean(const std::vector<ModelSeries>& series, std::vector<Claim>& claims) {
  const ModelResponse* widest = nullptr;
  for_each(series, "three-leg", [&](const ModelSeries& one, const ModelResponse& response) {
    if (one.name == "three-leg, positive") widest = &response;
  });
  if (widest == nullptr) return;
  Claim claim = open_claim("mean-of-noise", "A noise with a finite mean explains the propagation coefficient.",
                           "share of c₀ − c that the mean share of the middle leg gives by itself");
  if (!widest->share_of_mean.known()) {
    leave_open(claim, "the share is not known: " + widest->share_of_mean.reason);
  } else {
    judge_by_number(claim, widest->share_of_mean, {.value = 1, .tolerance = nearly_all}, Rival{0, "fluctuations alone"},
                    fmt::format("The share in the three-leg model whose legs push, {},", widest->parameter));
    if (widest->c.known()) {
      add_sentence(claim, "There c = {}, and c₀ √(1 − ⟨p⟩) = {}.", value_with_error(widest->c),
                   value_with_error(widest->c_of_middle));
    }
  }
  claims.push_back(std::move(claim));
}

}  // namespace

std::vector<Claim> judge_models(const std::vector<ModelSeries>& series) {
  std::vector<Claim> claims;
  judge_growth(series, claims);
  judge_q_model(series, claims);
  judge_scaling(series, claims);
  judge_mean(series, claims);
  return claims;
}

namespace {

Estimate exact_or_unknown(double value) {
  return std::isfinite(value) ? Estimate{.value = value, .standard_error = 0, .reason = ""}
                              : Estimate{.reason = "no exact value is known"};
}

Json noise_json(const ModelResponse& one) {
  const std::optional<NoiseTheory>& theory = one.theory;
  if (!theory) return nullptr;
  const double squared = theory->disorder * theory->disorder;
  return {{"disorder", theory->disorder},
          {"disorder_squared", squared},
          {"c0", theory->c0},
          {"D0", theory->D0},
          {"kappa", theory->wide.kappa},
          {"spreading", theory->wide.spreading},
          {"narrow", theory->narrow && one.width < theory->cell},
          {"thrust_loss", one.thrust_loss},
          {"thrust_loss_expected", theory->wide.kappa * squared},
          {"speed_loss", one.speed_loss},
          {"speed_loss_expected", theory->shift(one.width).kappa * squared},
          {"spreading_gain", one.spreading_gain},
          {"spreading_gain_expected", theory->shift(one.width).spreading * squared}};
}

}  // namespace

void to_json(Json& json, const StressAtDepth& one) {
  json = {{"z", one.z},
          {"weight", one.weight},
          {"thrust_ratio", one.thrust_ratio},
          {"weight_variance", one.weight_variance}};
}

void to_json(Json& json, const TractionDepth& one) {
  json = {
      {"middle", one.middle}, {"noise", one.noise}, {"columns", one.columns}, {"samples", one.samples}, {"z", one.z}};
}

void to_json(Json& json, const DeepModel& one) {
  json = {{"series", one.series}, {"parameter", one.parameter}, {"shapes", one.shapes}};
  const Json spreading = one.response;
  for (const char* key : {"estimator", "columns", "layers", "samples", "lags", "octaves", "dispersion", "c_thrust"}) {
    json[key] = spreading.at(key);
  }
}

void to_json(Json& json, const ModelResponse& one) {
  Json chi2 = Json::object();
  for (const ResponseShape shape : all_response_shapes) {
    chi2[name_of(shape)] = finite_or_null(one.fits[static_cast<std::size_t>(shape)].chi2);
  }
  const auto of = [&](ResponseShape shape) { return one.fits[static_cast<std::size_t>(shape)].chi2; };
  const double elastic = std::min(of(ResponseShape::isotropic), of(ResponseShape::orthotropic));
  const double gaussian = std::min(of(ResponseShape::one_gaussian), of(ResponseShape::two_gaussians));
  const std::size_t colon = std::min(one.verdict.find(": "), one.verdict.size());
  json = {{"series", one.series},
          {"model", one.model},
          {"parameter", one.parameter},
          {"bead_weight", one.bead_weight},
          {"samples", one.samples},
          {"window_layers", one.layers},
          {"window_z", one.z},
          {"peaks", one.peaks},
          {"c", one.c},
          {"c_expected", exact_or_unknown(one.c_expected)},
          {"noise", noise_json(one)},
          {"D", one.D},
          {"D_expected", exact_or_unknown(one.D_expected)},
          {"c0_minus_c", one.slowing},
          {"c_thrust", one.c_thrust},
          {"width_exponent", one.width_exponent},
          {"shape", name_of(one.shape)},
          {"chi2", chi2},
          {"chi2_against_elastic", std::round(elastic - gaussian)},
          {"class", one.verdict.substr(0, colon)},
          {"why", colon < one.verdict.size() ? one.verdict.substr(colon + 2) : ""},
          {"middle", one.middle},
          {"c_of_middle", one.c_of_middle},
          {"share_of_mean", one.share_of_mean},
          {"traction", one.traction},
          {"stress", one.stress}};
}

Json models_json(const MeasuredModels& measured) {
  Json responses = Json::array(), exponents = Json::array();
  for (const ModelSeries& series : measured.series) {
    for (const ModelResponse& one : series.responses) {
      responses.push_back(one);
      responses.back()["aside"] = series.aside;
    }
    if (series.aside) continue;
    exponents.push_back({{"series", series.name}, {"points", series.alpha.points}, {"alpha", series.alpha.exponent}});
  }
  return {
      {"responses", responses}, {"exponents", exponents}, {"tractions", measured.tractions}, {"deep", measured.deep}};
}

Json models_page_1(const Json& results) {
  constexpr double roughest = 0.2;  // standard error of a power of z that is told
  const std::string base = "/studies/model_classes";
  std::vector<std::string> by_peaks[2], exponents;
  std::string least, most, fastest, slowest, last;
  const auto value = [&results](const std::string& pointer) {
    return results.at(Json::json_pointer(pointer)).at("value");
  };
  const auto place = [&](std::string& chosen, const std::string& pointer, double sign) {
    const Json& candidate = value(pointer);
    if (!candidate.is_number()) return;
    if (chosen.empty() || sign * candidate.get<double>() > sign * value(chosen).get<double>()) chosen = pointer;
  };
  for (std::size_t i = 0; i < results.at("responses").size(); ++i) {
    const Json& one = results.at("responses")[i];
    if (one.at("aside")) continue;
    const std::string pointer = fmt::format("/responses/{}", i);
    const std::size_t peaks = one.at("peaks") == 1 ? 0 : 1;
    std::vector<std::string>& alike = by_peaks[peaks];
    if (one.at("series") != last || alike.empty()) alike.push_back(base + pointer);
    last = one.at("series");
    place(least, pointer + "/share_of_mean", -1);
    place(most, pointer + "/share_of_mean", 1);
    const Json& power = one.at("width_exponent");
    if (!power.at("value").is_number() || power.at("stderr").get<double>() > roughest) continue;
    place(slowest, pointer + "/width_exponent", -1);
    place(fastest, pointer + "/width_exponent", 1);
  }
  for (std::size_t i = 0; i < results.at("exponents").size(); ++i) {
    const std::string pointer = fmt::format("/exponents/{}", i);
    if (value(pointer + "/alpha").is_number()) exponents.push_back(base + pointer);
  }
  const auto pair = [&](const std::string& low, const std::string& high) {
    return low.empty() ? Json(nullptr) : Json{{"low", {{"key", base + low}}}, {"high", {{"key", base + high}}}};
  };
  return {{"told_apart", !by_peaks[0].empty() && !by_peaks[1].empty()},
          {"one_peak", enumerated(by_peaks[0])},
          {"two_peaks", enumerated(by_peaks[1])},
          {"some_exponents", !exponents.empty()},
          {"exponents", enumerated(exponents)},
          {"widths", pair(slowest, fastest)},
          {"shares", pair(least, most)}};
}

namespace {

struct Panels {
  Panel slowing = left_panel(), profiles = right_panel();
  std::vector<std::string> exponents;
  std::vector<KeyEntry> theory;
  Range D, c, height;
  double shallowest = 0, deepest = 0;  ///< of the profiles
};

void add_slowing(Plot& plot, Panels& panels, const ModelSeries& series, const std::string& name, const Ink& ink) {
  CsvTable table({"D: bead diameters", "standard_error: bead diameters", "c0_minus_c: dimensionless",
                  "standard_error: dimensionless"});
  for (const ModelResponse& one : series.responses) {
    if (!one.slowing.known() || !(one.slowing.value > one.slowing.standard_error) ||
        !(one.D.value > one.D.standard_error))
      continue;
    table.add_row({one.D.value, one.D.standard_error, one.slowing.value, one.slowing.standard_error});
    panels.D.add(one.D.value);
    panels.c.add(one.slowing.value);
  }
  if (table.empty()) return;
  Style style = ink.joined_bars(1, 0.55);
  style.with = "xyerrorlines";
  panels.slowing.add(plot.add_data(name, table), "1:3:2:4", style);
  if (series.alpha.exponent.known()) {
    panels.exponents.push_back(fmt::format("{} ({})", value_with_error(series.alpha.exponent), series.name));
  }
}

/// c0 - c against D by the theory of the noise of a series, as far as the series goes.
void add_theory(Plot& plot, Panels& panels, const ModelSeries& series, const std::string& name, const Ink& ink) {
  CsvTable table({"D: bead diameters", "c0_minus_c: dimensionless"});
  for (const ModelResponse& one : series.responses) {
    if (!one.theory || one.theory->D0 > 0 || !one.slowing.known()) continue;
    table.add_row({one.D_expected, one.speed_without_disorder - one.c_expected});
  }
  if (table.empty()) return;
  panels.slowing.add(plot.add_data(name + "-theory", table), "1:2", ink.line(1.2, 2));
  panels.theory = {{"theory of " + series.name, ink.line(1.2, 2)}};
}

void add_profile(Plot& plot, Panels& panels, const ModelResponse& one, const std::string& name, const Ink& ink) {
  if (!one.profile) return;
  const ResponseProfile& profile = *one.profile;
  CsvTable table({"x_over_z: dimensionless", "z_response: dimensionless", "standard_error: dimensionless",
                  "x: bead diameters", "response: per bead"});
  for (std::size_t i = 0; i < profile.x.size(); ++i) {
    const double x = profile.x[i] / profile.z;
    if (std::abs(x) > 1) continue;
    table.add_row(
        {x, profile.z * profile.pressure[i], profile.z * profile.standard_error[i], profile.x[i], profile.pressure[i]});
    panels.height.add(profile.z * profile.pressure[i]);
  }
  panels.profiles.add(plot.add_data(name + "-profile", table), "1:2", ink.line(1.2));
  panels.shallowest = panels.deepest == 0 ? profile.z : std::min(panels.shallowest, profile.z);
  panels.deepest = std::max(panels.deepest, profile.z);
}

}  // namespace

Figure plot_models(const std::vector<ModelSeries>& series, const std::string& study,
                   const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "model-classes";
  plot.height = 3.3;
  plot.key = {.inches = 0.72, .lines = 3, .entries = {}};
  Panels panels;
  panels.height.add(0);
  std::vector<std::string> shown;
  for (std::size_t k = 0; k < series.size(); ++k) {
    if (series[k].aside) continue;
    const std::string name = std::to_string(k + 1);
    const Ink ink = ink_of_series(k);
    add_slowing(plot, panels, series[k], name, ink);
    add_theory(plot, panels, series[k], name, ink);
    const ModelResponse& last = series[k].responses.back();
    add_profile(plot, panels, last, name, ink);
    plot.add_key(series[k].name, ink.joined(1, 0.55));
    shown.push_back(last.parameter.empty() ? last.series : fmt::format("{} at {}", last.series, last.parameter));
  }
  if (panels.slowing.curves.empty() || panels.profiles.curves.empty()) {
    throw InputError(
        "the figure of the models has nothing to show, because no model with two peaks was measured; ask for "
        "parameters at which the width of the peaks can be told");
  }
  plot.key.entries.insert(plot.key.entries.end(), panels.theory.begin(), panels.theory.end());
  Panel &slowing = panels.slowing, &profiles = panels.profiles;
  slowing.x = log_axis("D  (bead diameters)", widened_by_factor(panels.D, 1.4));
  slowing.y = log_axis("c₀ − c", widened_by_factor(panels.c, 1.4));
  profiles.x = {"x/z", -1, 1, false, {{"−1", -1}, {"−0.5", -0.5}, {"0", 0}, {"0.5", 0.5}, {"1", 1}}};
  const Range& height = panels.height;
  profiles.y = linear_axis("z P(x, z)", {height.low - 0.03 * height.size(), height.high + 0.05 * height.size(), false},
                           6, height);
  for (const double x : {tan30, -tan30}) {
    profiles.arrows.push_back({x, 0, x, 1, "first", false, {.colour = "frame", .dash = 3}});
  }
  plot.panels = {slowing, profiles};
  return plot_figure(plot,
                     {"studies/" + study + ".captions",
                      {{"shown", enumeration(shown)},
                       {"exponents", enumeration(panels.exponents)},
                       {"depths", panels.shallowest == panels.deepest
                                      ? caption_number(panels.deepest)
                                      : caption_number(panels.shallowest) + " to " + caption_number(panels.deepest)}}},
                     run_folder);
}

namespace {

Style dots(std::size_t colour) { return ink_of_series(colour).bars(1, 0.6); }
Style joined_points(std::size_t colour) { return ink_of_series(colour).joined_bars(1, 0.55); }
Style line(std::size_t colour) { return ink_of_series(colour).line(1); }

/// What one series adds to the figure of the noise.
struct NoiseRows {
  CurveRows thrust, speed, spreading;
  NoiseTheory theory;  ///< of the strongest noise
  bool narrow = false;
};

NoiseRows noise_rows(const ModelSeries& series) {
  NoiseRows rows;
  for (const ModelResponse& one : series.responses) {
    if (!one.theory || !one.speed_loss.known() || !one.thrust_loss.known()) continue;
    const double x = one.theory->disorder * one.theory->disorder;
    if (one.theory->disorder == rows.theory.disorder) return {};  // grids of one noise have no law in it
    rows.thrust.push_back({x, one.thrust_loss.value, one.thrust_loss.standard_error});
    rows.speed.push_back({x, one.speed_loss.value, one.speed_loss.standard_error});
    rows.spreading.push_back({x, one.spreading_gain.value, one.spreading_gain.standard_error});
    rows.theory = *one.theory;
    rows.narrow = one.theory->narrow && one.width < one.theory->cell;
  }
  return rows;
}

}  // namespace

Figure plot_noise(const std::vector<ModelSeries>& series, const std::filesystem::path& run_folder) {
  Plot plot = two_panels("model-noise");
  GrowingPanel loss{"Δ²", "1 − c²/c₀²"}, gain{"Δ²", "D − D₀  (bead diameters)"};
  for (GrowingPanel* panel : {&loss, &gain}) panel->x.add(0), panel->y.add(0);
  std::vector<std::string> factors;
  std::size_t colour = 0;
  for (const ModelSeries& one : series) {
    const NoiseRows rows = noise_rows(one);
    if (rows.thrust.size() < 2) continue;
    const double end = rows.thrust.back()[0];
    const auto add = [&](GrowingPanel& panel, const std::string& what, const CurveRows& rows_of_it, double slope,
                         const std::string& column) {
      const std::string name = fmt::format("{}-{}", colour, what), x = "disorder_squared: dimensionless";
      panel.add(plot, name, rows_of_it, dots(colour), x, column);
      panel.add(plot, name + "-theory", {{0, 0, 0}, {end, slope * end, 0}}, line(colour), x, column);
    };
    const NoiseShift& of_peaks = rows.narrow ? *rows.theory.narrow : rows.theory.wide;
    add(loss, "thrust", rows.thrust, rows.theory.wide.kappa, "thrust_loss: dimensionless");
    plot.add_key(one.name + ": thrust", ink_of_series(colour).points(0.6));
    ++colour;
    add(loss, "speed", rows.speed, of_peaks.kappa, "speed_loss: dimensionless");
    add(gain, "spreading", rows.spreading, of_peaks.spreading, "D_gain: bead diameters");
    plot.add_key(one.name + ": peaks", ink_of_series(colour).points(0.6));
    ++colour;
    factors.push_back(fmt::format("κ = {:.3g} for long waves, {:.3g} and D − D₀ = {:.3g} Δ² for these peaks ({})",
                                  rows.theory.wide.kappa, of_peaks.kappa, of_peaks.spreading, one.name));
  }
  return plot_panels(plot, loss, gain, {{"factors", enumeration(factors)}}, run_folder);
}

Figure plot_middle(const std::vector<ModelSeries>& series, const std::vector<TractionDepth>& tractions,
                   const std::filesystem::path& run_folder) {
  Plot plot = two_panels("model-middle");
  GrowingPanel speed{"mean share ⟨p⟩ of the middle leg", "c"},
      depth{"mean share p of the middle leg", "depth of tractions  (bead diameters)", true};
  std::size_t colour = 0;
  const std::string middle = "mean_middle: dimensionless";
  for (const ModelSeries& one : series) {
    CurveRows rows;
    for (const ModelResponse& response : one.responses) {
      if (one.aside || !response.middle.known() || !response.c.known()) continue;
      rows.push_back({response.middle.value, response.c.value, response.c.standard_error});
    }
    if (rows.empty()) continue;
    ++colour;
    speed.add(plot, fmt::format("{}-speed", colour), rows, dots(colour), middle, "c: dimensionless");
    plot.add_key(one.name, ink_of_series(colour).points(0.6));
  }
  CurveRows mean_alone;
  for (int k = 0; k <= 40; ++k) {
    const double p = speed.x.low + speed.x.size() * k / 40;
    mean_alone.push_back({p, tan30 * std::sqrt(1 - p), 0});
  }
  speed.add(plot, "mean-alone", mean_alone, line(0), middle, "c: dimensionless");
  plot.add_key("c₀ √(1 − ⟨p⟩)", line(0));
  std::map<int, CurveRows> by_noise;  // in per cent of the mean
  for (const TractionDepth& one : tractions) {
    if (!one.z.known()) continue;
    by_noise[static_cast<int>(std::lround(100 * one.noise / one.middle))].push_back(
        {one.middle, one.z.value, one.z.standard_error});
  }
  for (const auto& [noise, rows] : by_noise) {
    ++colour;
    depth.add(plot, fmt::format("tractions-{}", noise), rows, joined_points(colour), "middle: dimensionless",
              "depth: bead diameters");
    plot.add_key(fmt::format("p ± {} %", noise), ink_of_series(colour).joined(1, 0.55));
  }
  return plot_panels(plot, speed, depth, {{"columns", fmt::format("{}", tractions.front().columns)}}, run_folder);
}

Figure render_pile_of(const ModelSeries& series, const std::filesystem::path& run_folder) {
  constexpr double depth = 40;  // bead diameters: two pictures share a row of the printed report
  constexpr double darkest = 3;
  const ModelResponse& one = series.responses.back();
  const RowGeometry rows = rows_of(one.sampler.model);
  WeightsPicture picture;
  picture.id = "pile-of-";
  for (const char letter : series.name) {
    if (letter == ' ' || letter == ',') {
      if (picture.id.back() != '-') picture.id += '-';
    } else {
      picture.id += letter;
    }
  }
  picture.pile.sampler = one.sampler;
  picture.pile.lattice = {64, static_cast<int>((depth - rows.depth(0)) / rows.spacing) + 1 + bottom_margin};
  picture.pile.load = Load::uniform;
  picture.depth = depth;
  picture.scene = ForceChainSpec{}.scene;
  picture.scene.backend = "none";  // no window of a GL context for so little
  picture.scene.range = {{0, darkest}};
  picture.wording = {"studies/model_pile.captions",
                     {{"series", series.name},
                      {"parameter", one.parameter},
                      {"columns", std::to_string(picture.pile.lattice.columns)},
                      {"seed", std::to_string(one.sampler.seed)}}};
  picture.redraw = "cp experiment.toml again.toml && granuscope run again.toml --out . --only analyse --only plot";
  SceneStatistics statistics;
  return render_weights(picture, run_folder, statistics);
}

Figure plot_gravity(const std::vector<ModelSeries>& series, const std::filesystem::path& run_folder) {
  Plot plot = two_panels("model-gravity");
  GrowingPanel stress{"depth z  (bead diameters)", "stresses  (loads of one top bead)", true},
      profile{"x/z", "z P(x, z)"};
  const ModelResponse* light = nullptr;
  double deepest = 0;
  std::size_t colour = 0;
  const auto add = [&](const ModelResponse& one) {
    CurveRows horizontal, vertical, response;
    for (const StressAtDepth& at : one.stress) {
      if (!at.thrust_ratio.known()) continue;
      horizontal.push_back({at.z, at.weight * at.thrust_ratio.value, at.weight * at.thrust_ratio.standard_error});
      vertical.push_back({at.z, at.weight, 0});
    }
    const std::string name = fmt::format("g-{}", exact(one.bead_weight)), z_column = "z: bead diameters";
    stress.add(plot, name + "-horizontal", horizontal, dots(colour), z_column, "three_sigma_xx: loads of one top bead");
    stress.add(plot, name + "-vertical", vertical, line(colour), z_column, "sigma_zz: loads of one top bead");
    // Where less is known of the peaks the response is lost in the noise of what beads weigh.
    constexpr double most_uncertain = 0.01;
    if (one.profile && one.c.known() && one.c.standard_error < most_uncertain) {
      const double z = deepest = one.profile->z;
      for (std::size_t i = 0; i < one.profile->x.size(); ++i) {
        if (std::abs(one.profile->x[i]) < z) {
          response.push_back({one.profile->x[i] / z, z * one.profile->pressure[i], 0});
        }
      }
      profile.add(plot, name + "-response", response, line(colour), "x_over_z: dimensionless",
                  "z_response: dimensionless");
    }
    plot.add_key(fmt::format("g = {}", one.bead_weight), ink_of_series(colour).joined(1, 0.55));
    ++colour;
  };
  for (const ModelSeries& one : series) {
    for (const ModelResponse& response : one.responses) {
      if (!one.aside && !response.stress.empty()) light = &response;  // that of the largest mu
    }
  }
  if (light != nullptr) add(*light);
  for (const ModelSeries& one : series) {
    for (const ModelResponse& response : one.responses) {
      if (response.bead_weight > 0) add(response);
    }
  }
  return plot_panels(plot, stress, profile,
                     {{"parameter", light == nullptr ? "" : light->parameter}, {"depth", caption_number(deepest)}},
                     run_folder);
}

}  // namespace granuscope
