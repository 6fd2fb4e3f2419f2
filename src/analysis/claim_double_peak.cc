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
    return fmt::format("{}, {}", list_of_mu(mu), at);
  }
};

}  // namespace

// Decided by likelihood ratios at every depth of the fit window and every mu > 0. Two Gaussians at +-x_p make two peaks
// if and only if x_p > W; a single Gaussian is x_p = 0. Two peaks are found where the best shape with two has a chi^2
// smaller by ClaimSpec::decisive_chi2 than the best with one (and than the best single Gaussian), one peak where it is
// larger by as much, and a depth between is undecided.
// Not reproduced if any depth has one peak; else undetermined if any is undecided or could not be fitted, or if the
// experiment does not reach ClaimSpec::highest_mu; else reproduced.
Claim judge_double_peak(const Analysis& analysis, const FitSpec& fit, const ClaimSpec& spec) {
  Claim claim = open_claim("double-peak",
                           fmt::format("The averaged response has two peaks at every μ and depth; they never merge up "
                                       "to μ about {}.",
                                       spec.highest_mu),
                           "least Δχ² for two peaks against one");
  Found two, one, undecided, shallow;
  double least = std::numeric_limits<double>::infinity(), closest = least, undecided_evidence = 0;
  int undecided_known = 0;
  for (const Transport& result : analysis.results) {
    if (result.exact || result.mu() == 0) continue;
    for (const DepthFit& depth : result.depths) {
      const double evidence = std::min(depth.evidence.for_two_peaks, depth.evidence.against_one_gaussian);
      if (depth.layer < fit.first_layer || depth.layer > fit.last_layer) {
        if (depth.evidence.for_two_peaks <= -spec.decisive_chi2) shallow.add(result.mu(), depth.z);
        continue;
      }
      if (evidence >= spec.decisive_chi2) {
        two.add(result.mu(), depth.z);
        closest = std::min(closest, depth.peak_position.value / depth.width.value);
      } else if (depth.evidence.for_two_peaks <= -spec.decisive_chi2) {
        one.add(result.mu(), depth.z);
      } else {
        undecided.add(result.mu(), depth.z);
        if (std::isfinite(evidence)) {
          undecided_evidence += evidence;
          ++undecided_known;
        }
      }
      if (std::isfinite(evidence)) least = std::min(least, evidence);
    }
  }
  if (two.depths + one.depths + undecided.depths == 0) {
    leave_open(claim, "the experiment contains no friction above 0: add some to friction.mu, up to 1.7");
    return claim;
  }
  if (std::isfinite(least)) {
    claim.measured.value = least;
    claim.measured.standard_error = std::numeric_limits<double>::quiet_NaN();
  } else {
    claim.measured.reason = "no depth could be fitted";
  }

  const double reached = analysis.results.back().mu();
  const bool far_enough = reached >= spec.highest_mu - 1e-9;
  claim.verdict = one.depths > 0 ? not_reproduced : undecided.depths > 0 || !far_enough ? undetermined : reproduced;
  if (one.depths > 0) add_sentence(claim, fmt::format("One peak is found at {}.", one.in_words()));
  if (undecided.depths > 0) {
    // On average; a single depth of many may lie near 0 by chance, which says nothing about the cost.
    const double mean = undecided_evidence / std::max(undecided_known, 1);
    add_sentence(claim,
                 fmt::format("Undecided between one and two peaks (|Δχ²| < {}) at {}; Δχ² is {} there on average, and "
                             "grows in proportion to the number of piles: {}.",
                             spec.decisive_chi2, undecided.in_words(), significant(mean, 2),
                             more_piles(std::max(1.0, spec.decisive_chi2 / std::abs(mean)))));
  }
  if (!far_enough) {
    add_sentence(claim,
                 fmt::format("The experiment ends at μ = {}: whether the peaks merge up to {} needs that value in "
                             "friction.mu, one more ensemble.",
                             reached, spec.highest_mu));
  }
  if (two.depths > 0) {
    add_sentence(
        claim, fmt::format("Two peaks are found at {}; nowhere are they closer than 2 xₚ = {} W, and they would merge "
                           "at 2 W.",
                           two.in_words(), significant(2 * closest, 2)));
  }
  if (shallow.depths > 0) {
    add_sentence(claim, fmt::format("Above the window of the fits one peak is found at {}.", shallow.in_words()));
  }
  return claim;
}

}  // namespace granuscope
