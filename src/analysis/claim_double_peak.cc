#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/claim_judges.h"
#include "analysis/claim_rule.h"
#include "support/number_format.h"

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
      if (!(depth.evidence.for_two_peaks <= -spec.decisive_chi2)) continue;
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
  if (!merged.empty())
    add_sentence(claim, fmt::format("Over the window the peaks have merged at {}.", list_of_values(merged)));
  if (one.depths > 0) add_sentence(claim, fmt::format("One peak is found at {}.", one.in_words()));
  if (!far_enough && !one_peak) {
    add_sentence(claim,
                 fmt::format("The experiment ends at μ = {}: whether the peaks merge up to {} needs that value in "
                             "friction.mu, one more ensemble.",
                             reached, spec.highest_mu));
  }
  if (!open.empty()) {
    add_sentence(claim,
                 fmt::format("One peak or two is open at {}: {}.", list_of_values(open),
                             std::isfinite(needed) ? more_piles(needed) : "they stand exactly where peaks merge"));
  }
  if (!unfitted.empty()) {
    add_sentence(claim,
                 fmt::format("One peak or two is unknown at {}: no depth could be fitted.", list_of_values(unfitted)));
  }
  if (!two.empty()) add_sentence(claim, fmt::format("Two peaks are found at {}.", list_of_values(two)));
  if (claim.measured.known()) {
    add_sentence(claim,
                 fmt::format("The mean xₚ over the mean W of the window is least at μ = {}, {}; the peaks merge at "
                             "1, and a distance of {} standard errors is required.",
                             least_mu, value_with_error(claim.measured.value, claim.measured.standard_error),
                             significant(decisive, 2)));
  }
  if (shallow.depths > 0) {
    add_sentence(claim, fmt::format("Above the window of the fits one peak is found at {}.", shallow.in_words()));
  }
  return claim;
}

}  // namespace granuscope
