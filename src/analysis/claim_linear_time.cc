#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "analysis/claim_judges.h"
#include "analysis/claim_rule.h"
#include "analysis/line_fit.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

constexpr double paper_beads = 1e6;  ///< 1000 x 1000
/// Ratio of the largest to the smallest number of beads from which a power is taken.
constexpr double least_reach = 16;

double beads_of(const CountedWork& work) {
  return static_cast<double>(work.spec.lattice.columns) * work.spec.lattice.layers;
}

/// Power of the number of beads in the number of draws; NaN where sizes do not reach far enough.
double power_of(const std::vector<const CountedWork*>& sizes) {
  std::vector<double> log_beads, log_draws;
  for (const CountedWork* work : sizes) {
    if (work->samples == 0 || !(work->draws_per_bead > 0)) continue;
    log_beads.push_back(std::log(beads_of(*work)));
    log_draws.push_back(std::log(work->draws_per_bead * beads_of(*work)));
  }
  if (log_beads.empty()) return std::nan("");
  const auto [smallest, largest] = std::minmax_element(log_beads.begin(), log_beads.end());
  if (*largest - *smallest < std::log(least_reach)) return std::nan("");
  return fit_line(log_beads, log_draws, std::vector<double>(log_beads.size(), 1.0)).slope;
}

}  // namespace

// Decided by counted work, never by a clock: the power p with which the number of draws grows with the number of beads
// must lie within three tolerances of 1 at every mu counted, and every pile of 10^6 beads or more at a mu of at least
// ClaimSpec::highest_mu must have been completed. Not reproduced if a power lies outside or such a pile failed; else
// undetermined if no power or no such pile is there.
Claim judge_linear_time(const Analysis& analysis, const ClaimSpec& spec) {
  Claim claim = open_claim(
      "linear-time", "The work is linear in the number of beads; piles of 1000 × 1000 are solved up to μ about 1.7.",
      "power of the beads in the draws");
  claim.paper = 1;
  claim.paper_error = spec.exponent_tolerance;
  if (analysis.side.counted_work.empty()) {
    leave_open(claim,
               "no work was counted: set figures.counted_work.mu, up to 1.7; at that friction a pile of 1000 × "
               "1000 takes well below a second");
    return claim;
  }
  std::map<double, std::vector<const CountedWork*>> by_mu;
  std::uint64_t large_completed = 0, large_failed = 0;
  for (const CountedWork& work : analysis.side.counted_work) {
    by_mu[work.spec.sampler.mu].push_back(&work);
    if (work.spec.sampler.mu >= spec.highest_mu - 1e-9 && beads_of(work) >= paper_beads) {
      large_completed += work.samples;
      large_failed += work.failed;
    }
  }
  std::vector<double> mu;
  double farthest_mu = 0;
  for (const auto& [friction, sizes] : by_mu) {
    const double power = power_of(sizes);
    if (!std::isfinite(power)) continue;
    mu.push_back(friction);
    if (claim.measured.known() && std::abs(power - 1) <= std::abs(claim.measured.value - 1)) continue;
    farthest_mu = friction;
    claim.measured.value = power;
    claim.measured.standard_error = 0;  // counted
  }
  const bool power_known = claim.measured.known();
  const bool linear = power_known && judge_number(claim.measured, 1, spec.exponent_tolerance).verdict == reproduced;
  std::string of_power, of_size;
  if (power_known) {
    claim.quantity = fmt::format("power of the beads in the draws, farthest off at μ = {}", farthest_mu);
    claim.z_score = judge_number(claim.measured, 1, spec.exponent_tolerance).z_score;
    const auto fewer = [](const CountedWork* a, const CountedWork* b) { return beads_of(*a) < beads_of(*b); };
    const auto& sizes = by_mu[farthest_mu];
    const auto [smallest, largest] = std::minmax_element(sizes.begin(), sizes.end(), fewer);
    of_power = fmt::format(
        "The number of draws grows as the power {} of the number of beads at μ = {}, where it is farthest from 1 among "
        "{}: {} draws per bead with {} × {} beads, {} with {} × {}.",
        significant(claim.measured.value, 4), farthest_mu, list_of_mu(mu), significant((*smallest)->draws_per_bead, 4),
        (*smallest)->spec.lattice.columns, (*smallest)->spec.lattice.layers, significant((*largest)->draws_per_bead, 4),
        (*largest)->spec.lattice.columns, (*largest)->spec.lattice.layers);
  } else {
    claim.measured.reason = fmt::format("the sizes counted do not span a factor of {} in beads", least_reach);
    of_power = fmt::format("The sizes counted do not span a factor of {} in beads: widen figures.counted_work.sizes.",
                           least_reach);
  }
  if (large_failed > 0) {
    of_size = fmt::format("{} of {} piles of 10⁶ beads or more at μ ≥ {} were not completed.", large_failed,
                          large_failed + large_completed, spec.highest_mu);
  } else if (large_completed > 0) {
    of_size =
        fmt::format("All {} piles of 10⁶ beads or more at μ ≥ {} were completed.", large_completed, spec.highest_mu);
  } else {
    of_size = fmt::format(
        "No pile of 1000 × 1000 was tried at μ = {}: it needs that value in figures.counted_work.mu "
        "and that size in sizes.",
        spec.highest_mu);
  }
  claim.verdict = large_failed > 0 || (power_known && !linear) ? not_reproduced
                  : power_known && large_completed > 0         ? reproduced
                                                               : undetermined;
  // What decides comes first.
  const bool size_decides = linear && (large_failed > 0 || large_completed == 0);
  say(claim, size_decides ? of_size : of_power);
  say(claim, size_decides ? of_power : of_size);
  return claim;
}

}  // namespace granuscope
