#include <fmt/format.h>
#include <gsl/gsl_cdf.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "analysis/claims.h"
#include "analysis/shape_fit.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// Depths of one kind, found at one friction coefficient or several.
struct Found {
  int depths = 0;
  std::vector<double> mu;
  double shallowest = std::numeric_limits<double>::infinity(), deepest = 0;  ///< z

  void add(double friction, double z) {
    ++depths;
    if (mu.empty() || mu.back() != friction) mu.push_back(friction);
    shallowest = std::min(shallowest, z);
    deepest = std::max(deepest, z);
  }
  std::string in_words() const {
    const std::string at = depths == 1
                               ? fmt::format("one depth, z = {:.1f}", shallowest)
                               : fmt::format("{} depths from z = {:.1f} to {:.1f}", depths, shallowest, deepest);
    return fmt::format("{}, {}", list_of_values(mu), at);
  }
};

}  // namespace

// The paper observed no merging. Two Gaussians at +-x_p make two peaks if and only if x_p > W. So at each mu > 0 the
// ratio of the mean x_p to the mean W over the window (Transport::peak_separation) is held against 1: two peaks where
// it lies above, one where it lies below, by sqrt(ClaimSpec::decisive_chi2) standard errors. A single depth speaks too
// where the best shape with one peak has a chi^2 smaller by decisive_chi2 than the best with two. Not reproduced if one
// peak is found; else not tested if the experiment does not reach ClaimSpec::highest_mu; else not decided if some mu
// is; else reproduced.
Claim judge_double_peak(const Analysis& analysis, const FitSpec& fit, const ClaimSpec& spec) {
  Claim claim =
      open_claim("double-peak",
                 fmt::format("The averaged response has two peaks, which are not seen to merge up to μ about {}.",
                             spec.highest_mu),
                 "mean xₚ over mean W, least");
  const double decisive = std::sqrt(spec.decisive_chi2);
  Found one, shallow;
  std::vector<double> two, merged, open, unfitted;
  double needed = 0, least_mu = 0;
  for (const Transport& result : analysis.results) {
    if (result.exact || result.scanned() == 0) continue;
    for (const DepthFit& depth : result.depths) {
      // Where the width of a bead hides the peaks' own, neither one peak nor two are their shape.
      const bool hidden = depth.width.value < fit.min_identifiable_width;
      if (hidden || !(depth.evidence.for_two_peaks <= -spec.decisive_chi2)) continue;
      (depth.layer < fit.first_layer || depth.layer > fit.last_layer ? shallow : one).add(result.scanned(), depth.z);
    }
    const Estimate& separation = result.peak_separation;
    if (!separation.known()) {
      unfitted.push_back(result.scanned());
      continue;
    }
    const double excess = (separation.value - 1) / separation.standard_error;
    (excess > decisive ? two : excess < -decisive ? merged : open).push_back(result.scanned());
    if (std::abs(excess) <= decisive) needed = std::max(needed, std::pow(decisive / excess, 2));
    if (claim.measured.known() && separation.value >= claim.measured.value) continue;
    claim.measured = separation;
    least_mu = result.scanned();
  }
  if (two.empty() && merged.empty() && open.empty() && unfitted.empty()) {
    leave_open(claim, "the experiment contains no friction above 0: add some to friction.mu, up to 1.7");
    return claim;
  }
  if (!claim.measured.known()) claim.measured.reason = "no depth could be fitted";
  const double reached = analysis.results.back().scanned();
  const bool far_enough = reached >= spec.highest_mu - 1e-9;
  const bool one_peak = !merged.empty() || one.depths > 0;
  claim.verdict = one_peak                           ? not_reproduced
                  : !far_enough                      ? not_tested
                  : open.empty() && unfitted.empty() ? reproduced
                                                     : not_decided;
  if (!merged.empty()) add_sentence(claim, "Over the window the peaks have merged at {}.", list_of_values(merged));
  if (one.depths > 0) add_sentence(claim, "One peak is found at {}.", one.in_words());
  if (!far_enough && !one_peak) {
    add_sentence(claim,
                 "The experiment ends at μ = {}: whether the peaks merge up to {} needs that value in friction.mu, one "
                 "more ensemble.",
                 reached, spec.highest_mu);
  }
  if (!open.empty()) {
    add_sentence(claim, "One peak or two is open at {}: {}.", list_of_values(open),
                 std::isfinite(needed) ? more_piles(needed) : "they stand exactly where peaks merge");
  }
  if (!unfitted.empty()) {
    add_sentence(claim, "One peak or two is unknown at {}: no depth could be fitted.", list_of_values(unfitted));
  }
  if (!two.empty()) add_sentence(claim, "Two peaks are found at {}.", list_of_values(two));
  if (claim.measured.known()) {
    add_sentence(claim,
                 "The mean xₚ over the mean W of the window is least at μ = {}, {}; the peaks merge at 1, and a "
                 "distance of {} standard errors is required.",
                 least_mu, value_with_error(claim.measured), significant(decisive, 2));
  }
  if (shallow.depths > 0) {
    add_sentence(claim, "Above the window of the fits one peak is found at {}.", shallow.in_words());
  }
  return claim;
}

