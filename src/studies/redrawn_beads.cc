#include "studies/redrawn_beads.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>

#include "analysis/claim_rule.h"
#include "analysis/jackknife.h"
#include "analysis/layer_spectrum.h"
#include "ensemble/paired_estimator.h"
#include "report/estimate_json.h"
#include "studies/common_checks.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// The mean over the usable layers of a share per layer, each layer weighted with `beads_of(layer)`.
template <typename BeadsOf>
Replicated share_of_pile(const BlockSums& sums, const std::string& quantity, int layers, BeadsOf beads_of) {
  Replicated share{0, std::vector<double>(static_cast<std::size_t>(sums.blocks()), 0.0)};
  double beads = 0;
  for (int layer = 0; layer < layers; ++layer) beads += beads_of(layer);
  for (int layer = 0; layer < layers; ++layer) {
    const double weight = beads_of(layer) / beads;
    const BlockMeans means = block_means(sums, quantity, static_cast<std::size_t>(layer));
    share.value += weight * means.whole[0];
    for (std::size_t b = 0; b < share.without_block.size(); ++b) {
      share.without_block[b] += weight * means.without_block[b][0];
    }
  }
  return share;
}

Replicated ratio_of(const Replicated& a, const Replicated& b) {
  return transform([](double x, double y) { return x / y; }, a, b);
}

/// The mean over the usable layers of share redrawn times mean force: what redrawn beads would carry without
/// preference.
Replicated usual_force(const BlockSums& sums, int layers) {
  Replicated usual{0, std::vector<double>(static_cast<std::size_t>(sums.blocks()), 0.0)};
  for (int layer = 0; layer < layers; ++layer) {
    const auto row = static_cast<std::size_t>(layer);
    const BlockMeans redrawn = block_means(sums, "redrawn", row), force = block_means(sums, "least_force", row);
    usual.value += redrawn.whole[0] * force.whole[0] / layers;
    for (std::size_t b = 0; b < usual.without_block.size(); ++b) {
      usual.without_block[b] += redrawn.without_block[b][0] * force.without_block[b][0] / layers;
    }
  }
  return usual;
}

/// What the paper states, "of the order of".
struct StatedShare {
  double mu, share;
};
constexpr std::array<StatedShare, 2> stated_shares{{{0.1, 0.005}, {0.3, 0.024}}};
/// Numbers that differ by less than this factor are of one order.
constexpr double same_order_up_to = 2;

/// By what factor a share differs from the stated one, whichever is larger; at the ends of `errors` standard errors the
/// one farther from it.
double factor_between(const Estimate& share, double stated, double errors) {
  const double low = share.value - errors * share.standard_error, high = share.value + errors * share.standard_error;
  return low > 0 ? std::max(high / stated, stated / low) : std::numeric_limits<double>::infinity();
}

/// The nearer of these ends.
double factor_at_least(const Estimate& share, double stated, double errors) {
  const double low = share.value - errors * share.standard_error, high = share.value + errors * share.standard_error;
  return std::max({low / stated, stated / high, 1.0});
}

std::string percent(const Estimate& share) {
  return value_with_error(100 * share.value, 100 * share.standard_error) + " %";
}

/// Adds the share of the beads below the overload to a list in words.
void say_below(std::string& list, const RedrawnBeads& beads) {
  if (!beads.below_overload.known()) return;
  list += fmt::format("{}{} at μ = {}", list.empty() ? "" : ", ", percent(beads.below_overload), beads.spec.sampler.mu);
}

}  // namespace

RedrawnBeads measure_redrawn_beads(const MeasuredEnsemble& ensemble) {
  const auto& [spec, record] = ensemble;
  const Lattice lattice(spec.lattice);
  const BlockSums& sums = record.sums;
  const int usable = lattice.usable_layers();
  if (usable == 0 || !sums.quantities.contains("redrawn") || sums.layers.size() < static_cast<std::size_t>(usable) ||
      sums.layers[static_cast<std::size_t>(usable) - 1] != usable - 1) {
    throw InputError(
        fmt::format("the ensemble does not hold the redrawn beads of all usable layers, so that their share is not "
                    "known; draw it with the estimator paired, more than {} layers, and all of them recorded",
                    bottom_margin));
  }
  RedrawnBeads result;
  result.spec = spec;
  result.failed = record.failed.size();
  for (const std::uint64_t count : sums.count) result.samples += count;
  if (std::find(sums.count.begin(), sums.count.end(), 0) != sums.count.end()) {
    for (Estimate* one :
         {&result.whole_pile, &result.below_overload, &result.force, &result.relative_force, &result.together}) {
      one->reason = "a block of the ensemble holds no completed pair of piles";
    }
    return result;
  }
  const auto in_pile = [&](const char* quantity) {
    return share_of_pile(sums, quantity, usable, [](int) { return 1.0; });
  };
  const Replicated redrawn = in_pile("redrawn");
  result.whole_pile = estimate(redrawn);
  const char* const none = "no bead of some block was redrawn";
  const Replicated force = in_pile("redrawn_force");
  result.force = estimate(ratio_of(force, redrawn), none);
  result.relative_force = estimate(ratio_of(force, usual_force(sums, usable)), none);
  result.together = estimate(ratio_of(in_pile("redrawn_together"), redrawn), none);
  result.below_overload = estimate(share_of_pile(sums, "redrawn_below_overload", usable,
                                                 [&](int layer) { return beads_below_overload(lattice, layer); }));
  return result;
}

