#include "analysis/claims.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/scaling.h"
#include "model/lattice.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// What the paper claims of its beads as friction varies says nothing of another model, or of another parameter.
Claim of_friction(const Analysis& analysis, const Claim& claim) {
  const SamplerSpec sampler = analysis.results.empty() ? SamplerSpec{} : analysis.results.front().spec.sampler;
  if (analysis.scan == &friction_parameter() && sampler.model.is_beads()) return claim;
  Claim open = open_claim(claim.id, claim.statement, claim.quantity);
  leave_open(open, "it is about the friction of beads, and this experiment varies the {} of the model {}",
             analysis.scan->label(), name_of(sampler.model.name));
  return open;
}

/// What sets the beads of an experiment apart from the paper's, which its claims are about; empty if nothing does.
std::string other_beads(const Analysis& analysis) {
  if (analysis.angle() != usual_angle) {
    return fmt::format("it is about contacts at {} degrees, and those of this experiment stand at {}", usual_angle,
                       analysis.angle());
  }
  for (const Transport& result : analysis.results) {
    const SamplerSpec& sampler = result.spec.sampler;
    if (!sampler.model.is_beads()) continue;
    if (sampler.load_angle != 0 || sampler.load_offset != 0) {
      return "it is about upright loads through the centres of the top beads, and those of this experiment are not";
    }
    if (sampler.bead_weight != 0) return "it is about weightless beads, and those of this experiment have weight";
    const ResponseSpec& response = result.spec.response;
    if (loads_one_bead(response.estimator) && response.overload > 1)
      return fmt::format("it is about an overload of one load of a top bead, and not of {}", response.overload);
  }
  return {};
}

}  // namespace

std::vector<Claim> judge_claims(const Analysis& analysis, const FitSpec& fit, const ClaimSpec& spec) {
  if (const std::string why = other_beads(analysis); !why.empty()) {
    std::vector<Claim> claims = judge_claims({}, fit, spec);
    for (Claim& claim : claims) {
      claim = open_claim(claim.id, claim.statement, claim.quantity);
      leave_open(claim, "{}", why);
    }
    return claims;
  }
  return {of_friction(analysis, judge_frictionless(analysis)),
          of_friction(analysis, judge_double_peak(analysis, fit, spec)),
          of_friction(analysis, judge_two_gaussians(analysis, fit, spec)),
          judge_linear_position(analysis, spec),
          judge_diffusive_width(analysis, spec),
          judge_amplitude(analysis, spec),
          judge_no_elastic_scaling(analysis, spec),
          of_friction(analysis, judge_closer_and_wider(analysis, fit)),
          of_friction(analysis, judge_c_of_mu(analysis)),
          of_friction(analysis, judge_D_of_mu(analysis)),
          of_friction(analysis, judge_c_of_D(analysis)),
          of_friction(analysis, judge_differs_from_theory(analysis)),
          judge_noise(analysis, spec)};
}

void expect_verdicts(std::vector<Claim>& claims, const std::map<std::string, std::string>& expected) {
  for (Claim& claim : claims) {
    if (const auto verdict = expected.find(claim.id); verdict != expected.end()) claim.expected = verdict->second;
  }
}

std::vector<std::string> unexpected_results(const Analysis& analysis) {
  std::vector<std::string> sentences;
  for (const Claim& claim : analysis.claims) {
    if (claim.expected.empty() || claim.expected == claim.verdict) continue;
    sentences.push_back(fmt::format("{} is \"{}\" where the experiment expects \"{}\": {}", claim.id, claim.verdict,
                                    claim.expected, claim.explanation));
  }
  for (const Transport& one : analysis.results) {
    if (!one.failed.empty()) {
      sentences.push_back(fmt::format("at {} = {} averages do without {} of {} piles, which could not be completed",
                                      one.scan->name, one.scanned(), one.failed.size(),
                                      one.failed.size() + one.samples));
    }
    if (!one.precision.asked || one.precision.reached) continue;
    sentences.push_back(fmt::format("the precision asked for was not reached at {} = {}: {}", one.scan->name,
                                    one.scanned(), one.precision.reason));
  }
  return sentences;
}