namespace {

/// Beyond this many standard deviations a single ensemble speaks against an exponent that the mean has: six
/// ensembles meet it by chance once in 2600 experiments.
constexpr double outlier = 4;

/// W grows in proportion to z in an elastic medium, isotropic or not.
const Rival elastic_width{2, "elastic scaling"};

/// What the straight lines through the depths leave, over all results.
LineTest sum_of(const Analysis& analysis, LineTest Transport::*line) {
  LineTest sum;
  sum.chi2 = 0;
  for (const Transport& result : analysis.results) {
    if ((result.*line).degrees_of_freedom > 0) sum.chi2 += (result.*line).chi2;
    sum.degrees_of_freedom += (result.*line).degrees_of_freedom;
  }
  return sum;
}

/// A power of z known this roughly is no linear function of what scatters: its error may be far too small (160 piles of
/// 100 layers find 2.23(26) where 16000 find 1.09). It refutes a straight line only where the line's own chi^2 does.
constexpr double rough_error = 0.1;

bool is_refused(const LineTest& line, const Estimate& power) {
  return power.standard_error < rough_error || line.degrees_of_freedom == 0 ||
         gsl_cdf_chisq_Q(line.chi2, line.degrees_of_freedom) < 0.0027;  // the chance of three standard errors
}

/// Leaves open what a rough power alone would refute.
void hold_against(const LineTest& line, Claim& claim) {
  if (claim.verdict != not_reproduced || is_refused(line, claim.measured)) return;
  claim.verdict = not_decided;
  add_sentence(claim,
               "Straight lines meet the depths all the same, and so rough a power has no sure error: take more piles.");
}

std::string line_sentence(const LineTest& line) {
  if (line.degrees_of_freedom == 0) return "";
  return fmt::format(
      "The straight lines leave χ² = {} on {} degrees of freedom, with the joint covariance of the depths.",
      significant(line.chi2, 3), line.degrees_of_freedom);
}

/// Exponents of z or N. The mean over all friction coefficients is judged by the rule for numbers, with the tolerance
/// of the experiment (the paper states these exponents for large z and N); one is also not reproduced if its value at
/// any single mu lies more than four standard errors off. `line`: what is straight if the paper is right; may be null.
Claim judge_exponent(const Analysis& analysis, const ClaimSpec& spec, Claim claim, Estimate Exponents::*exponent,
                     double value, const std::optional<Rival>& rival, const std::string& what,
                     LineTest Transport::*line = nullptr) {
  const PaperNumber paper{.value = value, .tolerance = spec.exponent_tolerance};
  std::vector<double> values;
  std::string farthest;  // "μ = 0.3"
  double farthest_z = 0;
  Estimate farthest_power;
  for (const Transport& result : analysis.results) {
    const Estimate& power = result.exponents.*exponent;
    if (!power.known()) continue;
    values.push_back(result.scanned());
    const double z = judge_number(power, paper).z_score;
    if (std::abs(z) > outlier && line != nullptr && !is_refused(result.*line, power)) continue;
    if (!(std::abs(z) >= std::abs(farthest_z))) continue;  // an error that is unknown hides none
    farthest = result.at();
    farthest_z = z;
    farthest_power = power;
  }
  judge_by_number(claim, analysis.mean_exponents.*exponent, paper, rival,
                  values.empty() ? what : fmt::format("{} {}", what, over_all_values(values, analysis.scan->symbol)));
  if (values.empty()) {
    claim.explanation = fmt::format("No power could be taken: {}.", claim.measured.reason);
    return claim;
  }
  if (line != nullptr) hold_against(sum_of(analysis, line), claim);
  const std::string single = value_with_error(farthest_power);
  if (std::abs(farthest_z) > outlier && claim.verdict != not_reproduced) {
    // The number that decides is the one that is shown.
    const Claim mean = claim;
    claim.quantity += " at " + farthest;
    judge_by_number(claim, farthest_power, paper, rival, what);
    claim.verdict = not_reproduced;
    claim.explanation = fmt::format(
        "{} is {} at {}, {} combined errors off, though the mean over {}, {}, lies only {} off.", what, single,
        farthest, significant(std::abs(farthest_z), 2), list_of_values(values, analysis.scan->symbol),
        value_with_error(mean.measured), significant(std::abs(mean.z_score), 2));
  } else if (std::abs(farthest_z) > outlier) {
    add_sentence(claim, "At {} alone it is {}, {} combined errors off.", farthest, single,
                 significant(std::abs(farthest_z), 2));
  } else if (values.size() > 1 && !farthest.empty()) {
    add_sentence(claim, "The single value farthest off is {} at {}.", single, farthest);
  }
  return claim;
}

}  // namespace

