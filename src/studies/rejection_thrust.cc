#include "studies/rejection_thrust.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "analysis/jackknife.h"
#include "analysis/layer_spectrum.h"
#include "report/estimate_json.h"
#include "studies/common_checks.h"
#include "support/number_format.h"

namespace granuscope {

std::vector<RejectionThrustSize> rejection_thrust_sizes(double mu) {
  constexpr double beads_times_mu = 25.2, margin_times_mu = 1.2;
  constexpr int deepest = 400, widest_margin = deepest / 4;
  std::vector<RejectionThrustSize> sizes;
  const int margin = static_cast<int>(std::min(std::round(margin_times_mu / mu), 1.0 * widest_margin));
  for (const int columns : {4, 6, 8}) {
    const double layers = std::max(beads_times_mu / mu / columns, 2.0 * margin + 2);
    sizes.push_back({{columns, static_cast<int>(std::min(layers, 1.0 * deepest))}, margin});
  }
  return sizes;
}

RejectionThrust measure_rejection_thrust(const MeasuredEnsemble& ensemble, int margin) {
  const auto& [spec, record] = ensemble;
  const BlockSums& sums = record.sums;
  const double mu = spec.sampler.mu;
  RejectionThrust result;
  result.spec = spec;
  result.samples = std::accumulate(sums.count.begin(), sums.count.end(), std::uint64_t{0});
  result.failed = record.failed.size();
  result.first_layer = margin;
  result.last_layer = result.spec.lattice.layers - margin - 1;
  std::vector<Replicated> upper, lower, bulk;
  const int bulk_layers = result.last_layer - result.first_layer + 1;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    const int in_bulk = sums.layers[row] - result.first_layer;
    const Replicated thrust = block_mean(sums, "thrust", row);
    if (sums.layers[row] == result.spec.lattice.layers - 1)
      result.alpha_of_last_layer = estimate(thrust, "no pile was completed");
    if (in_bulk < 0 || in_bulk >= bulk_layers) continue;
    bulk.push_back(thrust);
    if (2 * in_bulk < bulk_layers - 1) upper.push_back(thrust);
    if (2 * in_bulk > bulk_layers - 1) lower.push_back(thrust);
  }
  const Replicated alpha = mean_of(bulk);
  result.alpha = estimate(alpha, "no pile was completed");
  result.deficit_over_mu2 =
      estimate(transform([mu](double a) { return (1 - a) / (mu * mu); }, alpha), "no pile was completed");
  result.change_with_depth =
      estimate(transform([](double above, double below) { return below - above; }, mean_of(upper), mean_of(lower)),
               "no pile was completed");
  return result;
}

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const RejectionThrust& one) {
  return {{"law", "rejection"},
          {"mu", one.spec.sampler.mu},
          {"columns", one.spec.lattice.columns},
          {"layers", one.spec.lattice.layers},
          {"samples", one.samples},
          {"failed", one.failed},
          {"bulk_layers", {one.first_layer, one.last_layer}},
          {"alpha_thrust", granuscope::to_json(one.alpha)},
          {"deficit_over_mu_squared", granuscope::to_json(one.deficit_over_mu2)},
          {"change_with_depth", granuscope::to_json(one.change_with_depth)},
          {"alpha_of_last_layer", granuscope::to_json(one.alpha_of_last_layer)}};
}

/// To five standard errors: whether alpha is below 1, and moves over the bulk by less than its distance from 1.
bool settles_below_one(const RejectionThrust& one) {
  constexpr double sure = 5;
  if (!one.alpha.known() || !one.change_with_depth.known()) return false;
  const double distance = 1 - one.alpha.value;
  return distance > sure * one.alpha.standard_error &&
         std::abs(one.change_with_depth.value) + sure * one.change_with_depth.standard_error < distance;
}

class RejectionThrustStudy final : public CopiedStudy<RejectionThrustStudy> {
 public:
  explicit RejectionThrustStudy(std::vector<RejectionThrust> measured) : measured_(std::move(measured)) {}
  std::string id() const override { return "rejection_thrust"; }

  std::vector<Key> keys() override {
    return {
        make_key(
            table(), "mu", "",
            "friction coefficients, at most 0.3, at which the thrust ratio under the law rejection is taken "
            "from piles of several widths and depths; none: not at all",
            mu_,
            KeyRange{.ascending = true,
                     .why = "without friction the thrust ratio is 1 by definition, and above 0.3 rejection takes for "
                            "ever on piles deep enough to have a bulk"}
                .within(0, 0.3)
                .above(0))
            .formerly_at("exact_mu"),
        make_key(table(), "samples", "piles", "piles of each of these sizes", samples_).formerly_at("exact_samples")};
  }

  bool asked() const override { return !mu_.empty(); }

  Problem find_problem(const MainLine& main) const override {
    return find_samples_problem(key("samples"), samples_, main.response.blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const double mu : mu_) {
      for (const auto& [lattice, margin] : rejection_thrust_sizes(mu)) {
        all.push_back({fmt::format("thrust under rejection, mu = {}, {} x {}", mu, lattice.columns, lattice.layers),
                       fmt::format("exact-thrust-mu-{}-{}x{}", exact(mu), lattice.columns, lattice.layers),
                       main.uniform_piles(Law::rejection, mu, lattice, samples_), margin});
      }
    }
    return all;
  }

  /// Each ensemble's part is its margin.
  void add(const StudyEnsemble& which, const MeasuredEnsemble& ensemble) override {
    measured_.push_back(measure_rejection_thrust(ensemble, which.part));
  }

  Json json() const override { return list_of(measured_, to_json); }

  std::vector<ReportPart> parts(const Json&) const override {
    ReportPart thrust = part();
    thrust.overlay["exact_below_one"] = std::all_of(measured_.begin(), measured_.end(), settles_below_one);
    return {thrust};
  }

 private:
  std::vector<double> mu_;                 ///< empty: not measured
  std::uint64_t samples_ = 2048;           ///< piles at each friction and size
  std::vector<RejectionThrust> measured_;  ///< in the order of friction, then of columns
};

}  // namespace

std::unique_ptr<Study> rejection_thrust_study(std::vector<RejectionThrust> measured) {
  return std::make_unique<RejectionThrustStudy>(std::move(measured));
}

}  // namespace granuscope