std::vector<std::string> claim_ids() {
  // What is decided from nothing measured has every id.
  std::vector<std::string> ids;
  for (const Claim& claim : judge_claims({}, {}, {})) ids.push_back(claim.id);
  return ids;
}

namespace {

double in_errors(double distance, double error) {
  // Without any error only the exact number agrees.
  if (error > 0) return distance / error;
  return distance == 0. ? 0. : std::copysign(std::numeric_limits<double>::infinity(), distance);
}

/// Of the values as far off the paper's as must be detected, the one nearer to the measured.
Rival detectable_deviation(const PaperNumber& paper, double measured) {
  const double off = std::copysign(deviation_to_detect * std::abs(paper.value), measured - paper.value);
  return {paper.value + off, fmt::format("{} % off", significant(100 * deviation_to_detect, 2))};
}

/// An exponent of points that keep to no power has the same digits everywhere, and its error a word of warning.
std::string number_in_words(const Claim& claim) {
  const Estimate& measured = claim.measured;
  std::string number = claim.power_law
                           ? value_with_error(measured)
                           : fmt::format("{} (the scatter of the piles alone: ± {})", significant(measured.value, 3),
                                         significant(measured.standard_error, 2));
  if (measured.systematic > 0 && measured.standard_error > 0) {
    number += fmt::format(" with a systematic error of {}", significant(measured.systematic, 2));
  }
  return number;
}

std::string rival_in_words(const Claim& claim, const char* unit = "") {
  return fmt::format("{}{} from {} ({})", significant(std::abs(claim.rival_distance), 2), unit,
                     significant(claim.rival, 2), claim.rival_name);
}

void take_unmeasured(Claim& claim, const std::string& what) {
  claim.verdict = not_tested;
  if (claim.measured.reason.empty()) claim.measured.reason = "the experiment does not contain it";
  claim.explanation = fmt::format("{} could not be measured: {}.", what, claim.measured.reason);
}

}  // namespace

double total_error(const Estimate& measured) {
  return std::hypot(measured.standard_error, std::isfinite(measured.systematic) ? measured.systematic : 0.0);
}

NumberVerdict judge_number(const Estimate& measured, const PaperNumber& paper, const std::optional<Rival>& rival) {
  const Rival other = rival ? *rival : detectable_deviation(paper, measured.value);
  if (!measured.known() || !std::isfinite(measured.standard_error))
    return {not_tested, std::nan(""), other, std::nan("")};
  const double error = std::hypot(total_error(measured), paper.tolerance);
  const double z = in_errors(measured.value - paper.value, std::hypot(error, paper.error));
  const double rival_distance = in_errors(measured.value - other.value, error);
  if (std::abs(z) > agreement) return {not_reproduced, z, other, rival_distance};
  return {std::abs(rival_distance) > agreement ? reproduced : not_decided, z, other, rival_distance};
}

Claim open_claim(const std::string& id, const std::string& statement, const std::string& quantity) {
  Claim claim;
  claim.id = id;
  claim.statement = statement;
  claim.quantity = quantity;
  claim.paper = claim.z_score = claim.rival = claim.rival_distance = std::nan("");
  return claim;
}

void leave_open(Claim& claim, const std::string& reason) {
  claim.verdict = not_tested;
  claim.measured = {};
  claim.measured.reason = reason;
  claim.explanation = reason + ".";
  // Sentences begin with a capital, symbols (c, D, c_thrust, Greek letters) stay as they are.
  const std::string word = reason.substr(0, reason.find(' '));
  const bool plain = std::ranges::all_of(word, [](char c) { return c >= 'a' && c <= 'z'; });
  char& first = claim.explanation.front();
  if (plain && (word.size() > 1 || word == "a")) first = static_cast<char>(first - 'a' + 'A');
}

