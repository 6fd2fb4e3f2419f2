#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/claim_judges.h"
#include "analysis/claim_rule.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

constexpr double window_slack = 1e-9;

/// The results above mu = 0 up to the upper end of the scaling window: the small friction to which the paper restricts
/// its discussion.
std::vector<const Transport*> of_weak_friction(const Analysis& analysis, const FitSpec& fit) {
  std::vector<const Transport*> small;
  for (const Transport& result : analysis.results) {
    if (!result.exact && result.mu() > 0 && result.mu() <= fit.scaling_window[1] + window_slack) {
      small.push_back(&result);
    }
  }
  return small;
}

double difference_error(const Estimate& a, const Estimate& b) { return std::hypot(a.standard_error, b.standard_error); }

/// (b - a) in its standard errors.
double growth(const Estimate& a, const Estimate& b) { return (b.value - a.value) / difference_error(a, b); }

}  // namespace

// The share of the response that lies spread between the peaks beside two Gaussians, and what the area of the Gaussians
// lacks of 1, against ClaimSpec::largest_remainder: reproduced if both stay below it by three standard errors at every
// small friction, not reproduced if one exceeds it by as much.
Claim judge_two_gaussians(const Analysis& analysis, const FitSpec& fit, const ClaimSpec& spec) {
  Claim claim = open_claim("two-gaussians", "Two symmetrical Gaussians describe the profile well.",
                           "share between the peaks, largest");
  std::vector<double> mu;
  double farthest_mu = 0;
  bool failed = false, open = false;
  Estimate largest;
  for (const Transport* result : of_weak_friction(analysis, fit)) {
    if (!result->centre_background.known() || !result->fitted_area.known()) continue;
    mu.push_back(result->mu());
    Estimate lacking = result->fitted_area;
    lacking.value = 1 - lacking.value;
    for (const Estimate* share : {&result->centre_background, static_cast<const Estimate*>(&lacking)}) {
      const double excess = std::abs(share->value) - spec.largest_remainder;
      failed = failed || excess > agreement * share->standard_error;
      open = open || excess > -agreement * share->standard_error;
    }
    if (largest.known() && std::abs(result->centre_background.value) <= std::abs(largest.value)) continue;
    largest = result->centre_background;
    farthest_mu = result->mu();
  }
  if (mu.empty()) {
    leave_open(claim, "no profile at small friction could be fitted");
    return claim;
  }
  claim.measured = largest;
  claim.verdict = failed ? not_reproduced : open ? not_decided : reproduced;
  add_sentence(claim, fmt::format("{} the share of the response that lies spread between the peaks is at most {} (at "
                                  "μ = {}); up to {} counts as well described.",
                                  mu.size() == 1 ? fmt::format("At μ = {}", mu.front()) : "Over " + list_of_mu(mu),
                                  value_with_error(largest.value, largest.standard_error), farthest_mu,
                                  significant(spec.largest_remainder, 2)));
  const Transport* worst = nullptr;
  for (const Transport& result : analysis.results) {
    const Estimate& share = result.centre_background;
    if (result.mu() <= fit.scaling_window[1] + window_slack || !share.known()) continue;
    if (std::abs(share.value) - spec.largest_remainder <= agreement * share.standard_error) continue;
    if (worst == nullptr || share.value > worst->centre_background.value) worst = &result;
  }
  if (worst != nullptr) {
    add_sentence(claim,
                 fmt::format("At larger friction it exceeds that: {} at μ = {}.",
                             value_with_error(worst->centre_background.value, worst->centre_background.standard_error),
                             worst->mu()));
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
  add_sentence(claim, fmt::format("From μ = {} to {} c goes from {} to {} and D from {} to {}.", first.mu(), last.mu(),
                                  value_with_error(first.c.value, first.c.standard_error),
                                  value_with_error(last.c.value, last.c.standard_error),
                                  value_with_error(first.D.value, first.D.standard_error),
                                  value_with_error(last.D.value, last.D.standard_error)));
  if (reversed != small.end()) {
    add_sentence(claim, fmt::format("Between μ = {} and {} it is the other way round.", (*reversed)->mu(),
                                    (*(reversed + 1))->mu()));
  }
  return claim;
}

}  // namespace granuscope