Claim judge_redraw_share(const std::vector<RedrawnBeads>& measured) {
  Claim claim = open_claim("redraw-share",
                           "With the standard procedure about 0.5 % (μ = 0.1) and 2.4 % (μ = 0.3) of the beads "
                           "change their random number.",
                           "share of beads");
  std::vector<double> missing;
  std::vector<std::string> clauses;
  std::string below;
  bool failed = false, open = false;
  double farthest = 0;
  for (const StatedShare& one : stated_shares) {
    const auto found = std::find_if(measured.begin(), measured.end(), [&](const RedrawnBeads& beads) {
      return std::abs(beads.spec.sampler.mu - one.mu) < 1e-9;
    });
    if (found == measured.end()) {
      missing.push_back(one.mu);
      continue;
    }
    const Estimate& share = found->whole_pile;
    if (!share.known()) {
      missing.push_back(one.mu);
      clauses.push_back(fmt::format("at μ = {} it could not be measured: {}", one.mu, share.reason));
      continue;
    }
    failed = failed || factor_at_least(share, one.share, agreement) > same_order_up_to;
    open = open || factor_between(share, one.share, agreement) > same_order_up_to;
    const double factor = factor_between(share, one.share, 0);
    clauses.push_back(fmt::format("{} of the beads draw again at μ = {}, {} times {} the paper’s {} %", percent(share),
                                  one.mu, significant(factor, 3), share.value > one.share ? "as many as" : "fewer than",
                                  100 * one.share));
    say_below(below, *found);
    if (factor > farthest) {
      farthest = factor;
      claim.quantity = fmt::format("share of beads at μ = {}", one.mu);
      claim.measured = share;
      claim.paper = one.share;
    }
  }
  if (!claim.measured.known()) {
    leave_open(claim, clauses.empty()
                          ? "nothing was measured with the standard procedure: set studies.redrawn_beads.mu = "
                            "[0.1, 0.3]; a few hundred pairs of piles are enough"
                          : fmt::format("studies.redrawn_beads has no share: {}", fmt::join(clauses, "; ")));
    return claim;
  }
  claim.verdict = failed ? not_reproduced : !missing.empty() ? not_tested : open ? not_decided : reproduced;
  add_sentence(claim, fmt::format("{}; up to a factor of {} counts as of that order.", fmt::join(clauses, "; "),
                                  same_order_up_to));
  if (!missing.empty()) {
    add_sentence(claim, fmt::format("The other number of the paper needs {} in studies.redrawn_beads.mu.",
                                    list_of_values(missing)));
  }
  if (!below.empty()) add_sentence(claim, fmt::format("Of the beads with |x| ≤ z it is {}.", below));
  return claim;
}

