#include "report/summary_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "report/clean_json.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const FailedSample& failed) {
  Json json;
  json["sample"] = failed.sample;
  json["layer"] = failed.layer;
  json["replay"] = failed.replay;
  return json;
}

Json to_json(const DepthFit& fit) {
  Json json;
  json["layer"] = fit.layer;
  json["z"] = fit.z;
  json["peak_position"] = to_json(fit.peak_position);
  json["width"] = to_json(fit.width);
  json["width_squared"] = to_json(fit.width_squared);
  json["thrust_ratio"] = to_json(fit.thrust_ratio);
  json["peak_height"] = to_json(fit.peak_height);
  json["two_peaks"]["delta_chi2_one_gaussian"] = finite_or_null(fit.evidence.against_one_gaussian);
  json["two_peaks"]["delta_chi2_one_peak"] = finite_or_null(fit.evidence.for_two_peaks);
  if (!std::isfinite(fit.evidence.for_two_peaks)) {
    json["two_peaks"]["reason"] = fit.reason.empty() ? "the profile is exact: nothing was fitted" : fit.reason;
  }
  json["chi2_per_dof"] = finite_or_null(fit.degrees_of_freedom > 0 ? fit.chi2_per_dof : std::nan(""));
  json["degrees_of_freedom"] = fit.degrees_of_freedom;
  json["fitted_area"] = to_json(fit.fitted_area);
  json["centre_background"] = to_json(fit.centre_background);
  json["misfit"] = fit.misfit;
  json["misfit_at_least"] = fit.misfit_at_least;
  json["identifiable"] = fit.identifiable;
  if (!fit.identifiable || json["chi2_per_dof"].is_null()) {
    json["reason"] = fit.reason.empty() ? "nothing was fitted at this depth" : fit.reason;
  }
  return json;
}

Json to_json(const FitVariation& variation);
Json to_json(const ScalingVariation& variation);
Json to_json(const Transport& result);
Json to_json(const ScalingFits& fits);
Json to_json(const RatioScaling& ratios);
Json to_json(const Claim& claim);
Json to_json(const Figure& figure);

template <typename Item>
Json list_of(const std::vector<Item>& items) {
  Json json = Json::array();
  for (const Item& item : items) json.push_back(to_json(item));
  return json;
}

Json to_json(const Exponents& exponents) {
  Json json;
  json["position"] = to_json(exponents.position);
  json["width_squared"] = to_json(exponents.width);
  json["amplitude"] = to_json(exponents.amplitude);
  json["noise"] = to_json(exponents.noise);
  return json;
}

Json to_json(const FitVariation& variation) {
  Json json;
  json["change"] = variation.change;
  if (variation.depths > 0) json["window_layers"] = variation.layers;
  json["depths"] = variation.depths;
  json["c"] = to_json(variation.c);
  json["D"] = to_json(variation.D);
  json["c_shift"] = to_json(variation.c_shift);
  json["D_shift"] = to_json(variation.D_shift);
  return json;
}

Json to_json(const Transport& result) {
  Json json;
  const SamplerSpec& sampler = result.spec.sampler;
  if (sampler.model.has_contacts()) json["mu"] = sampler.mu;
  json[result.scan->name] = result.scanned();
  json["law"] = law_of(sampler);
  json.update(granuscope::to_json(result.spec.response));
  json["samples"] = result.samples;
  json["failed"] = list_of(result.failed);
  json["exact"] = result.exact;
  if (result.precision.asked) {
    json["precision"]["c"] = result.precision.c > 0 ? Json(result.precision.c) : Json(nullptr);
    json["precision"]["D"] = result.precision.D > 0 ? Json(result.precision.D) : Json(nullptr);
    json["precision"]["reached"] = result.precision.reached;
    json["precision"]["reason"] =
        result.precision.reason.empty() ? "a null was not asked for" : result.precision.reason;
    if (result.precision.reached && result.precision.c > 0 && result.precision.D > 0) json["precision"].erase("reason");
  }
  json["c"] = to_json(result.c);
  json["D"] = to_json(result.D);
  json["alpha_thrust"] = to_json(result.alpha_thrust);
  json["c_thrust"] = to_json(result.c_thrust);
  json["c_minus_c_thrust"] = to_json(result.c_minus_c_thrust);
  json["position_offset"] = to_json(result.position_offset);
  json["width_offset"] = to_json(result.width_offset);
  json["peak_separation"] = to_json(result.peak_separation);
  json["exponents"] = to_json(result.exponents);
  json["position_line"] = to_json(result.position_line);
  json["width_line"] = to_json(result.width_line);
  json["window_layers"] = result.window_layers;
  json["depths_in_window"] = result.depths_in_window;
  json["variations"] = list_of(result.variations);
  json["fitted_area"] = to_json(result.fitted_area);
  json["centre_background"] = to_json(result.centre_background);
  json["c_beside_background"] = to_json(result.c_beside);
  json["D_beside_background"] = to_json(result.D_beside);
  json["chi2_per_dof"] = finite_or_null(result.chi2_per_dof);
  json["chi2_beside_background_per_dof"] = finite_or_null(result.chi2_beside_per_dof);
  json["largest_misfit"] = result.largest_misfit;
  json["depths"] = list_of(result.depths);
  json["sampler"]["draws_per_bead"] = finite_or_null(result.draws_per_bead);
  json["sampler"]["repaired_per_bead"] = finite_or_null(result.repaired_per_bead);
  json["sampler"]["backtracked_per_bead"] = finite_or_null(result.backtracked_per_bead);
  json["sampler"]["rounded_per_bead"] = finite_or_null(result.rounded_per_bead);
  if (result.chained) {
    json["sampler"]["effective_samples"] = to_json(result.effective_samples);
    json["sampler"]["burn_in"] = result.burn_in;
    json["sampler"]["thinning"] = result.thinning;
  }
  if (json["sampler"]["draws_per_bead"].is_null()) json["sampler"]["reason"] = "no pile was completed";
  return json;
}

