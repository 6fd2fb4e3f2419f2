#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "analysis/claim_rule.h"
#include "studies/spreading.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// Where the stretches begin that the claims speak of, bead diameters: about where the paper's window does, and below
/// it.
constexpr double shallow_from = 40, deep_from = 80;

/// One stretch of depth, judged at the friction coefficient where the power is farthest from 1.
Claim judge_stretch(const std::vector<DeepResponse>& measured, const ClaimSpec& spec, const char* id,
                    const std::string& where, PowerOfDepth DeepResponse::*stretch, double from) {
  Claim claim =
      open_claim(id, fmt::format("The squared width W² grows linearly with z {}.", where), "power of z in W²");
  const PaperNumber paper{.value = 1, .tolerance = spec.exponent_tolerance};
  const DeepResponse* farthest = nullptr;
  double farthest_z = 0;
  std::vector<std::string> all;
  for (const DeepResponse& one : measured) {
    const Estimate& power = (one.*stretch).exponent;
    if (!power.known() || one.by != DeepMeasurement::fluctuations || (one.*stretch).from < from) continue;
    all.push_back(
        fmt::format("{} at μ = {}", value_with_error(power.value, power.standard_error), one.spec.sampler.mu));
    const double z = std::abs(judge_number(power, paper).z_score);
    if (farthest != nullptr && z <= farthest_z) continue;
    farthest = &one;
    farthest_z = z;
  }
  if (farthest == nullptr) {
    leave_open(claim, "no power of z is known there: give the study of spreading more piles, or more octaves");
    return claim;
  }
  const PowerOfDepth& power = farthest->*stretch;
  judge_by_number(claim, power.exponent, paper, {},
                  fmt::format("The power of z in W² from z = {:.0f} to {:.0f} at μ = {}, where it is farthest from 1,",
                              power.from, power.to, farthest->spec.sampler.mu));
  if (all.size() > 1) add_sentence(claim, fmt::format("All of them: {}.", fmt::join(all, ", ")));
  return claim;
}

/// Where the deep stretch was followed, in numbers: with three octaves it ends at z = 222, and piles of 200 layers,
/// as the paper has them, at z = 173.
std::string spreading_depths(const std::vector<DeepResponse>& measured) {
  double from = 0, to = 0;
  for (const DeepResponse& one : measured) {
    if (one.by != DeepMeasurement::fluctuations || !one.deep.exponent.known() || one.deep.to <= to) continue;
    from = one.deep.from;
    to = one.deep.to;
  }
  if (to == 0) return "deeper below saturated layers";
  return fmt::format("from z = {:.0f} to {:.0f} below saturated layers", from, to);
}

}  // namespace

std::vector<Claim> judge_spreading(const std::vector<DeepResponse>& measured, const ClaimSpec& spec) {
  return {
      judge_stretch(measured, spec, "spreading-shallow", "as deep as the paper's piles, saturated ones without a load",
                    &DeepResponse::shallow, shallow_from),
      judge_stretch(measured, spec, "spreading-deep", spreading_depths(measured), &DeepResponse::deep, deep_from)};
}

}  // namespace granuscope