Claim judge_rearrangements(const std::vector<RedrawnBeads>& measured, double most_together) {
  Claim claim =
      open_claim("local-rearrangements",
                 "The beads that change their random number are few together, and preferably those of small forces.",
                 "force of such a bead over the mean");
  constexpr double no_preference = 1;
  bool failed = false, open = false;
  std::vector<std::string> clauses;
  for (const RedrawnBeads& one : measured) {
    if (!one.relative_force.known() || !one.together.known()) continue;
    const auto above = [](const Estimate& number, double limit) {
      return (number.value - limit) / number.standard_error;
    };
    const double heavy = above(one.relative_force, no_preference);
    const double large = above(one.together, most_together);
    failed = failed || heavy > agreement || large > agreement;
    open = open || heavy > -agreement || large > -agreement;
    clauses.push_back(fmt::format("{} times the mean ({} of the overload) in rearrangements of {} beads at μ = {}",
                                  value_with_error(one.relative_force.value, one.relative_force.standard_error),
                                  significant(one.force.value / one.spec.response.overload, 2),
                                  value_with_error(one.together.value, one.together.standard_error),
                                  one.spec.sampler.mu));
    if (claim.measured.known() && one.relative_force.value < claim.measured.value) continue;
    claim.measured = one.relative_force;
    claim.quantity = fmt::format("force of such a bead over the mean at μ = {}", one.spec.sampler.mu);
    claim.rival = no_preference;
    claim.rival_name = "no preference";
    claim.rival_distance = above(one.relative_force, no_preference);
  }
  if (clauses.empty()) {
    leave_open(claim,
               "nothing was measured with the standard procedure: set studies.redrawn_beads.mu = [0.1, 0.3]; a few "
               "hundred pairs of piles are enough");
    return claim;
  }
  claim.verdict = failed ? not_reproduced : open ? not_decided : reproduced;
  add_sentence(claim, fmt::format("Before the overload acts the smaller force that a bead which draws again hands down "
                                  "is {}; the mean is that of all beads at its depth, and up to {} beads that touch "
                                  "count as local.",
                                  fmt::join(clauses, ", "), most_together));
  if (claim.rival_distance < -agreement) {
    add_sentence(claim, fmt::format("It lies below the mean by {} standard errors: a preference, however weak; the "
                                    "paper does not say how strong.",
                                    significant(-claim.rival_distance, 2)));
  }
  return claim;
}

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const RedrawnBeads& redrawn) {
  return {{"mu", redrawn.spec.sampler.mu},
          {"columns", redrawn.spec.lattice.columns},
          {"layers", redrawn.spec.lattice.layers},
          {"overload", redrawn.spec.response.overload},
          {"samples", redrawn.samples},
          {"failed", redrawn.failed},
          {"whole_pile", granuscope::to_json(redrawn.whole_pile)},
          {"below_overload", granuscope::to_json(redrawn.below_overload)},
          {"force", granuscope::to_json(redrawn.force)},
          {"relative_force", granuscope::to_json(redrawn.relative_force)},
          {"together", granuscope::to_json(redrawn.together)}};
}

class RedrawnBeadsStudy final : public CopiedStudy<RedrawnBeadsStudy> {
 public:
  std::string id() const override { return "redrawn_beads"; }

  std::vector<Key> keys() override {
    return {make_key(table(), "mu", "",
                     "friction coefficients at which the standard procedure is followed too; none: not at all", mu_,
                     friction_range_above_zero()),
            make_key(table(), "samples", "pairs of piles", "pairs per friction coefficient, at least eight per block",
                     samples_),
            make_key(table(), "most_together", "beads",
                     "claim local-rearrangements: beads that touch and draw again, on average over such beads, up to "
                     "which a rearrangement counts as local",
                     most_together_, KeyRange{.why = "a rearrangement has at least one bead"}.within(1, 1000))};
  }

  bool asked() const override { return !mu_.empty(); }

  Problem find_problem(const MainLine& main) const override {
    if (main.sampling.law != Law::granusolve) {
      return problem(key("mu"),
                     "only the law granusolve can keep the random numbers of a pile while its load changes, but "
                     "sampling.law is {}; empty the list or change the law",
                     name_of(main.sampling.law));
    }
    return find_samples_problem(key("samples"), samples_, main.response.blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const double mu : mu_) {
      EnsembleSpec spec = main.ensemble_at(mu, main.lattice, samples_);
      spec.response.estimator = EstimatorName::paired;
      spec.layers.resize(static_cast<std::size_t>(Lattice(spec.lattice).usable_layers()));
      std::iota(spec.layers.begin(), spec.layers.end(), 0);
      spec.record_profiles = false;
      all.push_back({fmt::format("redrawn beads, mu = {}", mu), fmt::format("redrawn-beads-mu-{}", exact(mu)), spec});
    }
    return all;
  }

  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override {
    measured_.push_back(measure_redrawn_beads(ensemble));
  }

  std::vector<Claim> claims(const ClaimSpec&) const override {
    return {judge_redraw_share(measured_), judge_rearrangements(measured_, most_together_)};
  }

  Json json() const override { return list_of(measured_, to_json); }

  std::vector<ReportPart> parts(const Json&) const override { return {table_part()}; }

 private:
  std::vector<double> mu_;              ///< empty: not measured
  std::uint64_t samples_ = 512;         ///< pairs of piles per friction coefficient
  double most_together_ = 10;           ///< chosen before it was measured
  std::vector<RedrawnBeads> measured_;  ///< ascending in mu
};

}  // namespace

std::unique_ptr<Study> redrawn_beads_study() { return std::make_unique<RedrawnBeadsStudy>(); }

}  // namespace granuscope