Json to_json(const ScalingFit& fit) {
  Json json = to_json(fit.exponent);
  json["window"] = fit.window;
  json["points"] = fit.points;
  json["about_law"] = to_json(fit.scatter);
  json["power_law"] = fit.exponent.known() ? Json(!fit.misses_the_points()) : Json(nullptr);
  json["ln_prefactor"] = to_json(fit.intercept);
  json["running"] = to_json(fit.running);
  return json;
}

Json to_json(const ScalingFits& fits) {
  Json json;
  json["beta"] = to_json(fits.beta);
  json["gamma"] = to_json(fits.gamma);
  json["alpha"] = to_json(fits.alpha);
  return json;
}

Json to_json(const ScalingVariation& variation) {
  Json json;
  json["change"] = variation.change;
  json.update(to_json(variation.fits));
  json["beta_shift"] = to_json(variation.beta_shift);
  json["gamma_shift"] = to_json(variation.gamma_shift);
  json["alpha_shift"] = to_json(variation.alpha_shift);
  return json;
}

Json to_json(const RatioScaling& ratios) {
  Json json;
  json["layer"] = ratios.layer;
  json["z"] = ratios.z;
  json.update(to_json(ratios.fits));
  json["from_load"] = to_json(ratios.from_load);
  return json;
}

Json to_json(const Claim& claim) {
  const bool paper_known = std::isfinite(claim.paper);
  Json json;
  json["id"] = claim.id;
  json["statement"] = claim.statement;
  json["verdict"] = claim.verdict;
  json["expected"] = claim.expected.empty() ? Json(nullptr) : Json(claim.expected);
  json["quantity"] = claim.quantity;
  json["measured"] = finite_or_null(claim.measured.value);
  json["stderr"] = claim.measured.known() ? finite_or_null(claim.measured.standard_error) : Json(nullptr);
  if (std::isfinite(claim.measured.systematic)) json["systematic"] = claim.measured.systematic;
  json["paper"] = paper_known ? Json(claim.paper) : Json(nullptr);
  json["paper_stderr"] = paper_known ? finite_or_null(claim.paper_error) : Json(nullptr);
  json["tolerance"] = claim.tolerance;
  json["z_score"] = claim.measured.known() ? finite_or_null(claim.z_score) : Json(nullptr);
  if (!claim.measured.known()) {
    json["reason"] = stated(claim.measured.reason);
  } else if (json["z_score"].is_null() || json["stderr"].is_null() || !paper_known) {
    json["reason"] = "the claim is decided by its own test, not by a pull";
  }
  json["rival"] = nullptr;
  if (claim.measured.known() && std::isfinite(claim.rival)) {
    json["rival"] = {{"name", claim.rival_name}, {"value", claim.rival}};
    json["rival"]["distance"] = finite_or_null(claim.rival_distance);
    if (!std::isfinite(claim.rival_distance)) json["rival"]["reason"] = "the measured value has no error";
  } else if (!json.contains("reason")) {
    json["reason"] = "no rival value is held against this one";
  }
  json["explanation"] = claim.explanation;
  json["remarks"] = claim.remarks;
  return json;
}

Json to_json(const Figure& figure) {
  Json json;
  json["id"] = figure.id;
  json["title"] = figure.title;
  json["caption"] = figure.caption;
  json["details"] = figure.details;
  return json;
}

}  // namespace

std::string summary_json(const ReportData& data) {
  Json json;
  json["schema"] = 3;
  json["experiment"] = data.experiment_name;
  json["experiment_key"] = data.resolved_experiment_key;
  json["columns"] = data.columns;
  json["layers"] = data.layers;
  json["seed"] = data.seed;
  json["overload"] = data.overload;
  const ScanParameter& scan = *data.analysis.scan;
  const SamplerSpec sampler =
      data.analysis.results.empty() ? SamplerSpec{} : data.analysis.results.front().spec.sampler;
  json["scan"] = {{"model", name_of(sampler.model.name)},
                  {"parameter", scan.name},
                  {"symbol", scan.symbol},
                  {"meaning", scan.meaning}};
  // What defines c and D beside their window, whatever the estimator: ModeWeights::by_width
  // (analysis/shape_fit.h), depth_weights (analysis/transport.h) and the exponents, which count all friction
  // coefficients alike.
  json["weights"] = {{"modes", "exp(-k^2 (W^2 + 1)/4)"},
                     {"depths", "1/z^2"},
                     {"exponents", "equal"},
                     {"varied_to", {{"modes", "equal"}}}};
  json["results"] = list_of(data.analysis.results);
  json["mean_exponents"] = to_json(data.analysis.mean_exponents);
  json["mean_position_offset"] = to_json(data.analysis.mean_position_offset);
  json["scaling"] = to_json(data.analysis.scaling);
  json["scaling"]["variations"] = list_of(data.analysis.variations);
  json["scaling"]["other_windows"] = list_of(data.analysis.other_windows);
  json["scaling"]["by_ratio"] = list_of(data.analysis.by_ratio);
  json["studies"] = data.studies;
  json["claims"] = list_of(data.analysis.claims);
  json["figures"] = list_of(data.figures);
  clean_strings(json);
  return json.dump(2) + "\n";
}

}  // namespace granuscope