// The power p of x_p = x_0 + A z^p against 1: the curvature of x_p(z) over the window.
Claim judge_linear_position(const Analysis& analysis, const ClaimSpec& spec) {
  Claim claim = judge_exponent(
      analysis, spec,
      open_claim("linear-position", "The position xₚ of the peaks grows linearly with z.", "power of z in xₚ − x₀"),
      &Exponents::position, 1, {}, "The power of z in xₚ − x₀", &Transport::position_line);
  add_sentence(claim, line_sentence(sum_of(analysis, &Transport::position_line)));
  return claim;
}

// The power p of W^2 = w_0 + A z^p against 1: the curvature of W^2(z) over the window.
Claim judge_diffusive_width(const Analysis& analysis, const ClaimSpec& spec) {
  Claim claim =
      judge_exponent(analysis, spec,
                     open_claim("diffusive-width", "The squared width W² of the peaks grows linearly with z.",
                                "power of z in W² − w₀"),
                     &Exponents::width, 1, elastic_width, "The power of z in W² − w₀", &Transport::width_line);
  if (claim.verdict == reproduced) {
    claim.quantity += fmt::format(", known to ± {}", significant(total_error(claim.measured), 1));
    add_sentence(claim, "Powers that differ from 1 by less than that are not seen here.");
  }
  add_sentence(claim, line_sentence(sum_of(analysis, &Transport::width_line)));
  return claim;
}

// The power p of the peak height h against -1/2: 1/h^2 = a + A z^(-2p), so that an offset of W^2 counts for nothing.
Claim judge_amplitude(const Analysis& analysis, const ClaimSpec& spec) {
  return judge_exponent(analysis, spec,
                        open_claim("amplitude", "The height of the peaks falls as 1/√z.", "power of z in the height"),
                        &Exponents::amplitude, -0.5, Rival{-1, "elastic scaling"},
                        "The power of z in the height, apart from an offset,", &Transport::height_line);
}

// The power of W^2 against 2, which every elastic response has.
Claim judge_no_elastic_scaling(const Analysis& analysis, const ClaimSpec& spec) {
  Claim claim = open_claim("no-elastic-scaling", "The widths do not grow in proportion to z, as in any elastic medium.",
                           "power of z in W² − w₀");
  judge_by_exclusion(claim, analysis.mean_exponents.width, {.value = 1, .tolerance = spec.exponent_tolerance},
                     elastic_width, "The mean power of z in W² − w₀");
  hold_against(sum_of(analysis, &Transport::width_line), claim);
  return claim;
}