void judge_by_number(Claim& claim, const Estimate& measured, const PaperNumber& paper,
                     const std::optional<Rival>& rival, const std::string& what) {
  const NumberVerdict judged = judge_number(measured, paper, rival);
  claim.measured = measured;
  claim.paper = paper.value;
  claim.paper_error = paper.error;
  claim.tolerance = paper.tolerance;
  claim.verdict = judged.verdict;
  claim.z_score = judged.z_score;
  if (!measured.known()) return take_unmeasured(claim, what);
  claim.rival = judged.rival.value;
  claim.rival_name = judged.rival.name;
  claim.rival_distance = judged.rival_distance;
  const std::string held_against =
      claim.beyond_paper ? "the " + significant(paper.value, 2) + " of this test" : "the paper’s value";
  claim.explanation = fmt::format("{} is {}, {} combined errors {} {} and {}", what, number_in_words(claim),
                                  significant(std::abs(judged.z_score), 2), judged.z_score > 0 ? "above" : "below",
                                  held_against, rival_in_words(claim));
  claim.explanation +=
      claim.verdict == not_decided ? fmt::format("; {}.", cost_of_deciding(measured, paper, claim.rival)) : ".";
}

void judge_by_exclusion(Claim& claim, const Estimate& measured, const PaperNumber& paper, const Rival& rival,
                        const std::string& what) {
  claim.measured = measured;
  if (!measured.known() || !std::isfinite(measured.standard_error)) return take_unmeasured(claim, what);
  const double error = std::hypot(total_error(measured), paper.tolerance);
  const double from_paper = in_errors(measured.value - paper.value, error);
  claim.tolerance = paper.tolerance;
  claim.rival = rival.value;
  claim.rival_name = rival.name;
  claim.rival_distance = in_errors(measured.value - rival.value, error);
  claim.verdict = std::abs(claim.rival_distance) > agreement ? reproduced
                  : std::abs(from_paper) > agreement         ? not_reproduced
                                                             : not_decided;
  claim.explanation =
      fmt::format("{} is {}, {}", what, number_in_words(claim), rival_in_words(claim, " combined errors"));
  claim.explanation +=
      claim.verdict == not_decided ? fmt::format("; {}.", cost_of_deciding(measured, paper, claim.rival)) : ".";
}

void add_sentence(Claim& claim, const std::string& sentence) {
  if (sentence.empty()) return;
  std::string& text = claim.explanation.empty() ? claim.explanation : claim.remarks;
  if (!text.empty()) text += ' ';
  text += sentence;
}

std::string cost_of_deciding(const Estimate& measured, const PaperNumber& paper, double rival) {
  const double systematic = std::isfinite(measured.systematic) ? measured.systematic : 0;
  const double room =
      std::pow((rival - paper.value) / agreement, 2) - systematic * systematic - paper.tolerance * paper.tolerance;
  if (!(room > 0)) return "more piles do not decide it, since the systematic error alone hides the difference";
  return more_piles(measured.standard_error * measured.standard_error / room);
}

std::string more_piles(double factor) {
  if (factor < 1.05) return "somewhat more piles would decide it";
  if (!(factor < 1000)) return "more than a thousand times as many piles would be needed";
  return fmt::format("about {} times as many piles would decide it", significant(factor, 2));
}

std::string list_of_values(const std::vector<double>& values, const std::string& symbol) {
  constexpr std::size_t most_listed = 4;
  if (values.size() > most_listed) {
    return fmt::format("{} values of {} from {} to {}", values.size(), symbol, values.front(), values.back());
  }
  if (values.size() < 2) return fmt::format("{} = {}", symbol, fmt::join(values, ""));
  return fmt::format("{} = {} and {}", symbol, fmt::join(values.begin(), values.end() - 1, ", "), values.back());
}

std::string over_all_values(const std::vector<double>& values, const std::string& symbol) {
  return (values.size() == 1 ? "at " : "over ") + list_of_values(values, symbol);
}

