#include "report/summary_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "report/clean_json.h"

namespace granuscope {
void to_json(Json& json, const FailedSample& failed) {
  json["sample"] = failed.sample;
  json["layer"] = failed.layer;
  json["replay"] = failed.replay;
}

void to_json(Json& json, const DepthFit& fit) {
  json["layer"] = fit.layer;
  json["z"] = fit.z;
  json["peak_position"] = fit.peak_position;
  json["width"] = fit.width;
  json["width_squared"] = fit.width_squared;
  json["thrust_ratio"] = fit.thrust_ratio;
  json["peak_height"] = fit.peak_height;
  json["two_peaks"]["delta_chi2_one_gaussian"] = finite_or_null(fit.evidence.against_one_gaussian);
  json["two_peaks"]["delta_chi2_one_peak"] = finite_or_null(fit.evidence.for_two_peaks);
  if (!std::isfinite(fit.evidence.for_two_peaks)) {
    json["two_peaks"]["reason"] = fit.reason.empty() ? "the profile is exact: nothing was fitted" : fit.reason;
  }
  json["chi2_per_dof"] = finite_or_null(fit.degrees_of_freedom > 0 ? fit.chi2_per_dof : std::nan(""));
  json["degrees_of_freedom"] = fit.degrees_of_freedom;
  json["fitted_area"] = fit.fitted_area;
  json["centre_background"] = fit.centre_background;
  json["misfit"] = fit.misfit;
  json["misfit_at_least"] = fit.misfit_at_least;
  json["identifiable"] = fit.identifiable;
  if (!fit.identifiable || json["chi2_per_dof"].is_null()) {
    json["reason"] = fit.reason.empty() ? "nothing was fitted at this depth" : fit.reason;
  }
}

void to_json(Json& json, const Exponents& exponents) {
  json["position"] = exponents.position;
  json["width_squared"] = exponents.width;
  json["amplitude"] = exponents.amplitude;
  json["noise"] = exponents.noise;
}

void to_json(Json& json, const FitVariation& variation) {
  json["change"] = variation.change;
  if (variation.depths > 0) json["window_layers"] = variation.layers;
  json["depths"] = variation.depths;
  json["c"] = variation.c;
  json["D"] = variation.D;
  json["c_shift"] = variation.c_shift;
  json["D_shift"] = variation.D_shift;
}

void to_json(Json& json, const Transport& result) {
  const SamplerSpec& sampler = result.spec.sampler;
  if (sampler.model.has_contacts()) json["mu"] = sampler.mu;
  json[result.scan->name] = result.scanned();
  if (result.spec.lattice.angle != usual_angle)
    json.update({{"angle", result.spec.lattice.angle}, {"c0", result.c0()}});
  json["law"] = law_of(sampler);
  json.update(Json(result.spec.response));
  if (json.contains("overloads")) json["overloads"] = overloads_of(result.spec);
  json["samples"] = result.samples;
  json["failed"] = result.failed;
  json["exact"] = result.exact;
  if (result.precision.asked) {
    json["precision"]["c"] = result.precision.c > 0 ? Json(result.precision.c) : Json(nullptr);
    json["precision"]["D"] = result.precision.D > 0 ? Json(result.precision.D) : Json(nullptr);
    json["precision"]["reached"] = result.precision.reached;
    json["precision"]["reason"] =
        result.precision.reason.empty() ? "a null was not asked for" : result.precision.reason;
    if (result.precision.reached && result.precision.c > 0 && result.precision.D > 0) json["precision"].erase("reason");
  }
  json["c"] = result.c;
  json["D"] = result.D;
  json["alpha_thrust"] = result.alpha_thrust;
  json["c_thrust"] = result.c_thrust;
  json["c_minus_c_thrust"] = result.c_minus_c_thrust;
  json["position_offset"] = result.position_offset;
  json["width_offset"] = result.width_offset;
  json["peak_separation"] = result.peak_separation;
  json["exponents"] = result.exponents;
  json["position_line"] = result.position_line;
  json["width_line"] = result.width_line;
  json["window_layers"] = result.window_layers;
  json["depths_in_window"] = result.depths_in_window;
  json["variations"] = result.variations;
  json["fitted_area"] = result.fitted_area;
  json["centre_background"] = result.centre_background;
  json["c_beside_background"] = result.c_beside;
  json["D_beside_background"] = result.D_beside;
  json["chi2_per_dof"] = finite_or_null(result.chi2_per_dof);
  json["chi2_beside_background_per_dof"] = finite_or_null(result.chi2_beside_per_dof);
  json["largest_misfit"] = result.largest_misfit;
  json["depths"] = result.depths;
  json["sampler"]["draws_per_bead"] = finite_or_null(result.draws_per_bead);
  json["sampler"]["repaired_per_bead"] = finite_or_null(result.repaired_per_bead);
  json["sampler"]["backtracked_per_bead"] = finite_or_null(result.backtracked_per_bead);
  json["sampler"]["rounded_per_bead"] = finite_or_null(result.rounded_per_bead);
  if (result.chained) {
    json["sampler"]["effective_samples"] = result.effective_samples;
    json["sampler"]["burn_in"] = result.burn_in;
    json["sampler"]["thinning"] = result.thinning;
    if (!result.flat.means.empty()) json["sampler"]["flat_law"] = result.flat;
  }
  if (json["sampler"]["draws_per_bead"].is_null()) json["sampler"]["reason"] = "no pile was completed";
}

void to_json(Json& json, const ScalingFit& fit) {
  json = fit.exponent;
  json["window"] = fit.window;
  json["points"] = fit.points;
  json["about_law"] = fit.scatter;
  json["power_law"] = fit.exponent.known() ? Json(!fit.misses_the_points()) : Json(nullptr);
  json["ln_prefactor"] = fit.intercept;
  json["running"] = fit.running;
}

void to_json(Json& json, const ScalingFits& fits) {
  json["beta"] = fits.beta;
  json["gamma"] = fits.gamma;
  json["alpha"] = fits.alpha;
}

void to_json(Json& json, const ScalingVariation& variation) {
  json["change"] = variation.change;
  json.update(Json(variation.fits));
  json["beta_shift"] = variation.beta_shift;
  json["gamma_shift"] = variation.gamma_shift;
  json["alpha_shift"] = variation.alpha_shift;
}

void to_json(Json& json, const OtherReading& reading) {
  json["id"] = reading.id;
  json["label"] = reading.label;
  json.update(Json(reading.fits));
}

void to_json(Json& json, const Claim& claim) {
  const bool paper_known = std::isfinite(claim.paper);
  json["id"] = claim.id;
  json["statement"] = claim.statement;
  json["beyond_paper"] = claim.beyond_paper;
  if (!claim.power_law) json["power_law"] = false;
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
}

void to_json(Json& json, const Figure& figure) {
  json["id"] = figure.id;
  json["title"] = figure.title;
  json["caption"] = figure.caption;
  json["details"] = figure.details;
}

std::string summary_json(const ReportData& data) {
  Json json;
  json["schema"] = summary_schema;
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
  json["results"] = data.analysis.results;
  json["mean_exponents"] = data.analysis.mean_exponents;
  json["mean_position_offset"] = data.analysis.mean_position_offset;
  json["scaling"] = data.analysis.scaling;
  json["scaling"]["variations"] = data.analysis.variations;
  json["scaling"]["other_windows"] = data.analysis.other_windows;
  json["scaling"]["readings"] = data.analysis.readings;
  json["studies"] = data.studies;
  json["claims"] = data.analysis.claims;
  json["figures"] = data.figures;
  clean_strings(json);
  return json.dump(2) + "\n";
}

}  // namespace granuscope