// The power of N in the rms residual about the fit, over sub-ensembles, against -1/2. A power nearer to 0 says that the
// two Gaussians are not the exact shape: then nothing is decided of the noise, and the remark says why.
Claim judge_noise(const Analysis& analysis, const ClaimSpec& spec) {
  constexpr double paper = -0.5;
  Claim claim = judge_exponent(
      analysis, spec,
      open_claim("noise", "The residual noise of the averaged response falls as 1/√N.", "power of N in the residual"),
      &Exponents::noise, paper, {}, "The power of N in the rms residual about the fit");
  if (claim.verdict != not_reproduced) return claim;
  const auto above = [&](const Estimate& power, double allowed) {
    return power.known() && judge_number(power, {paper, 0, spec.exponent_tolerance}).z_score > allowed;
  };
  const bool another_shape =
      above(claim.measured, agreement) || std::ranges::any_of(analysis.results, [&](const Transport& result) {
        return above(result.exponents.noise, outlier);
      });
  if (another_shape) {
    claim.verdict = not_decided;
    add_sentence(claim,
                 "A power nearer to 0 than −1/2: the response has not exactly the shape of two Gaussians, and what "
                 "they miss stays however many piles are averaged. Of the noise itself that says nothing.");
  }
  return claim;
}

namespace {

constexpr double scanned_slack = 1e-9;

/// The results above mu = 0 up to the upper end of the scaling window: the small friction to which the paper restricts
/// its discussion.
std::vector<const Transport*> of_weak_friction(const Analysis& analysis, const FitSpec& fit) {
  std::vector<const Transport*> small;
  for (const Transport& result : analysis.results) {
    if (!result.exact && result.scanned() > 0 && result.scanned() <= fit.scaling_window[1] + scanned_slack) {
      small.push_back(&result);
    }
  }
  return small;
}

double difference_error(const Estimate& a, const Estimate& b) { return std::hypot(a.standard_error, b.standard_error); }

/// (b - a) in its standard errors.
double growth(const Estimate& a, const Estimate& b) { return (b.value - a.value) / difference_error(a, b); }

/// Whether the fit refuses the shape at most depths of the window (shape_fit.h).
bool of_another_shape(const Transport& result, const FitSpec& fit) {
  int depths = 0, refused = 0;
  for (const DepthFit& depth : result.depths) {
    if (depth.layer < fit.first_layer || depth.layer > fit.last_layer) continue;
    ++depths;
    const double excess = (depth.chi2_per_dof - 1) * std::sqrt(0.5 * depth.degrees_of_freedom);
    const double largest = depth.width.value < narrow_peak ? largest_misfit_of_narrow_peaks : largest_misfit;
    if (excess > largest_chi2_excess && depth.misfit_at_least > largest) ++refused;
  }
  return 2 * refused > depths;
}

}  // namespace