namespace {
constexpr double rounding = 1e-12;  ///< of sums over some hundred layers
}

// Holds if at mu = 0 every pile is the same and c = tan 30 deg, D = 0 to rounding.
Claim judge_frictionless(const Analysis& analysis) {
  Claim claim = open_claim("frictionless", "Without friction c = tan 30\u00b0 and D = 0.", "c at \u03bc = 0");
  claim.paper = tan30;
  const auto result = std::ranges::find_if(analysis.results, [](const Transport& t) { return t.scanned() == 0; });
  if (result == analysis.results.end()) {
    leave_open(claim, "the experiment does not contain \u03bc = 0: add it to friction.mu, it costs next to nothing");
    return claim;
  }
  claim.measured = result->c;
  if (!result->c.known()) {
    leave_open(claim, result->c.reason);
    return claim;
  }
  const double c_error = std::abs(result->c.value - tan30), D_error = std::abs(result->D.value);
  const bool holds = result->exact && c_error <= rounding && D_error <= rounding;
  claim.verdict = holds ? reproduced : not_reproduced;
  claim.explanation = fmt::format(
      "A check of the program, since the rays are exact on this lattice: c differs from tan 30\u00b0 by {} and D from "
      "0 by {}; up to {} is rounding.",
      significant(c_error, 2), significant(D_error, 2), significant(rounding, 1));
  return claim;
}

namespace {

std::string over_window(const char* name, const ScalingFit& fit) {
  return fmt::format("the exponent {} over μ = {} to {}", name, fit.window[0], fit.window[1]);
}

/// What a claim about an exponent of slopes begins with.
Claim claim_of(const char* id, const char* statement, const char* symbol, const ScalingFit& fit) {
  Claim claim =
      open_claim(id, statement, fmt::format("{} of slopes over μ = {} to {}", symbol, fit.window[0], fit.window[1]));
  claim.power_law = !fit.misses_the_points();
  if (!claim.power_law) claim.quantity += ", on average";
  return claim;
}

}  // namespace

std::string misfit_sentence(const ScalingFit& fit, const char* of) {
  if (!fit.exponent.known() || !fit.misses_the_points()) return "";
  std::string sentence = fmt::format(
      "χ² of the points about the power law is {} on {}: they follow no single power over this window, and the "
      "exponent lies between those of its parts.",
      significant(fit.scatter.chi2, 3), fit.scatter.degrees_of_freedom);
  if (fit.running.meets_the_points()) {
    sentence += fmt::format(" With an exponent that changes steadily, {}, χ² is {} on {}.", in_words(fit.running, of),
                            significant(fit.running.scatter.chi2, 2), fit.running.scatter.degrees_of_freedom);
  }
  return sentence;
}

namespace {

Claim judge_exponent(const char* id, const char* statement, const char* symbol, const ScalingFit& fit,
                     const PaperNumber& paper, const std::optional<Rival>& rival) {
  Claim claim = claim_of(id, statement, symbol, fit);
  std::string what = over_window(symbol, fit);
  what.front() = 'T';
  judge_by_number(claim, fit.exponent, paper, rival, what);
  return claim;
}

/// Where the propagation coefficient of the thrust, which is known sharply at every friction, stops falling.
std::string turning_sentence(const Analysis& analysis) {
  const Transport *lowest = nullptr, *last = nullptr;
  for (const Transport& result : analysis.results) {
    if (!result.c_thrust.known()) continue;
    if (lowest == nullptr || result.c_thrust.value < lowest->c_thrust.value) lowest = &result;
    last = &result;
  }
  if (lowest == nullptr || lowest == last) return "";
  const Estimate &least = lowest->c_thrust, &end = last->c_thrust;
  if (end.value - least.value <= agreement * std::hypot(least.standard_error, end.standard_error)) return "";
  return fmt::format(
      "Of the friction coefficients measured the speed that follows from the thrust ratio is least at μ = {}, {}, and "
      "grows beyond it, to {} at μ = {}.",
      lowest->scanned(), value_with_error(least), value_with_error(end), last->scanned());
}

}  // namespace

