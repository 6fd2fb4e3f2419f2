#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "analysis/claim_judges.h"
#include "analysis/claim_rule.h"
#include "analysis/shape_verdict.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

constexpr double window_slack = 1e-9;

/// The results above mu = 0 up to the upper end of the scaling window: the small friction to which the paper restricts
/// its discussion.
std::vector<const Transport*> of_weak_friction(const Analysis& analysis, const FitSpec& fit) {
  std::vector<const Transport*> small;
  for (const Transport& result : analysis.results) {
    if (!result.exact && result.scanned() > 0 && result.scanned() <= fit.scaling_window[1] + window_slack) {
      small.push_back(&result);
    }
  }
  return small;
}

double difference_error(const Estimate& a, const Estimate& b) { return std::hypot(a.standard_error, b.standard_error); }

/// (b - a) in its standard errors.
double growth(const Estimate& a, const Estimate& b) { return (b.value - a.value) / difference_error(a, b); }

/// Whether the fit refuses the shape at most depths of the window (shape_verdict.h).
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
                           "share of the response that they leave out, largest");
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
    add_sentence(claim, fmt::format("At most depths of {} the response has another shape than two Gaussians.",
                                    list_of_values(other_shape)));
    claim.verdict = not_reproduced;
    claim.measured.reason = "two Gaussians do not fit";
  }
  if (!worst) {
    if (!other_shape.empty()) return claim;
    leave_open(claim, "no profile at small friction could be fitted");
    return claim;
  }
  claim.measured = worst->share;
  const bool failed = worst->excess > agreement, open = worst->excess > -agreement;
  claim.verdict = failed || !other_shape.empty() ? not_reproduced : open ? not_decided : reproduced;
  const char* distance = failed                       ? "exceeds it by more than three standard errors"
                         : worst->excess > -agreement ? "lies within three standard errors of it"
                                                      : "stays below it by more than three standard errors";
  add_sentence(claim, fmt::format("{} the share of the response that {} is worst with {} at μ = {}: up "
                                  "to {} counts as well described, and this {}.",
                                  mu.size() == 1 ? fmt::format("At μ = {}", mu.front()) : "Over " + list_of_values(mu),
                                  worst->what, value_with_error(worst->share.value, worst->share.standard_error),
                                  worst->mu, significant(spec.largest_remainder, 2), distance));
  if (!unknown.empty()) {
    add_sentence(claim, fmt::format("Not known at {}, where no fit tells the peaks.", list_of_values(unknown)));
  }
  const Transport* larger = nullptr;
  for (const Transport& result : analysis.results) {
    const Estimate& share = result.centre_background;
    if (result.scanned() <= fit.scaling_window[1] + window_slack || !share.known()) continue;
    if (std::abs(share.value) - spec.largest_remainder <= agreement * share.standard_error) continue;
    if (larger == nullptr || share.value > larger->centre_background.value) larger = &result;
  }
  if (larger != nullptr) {
    add_sentence(
        claim, fmt::format("At larger friction the share between the peaks exceeds that: {} at μ = {}.",
                           value_with_error(larger->centre_background.value, larger->centre_background.standard_error),
                           larger->scanned()));
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
  add_sentence(claim,
               fmt::format("From μ = {} to {} c falls from {} to {}, by {} standard errors, and D grows from {} to "
                           "{}, by {}; at least {} are required.",
                           first.scanned(), last.scanned(), value_with_error(first.c.value, first.c.standard_error),
                           value_with_error(last.c.value, last.c.standard_error), significant(fall, 2),
                           value_with_error(first.D.value, first.D.standard_error),
                           value_with_error(last.D.value, last.D.standard_error), significant(rise, 2),
                           significant(agreement, 2)));
  if (reversed != small.end()) {
    add_sentence(claim, fmt::format("Between μ = {} and {} one of them goes the other way by more than that.",
                                    (*reversed)->scanned(), (*(reversed + 1))->scanned()));
  }
  return claim;
}

}  // namespace granuscope