// The share of the response that lies spread between the peaks beside two Gaussians, and what the area of the Gaussians
// lacks of 1, against ClaimSpec::largest_remainder: reproduced if both stay below it by three standard errors at every
// small friction where they are known, not reproduced if one exceeds it by as much, or if somewhere they are unknown
// because most depths have another shape. The number shown is the one nearest to failing, in standard errors.
Claim judge_two_gaussians(const Analysis& analysis, const FitSpec& fit, const ClaimSpec& spec) {
  Claim claim = open_claim("two-gaussians", "Two symmetrical Gaussians describe the profile well.",
                           "share of the response between the peaks, largest");
  struct Remainder {
    Estimate share;
    double mu = 0, excess = 0;  ///< the latter in standard errors
    const char* what = "";
  };
  std::vector<double> mu, unknown, other_shape;
  std::optional<Remainder> worst;
  for (const Transport* result : of_weak_friction(analysis, fit)) {
    if (!result->centre_background.known() || !result->fitted_area.known()) {
      (of_another_shape(*result, fit) ? other_shape : unknown).push_back(result->scanned());
      continue;
    }
    mu.push_back(result->scanned());
    Estimate lacking = result->fitted_area;
    lacking.value = 1 - lacking.value;
    for (const auto& [share, what] : {std::pair{result->centre_background, "lies spread between the peaks"},
                                      std::pair{lacking, "is missing from the area of the Gaussians"}}) {
      const double excess = (std::abs(share.value) - spec.largest_remainder) / share.standard_error;
      if (!worst || excess > worst->excess) worst = Remainder{share, result->scanned(), excess, what};
    }
  }
  if (!other_shape.empty()) {
    add_sentence(claim, "At most depths of {} the response has another shape than two Gaussians.",
                 list_of_values(other_shape));
    claim.verdict = not_reproduced;
    claim.measured.reason = "two Gaussians do not fit";
  }
  if (!worst) {
    if (!other_shape.empty()) return claim;
    leave_open(claim, "no profile at small friction could be fitted");
    return claim;
  }
  if (other_shape.empty() || worst->excess > agreement) claim.measured = worst->share;
  claim.quantity += fmt::format(", up to μ = {}", mu.back());
  const bool failed = worst->excess > agreement, open = worst->excess > -agreement;
  claim.verdict = failed || !other_shape.empty() ? not_reproduced : open ? not_decided : reproduced;
  const char* distance = failed                       ? "exceeds it by more than three standard errors"
                         : worst->excess > -agreement ? "lies within three standard errors of it"
                                                      : "stays below it by more than three standard errors";
  add_sentence(claim, "{} the share of the response that {} is {}: up to ± {} counts as well described, and this {}.",
               mu.size() == 1 ? fmt::format("At μ = {}", mu.front()) : "Over " + list_of_values(mu), worst->what,
               value_with_error(worst->share) + (mu.size() == 1 ? "" : fmt::format(" at worst, at μ = {}", worst->mu)),
               significant(spec.largest_remainder, 2), distance);
  if (!unknown.empty()) {
    add_sentence(claim, "Not known at {}, where no fit tells the peaks.", list_of_values(unknown));
  }
  const Transport* larger = nullptr;
  for (const Transport& result : analysis.results) {
    const Estimate& share = result.centre_background;
    if (result.scanned() <= fit.scaling_window[1] + scanned_slack || !share.known()) continue;
    if (std::abs(share.value) - spec.largest_remainder <= agreement * share.standard_error) continue;
    if (larger == nullptr || share.value > larger->centre_background.value) larger = &result;
  }
  if (larger != nullptr) {
    add_sentence(claim, "At larger friction the share between the peaks exceeds that: {} at μ = {}.",
                 value_with_error(larger->centre_background), larger->scanned());
  }
  return claim;
}

// At small friction: reproduced if from the smallest to the largest mu c falls and D grows by more than three standard
// errors, and between no two neighbours the other way round by as much, which is not reproduced.
Claim judge_closer_and_wider(const Analysis& analysis, const FitSpec& fit) {
  Claim claim =
      open_claim("closer-and-wider", "The peaks get closer and wider as friction grows.", "fall of c over the window");
  std::vector<const Transport*> small;
  for (const Transport* result : of_weak_friction(analysis, fit)) {
    if (result->c.known() && result->D.known()) small.push_back(result);
  }
  if (small.size() < 2) {
    leave_open(claim, "c and D are known at fewer than two small friction coefficients");
    return claim;
  }
  const Transport &first = *small.front(), &last = *small.back();
  claim.measured.value = first.c.value - last.c.value;
  claim.measured.standard_error = difference_error(first.c, last.c);
  const auto reversed = std::adjacent_find(small.begin(), small.end(), [](const Transport* a, const Transport* b) {
    return growth(a->c, b->c) > agreement || growth(a->D, b->D) < -agreement;
  });
  const bool overall = growth(first.c, last.c) < -agreement && growth(first.D, last.D) > agreement;
  claim.verdict = reversed != small.end() ? not_reproduced : overall ? reproduced : not_decided;
  const double fall = -growth(first.c, last.c), rise = growth(first.D, last.D);
  add_sentence(
      claim,
      "From μ = {} to {} c goes from {} to {}, a fall of {} standard errors, and D from {} to {}, a rise of {}; "
      "at least {} are required.",
      first.scanned(), last.scanned(), value_with_error(first.c), value_with_error(last.c), significant(fall, 2),
      value_with_error(first.D), value_with_error(last.D), significant(rise, 2), significant(agreement, 2));
  if (reversed != small.end()) {
    add_sentence(claim, "Between μ = {} and {} one of them goes the other way by more than that.",
                 (*reversed)->scanned(), (*(reversed + 1))->scanned());
  }
  return claim;
}

}  // namespace granuscope