// By the rule for numbers, over the window of mu of the experiment, c read as the slope of x_p.
Claim judge_c_of_mu(const Analysis& analysis) {
  Claim claim = judge_exponent("c-of-mu", "c decreases with friction, c₀ − c in proportion to μ.", "γ",
                               analysis.scaling.gamma, paper_gamma, second_order);
  add_sentence(claim, misfit_sentence(analysis.scaling.gamma, "μ"));
  add_sentence(claim, turning_sentence(analysis));
  return claim;
}

// By the rule for numbers, D read as the slope of W^2.
Claim judge_D_of_mu(const Analysis& analysis) {
  Claim claim = judge_exponent("D-of-mu", "D grows as μ to the power β, with β about 2.5.", "β", analysis.scaling.beta,
                               paper_beta, {});
  add_sentence(claim, misfit_sentence(analysis.scaling.beta, "μ"));
  return claim;
}

// By the rule for numbers.
Claim judge_c_of_D(const Analysis& analysis) {
  Claim claim = judge_exponent("c-of-D", "c₀ − c grows as D to the power α, with α = 0.4.", "α", analysis.scaling.alpha,
                               paper_alpha, linear_in_D);
  if (!claim.measured.known()) return claim;
  const ScalingFits& fits = analysis.scaling;
  if (fits.gamma.exponent.known() && fits.beta.exponent.known()) {
    add_sentence(claim, "It is no third fact beside β and γ: γ/β is {}.",
                 significant(fits.gamma.exponent.value / fits.beta.exponent.value, 3));
  }
  add_sentence(claim, misfit_sentence(fits.alpha, "D"));
  return claim;
}

// alpha against 1, which the stochastic theory predicts.
Claim judge_differs_from_theory(const Analysis& analysis) {
  Claim claim =
      claim_of("differs-from-theory", "c₀ − c is not proportional to D, as the stochastic theory has it at small D.",
               "α", analysis.scaling.alpha);
  judge_by_exclusion(claim, analysis.scaling.alpha.exponent, paper_alpha, linear_in_D,
                     "T" + over_window("α", analysis.scaling.alpha).substr(1));
  return claim;
}

void tell_smaller_friction(Analysis& analysis) {
  for (Claim& claim : analysis.claims) {
    if (claim.id != "differs-from-theory") continue;
    for (const OtherReading& reading : analysis.readings) {
      const ScalingFit& alpha = reading.fits.alpha;
      if (!alpha.exponent.known() || alpha.window[1] > analysis.scaling.alpha.window[0]) continue;
      add_sentence(claim, "That is α of this window: at small friction, over μ = {} to {}, it is {}.", alpha.window[0],
                   alpha.window[1],
                   alpha.misses_the_points() ? significant(alpha.exponent.value, 3) : value_with_error(alpha.exponent));
    }
  }
}

Analysis analyse(std::vector<MeasuredTransport> measured, const FitSpec& fit, const ClaimSpec& claims) {
  std::ranges::sort(measured, [](const MeasuredTransport& a, const MeasuredTransport& b) {
    return a.transport.scanned() < b.transport.scanned();
  });
  Analysis analysis;
  for (const MeasuredTransport& result : measured) analysis.results.push_back(result.transport);
  if (!measured.empty()) analysis.scan = measured.front().transport.scan;
  ScalingWithVariations scaling = fit_scaling_with_variations(measured, fit.scaling_window);
  analysis.scaling = std::move(scaling.fits);
  analysis.variations = std::move(scaling.variations);
  for (const auto& window : fit.other_scaling_windows) analysis.other_windows.push_back(fit_scaling(measured, window));
  analysis.mean_exponents = average_exponents(measured, claims.exponent_tolerance);
  analysis.mean_position_offset = average_position_offset(measured);
  analysis.claims = judge_claims(analysis, fit, claims);
  return analysis;
}

}  // namespace granuscope
