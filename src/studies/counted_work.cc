#include "studies/counted_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "analysis/claims.h"
#include "analysis/jackknife.h"
#include "report/clean_json.h"
#include "studies/study.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// Few, so that the largest piles need not be many.
constexpr int blocks = 8;

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
  const auto [smallest, largest] = std::ranges::minmax_element(log_beads);
  if (*largest - *smallest < std::log(least_reach)) return std::nan("");
  return fit_line(log_beads, log_draws, std::vector<double>(log_beads.size(), 1.0)).slope;
}

}  // namespace

CountedWork counted_work(const MeasuredEnsemble& ensemble) {
  const SamplerCounts& counts = ensemble.record.counts;
  const auto per_bead = [&](std::uint64_t count) {
    return counts.beads == 0 ? std::numeric_limits<double>::quiet_NaN()
                             : static_cast<double>(count) / static_cast<double>(counts.beads);
  };
  CountedWork work;
  work.spec = ensemble.spec;
  const auto& completed = ensemble.record.sums.count;
  work.samples = std::accumulate(completed.begin(), completed.end(), std::uint64_t{0});
  work.failed = ensemble.record.failed.size();
  work.draws_per_bead = per_bead(counts.uniforms);
  work.repaired_per_bead = per_bead(counts.repaired_by_pair + counts.repaired_by_arc + counts.repaired_by_ring);
  work.backtracked_per_bead = per_bead(counts.backtracked);
  return work;
}

Claim judge_linear_time(const std::vector<CountedWork>& measured, const ClaimSpec& spec) {
  Claim claim = open_claim(
      "linear-time", "The work is linear in the number of beads; piles of 1000 × 1000 are solved up to μ about 1.7.",
      "power of the beads in the draws");
  const PaperNumber paper{.value = 1, .tolerance = spec.exponent_tolerance};
  claim.paper = paper.value;
  claim.tolerance = paper.tolerance;
  if (measured.empty()) {
    leave_open(claim,
               "no work was counted: set studies.counted_work.mu, up to 1.7; at that friction a pile of 1000 × "
               "1000 takes well below a second");
    return claim;
  }
  std::map<double, std::vector<const CountedWork*>> by_mu;
  std::uint64_t large_completed = 0, large_failed = 0;
  for (const CountedWork& work : measured) {
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
  const bool linear = power_known && judge_number(claim.measured, paper).verdict == reproduced;
  std::string of_power, of_size;
  if (power_known) {
    claim.quantity = fmt::format("power of the beads in the draws, farthest off at μ = {}", farthest_mu);
    claim.z_score = judge_number(claim.measured, paper).z_score;
    const auto fewer = [](const CountedWork* a, const CountedWork* b) { return beads_of(*a) < beads_of(*b); };
    const auto& sizes = by_mu[farthest_mu];
    const auto [smallest, largest] = std::ranges::minmax_element(sizes, fewer);
    of_power = fmt::format(
        "The number of draws grows as the power {} of the number of beads at μ = {}, where it is farthest from 1 among "
        "{}: {} draws per bead with {} × {} beads, {} with {} × {}.",
        significant(claim.measured.value, 4), farthest_mu, list_of_values(mu),
        significant((*smallest)->draws_per_bead, 4), (*smallest)->spec.lattice.columns,
        (*smallest)->spec.lattice.layers, significant((*largest)->draws_per_bead, 4), (*largest)->spec.lattice.columns,
        (*largest)->spec.lattice.layers);
  } else {
    claim.measured.reason = fmt::format("the sizes counted do not span a factor of {} in beads", least_reach);
    of_power = fmt::format("The sizes counted do not span a factor of {} in beads: widen studies.counted_work.sizes.",
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
        "No pile of 1000 × 1000 was tried at μ = {}: it needs that value in studies.counted_work.mu "
        "and that size in sizes.",
        spec.highest_mu);
  }
  claim.verdict = large_failed > 0 || (power_known && !linear) ? not_reproduced
                  : power_known && large_completed > 0         ? reproduced
                                                               : not_tested;
  // What decides comes first.
  const bool size_decides = linear && (large_failed > 0 || large_completed == 0);
  add_sentence(claim, size_decides ? of_size : of_power);
  add_sentence(claim, size_decides ? of_power : of_size);
  return claim;
}

using Json = nlohmann::ordered_json;

void to_json(Json& json, const CountedWork& work) {
  json = {{"mu", work.spec.sampler.mu},
          {"columns", work.spec.lattice.columns},
          {"layers", work.spec.lattice.layers},
          {"samples", work.samples},
          {"failed", work.failed},
          {"draws_per_bead", finite_or_null(work.draws_per_bead)},
          {"repaired_per_bead", finite_or_null(work.repaired_per_bead)},
          {"backtracked_per_bead", finite_or_null(work.backtracked_per_bead)}};
  if (json["draws_per_bead"].is_null()) json["reason"] = "no pile was completed";
}

namespace {

class CountedWorkStudy final : public CopiedStudy<CountedWorkStudy> {
 public:
  std::string id() const override { return "counted_work"; }

  std::vector<Key> keys() override {
    return {make_key(table(), "mu", "",
                     "friction coefficients at which the work of drawing is counted against size; none: not at all",
                     mu_, friction_range()),
            make_key(table(), "sizes", "beads", "columns and layers of the square piles", sizes_,
                     KeyRange{.fewest = 3, .ascending = true, .why = "fewer sizes show no law"}),
            make_key(table(), "samples", "piles", "piles per size and friction coefficient, at least 64", samples_)};
  }

  bool asked() const override { return !mu_.empty(); }

  Problem find_problem(const MainLine&) const override {
    for (const int size : sizes_) {
      if (auto found = find_lattice_problem(key("sizes"), size, key("sizes"), size, bottom_margin + 1,
                                            pile_memory(size, size))) {
        return found;
      }
    }
    return find_samples_problem(key("samples"), samples_, blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const double mu : mu_) {
      for (const int size : sizes_) {
        EnsembleSpec spec = main.ensemble_at(mu, {size, size}, samples_);
        spec.load = Load::uniform;
        spec.response.blocks = blocks;
        spec.layers = {size - bottom_margin - 1};  // nothing is measured; the ensemble is drawn to be counted
        spec.record_profiles = false;
        all.push_back({fmt::format("counted work, mu = {}, {} x {}", mu, size, size),
                       fmt::format("counted-work-mu-{}-{}x{}", exact(mu), size, size), spec});
      }
    }
    return all;
  }

  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override {
    measured_.push_back(counted_work(ensemble));
  }

  std::vector<Claim> claims(const ClaimSpec& spec) const override { return {judge_linear_time(measured_, spec)}; }

  Json json() const override { return measured_; }

  std::vector<ReportPart> parts() const override { return {table_part()}; }

 private:
  std::vector<double> mu_;                       ///< empty: not measured
  std::vector<int> sizes_{125, 250, 500, 1000};  ///< columns and layers of each square pile, ascending
  std::uint64_t samples_ = 64;                   ///< piles per size and friction coefficient
  std::vector<CountedWork> measured_;            ///< ascending in mu, then in size
};

}  // namespace

std::unique_ptr<Study> counted_work_study() { return std::make_unique<CountedWorkStudy>(); }

}  // namespace granuscope
