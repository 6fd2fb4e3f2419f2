#include "studies/chain_share.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "analysis/claim_rule.h"
#include "analysis/layer_spectrum.h"
#include "model/lattice.h"
#include "report/estimate_json.h"
#include "sampling/sampler.h"
#include "studies/common_checks.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// Part of the unit interval around x that lies in [low, high].
double overlap(double x, double low, double high) {
  return std::max(0.0, std::min(x + 0.5, high) - std::max(x - 0.5, low));
}

/// Share of the response `weight` - 1 of one layer that lies within chain_half_width of x = +-ray.
double share_near(const Lattice& lattice, int layer, const std::vector<double>& weight, double ray) {
  double inside = 0, all = 0;
  for (int i = 0; i < lattice.columns(); ++i) {
    const double x = lattice.x(layer, i), response = weight[static_cast<std::size_t>(i)] - 1;
    inside += response * (overlap(x, ray - chain_half_width, ray + chain_half_width) +
                          overlap(x, -ray - chain_half_width, -ray + chain_half_width));
    all += response;
  }
  return inside / all;
}

}  // namespace

double scatter_of_piles(const ChainShare& chains) {
  return chains.share.standard_error * std::sqrt(static_cast<double>(chains.samples));
}

ChainShare measure_chain_share(const MeasuredEnsemble& ensemble) {
  const BlockSums& sums = ensemble.record.sums;
  const Lattice lattice(ensemble.spec.lattice);
  ChainShare result;
  result.spec = ensemble.spec;
  result.layers = static_cast<int>(sums.layers.size());
  result.samples = std::accumulate(sums.count.begin(), sums.count.end(), std::uint64_t{0});
  result.half_width = chain_half_width;

  const Replicated c = thrust_speed(sums, 0);
  result.c = estimate(c, "the mean thrust ratio is negative");
  result.share.reason = "no layer lies deep enough for the two bands to be apart";
  if (!result.c.known()) {
    result.share.reason = result.c.reason;
    return result;
  }

  std::vector<Replicated> shares;
  double even = 0;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    const int layer = sums.layers[row];
    const double z = Lattice::depth(layer), ray = c.value * z;
    if (ray < 2 * chain_half_width) continue;
    const BlockMeans weight = block_means(sums, "weight", row);
    Replicated share;
    share.value = share_near(lattice, layer, weight.whole, ray);
    for (std::size_t b = 0; b < weight.without_block.size(); ++b) {
      share.without_block.push_back(share_near(lattice, layer, weight.without_block[b], c.without_block[b] * z));
    }
    const double even_share = 2 * chain_half_width / (ray + chain_half_width);
    result.depths.push_back({layer, z, estimate(share), even_share});
    shares.push_back(std::move(share));
    even += even_share;
  }
  if (shares.empty()) return result;
  result.share = estimate(mean_of(shares));
  result.even_share = even / static_cast<double>(shares.size());
  return result;
}

void measure_shown_pile(ChainShare& chains, std::uint64_t sample) {
  chains.shown_sample = sample;
  if (!chains.share.known()) {
    chains.shown.reason = chains.share.reason;
    return;
  }
  Pile pile{Lattice(chains.spec.lattice)};
  EnsembleSpec spec = chains.spec;
  spec.load = Load::point;
  if (make_sampler(spec.sampler, pile.lattice)->draw(sample, top_load(spec), pile)) {
    chains.shown.reason = "the pile of the picture could not be completed";
    return;
  }
  const auto columns = static_cast<std::size_t>(pile.lattice.columns());
  std::vector<double> weight(columns);
  double sum = 0;
  for (const ChainShareAtDepth& depth : chains.depths) {
    const std::size_t row = pile.lattice.index(depth.layer, 0);
    for (std::size_t i = 0; i < columns; ++i) weight[i] = pile.V_R[row + i] + pile.V_L[row + i];
    sum += share_near(pile.lattice, depth.layer, weight, chains.c.value * depth.z);
  }
  chains.shown.value = sum / static_cast<double>(chains.depths.size());
}

Claim judge_force_chains(const std::vector<ChainShare>& measured, double least_share) {
  Claim claim = open_claim("force-chains", "The picture of 70 × 60 beads at μ = 0.1 shows two oblique force chains.",
                           "share of the response along the rays");
  if (measured.empty()) {
    leave_open(claim,
               "the share of the response along the rays was not measured: set studies.chain_share.samples; a "
               "few hundred piles of 70 × 60 beads are enough");
    return claim;
  }
  const ChainShare& chains = measured.front();
  claim.statement = fmt::format("The picture of {} × {} beads at μ = {} shows two oblique force chains.",
                                chains.spec.lattice.columns, chains.layers, chains.spec.sampler.mu);
  if (!chains.shown.known()) {
    leave_open(claim, fmt::format("the share of the response along the rays is unknown: {}", chains.shown.reason));
    return claim;
  }
  claim.measured.value = chains.shown.value;  // of one picture: without an error
  const double needed = std::max(least_share, chains.even_share);
  claim.verdict = chains.shown.value > needed ? reproduced : not_reproduced;
  claim.explanation = fmt::format(
      "In the pile shown a share of {} of the response lies within {} beads of the rays x = ±c z, c = {} by the thrust "
      "ratio of such piles; spread evenly between the rays it would be {}, and more than {} is asked for.",
      significant(chains.shown.value, 2), chains.half_width, value_with_error(chains.c.value, chains.c.standard_error),
      significant(chains.even_share, 2), significant(needed, 2));
  add_sentence(claim, fmt::format("The mean over {} piles is {}; single piles scatter by {}.", chains.samples,
                                  value_with_error(chains.share.value, chains.share.standard_error),
                                  significant(scatter_of_piles(chains), 2)));
  return claim;
}

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const ChainShare& share) {
  Json depths = Json::array();
  for (const ChainShareAtDepth& depth : share.depths) {
    depths.push_back({{"layer", depth.layer},
                      {"z", depth.z},
                      {"share", granuscope::to_json(depth.share)},
                      {"even_share", depth.even_share}});
  }
  return {{"mu", share.spec.sampler.mu},
          {"columns", share.spec.lattice.columns},
          {"layers", share.layers},
          {"overload", share.spec.response.overload},
          {"samples", share.samples},
          {"half_width", share.half_width},
          {"c", granuscope::to_json(share.c)},
          {"share", granuscope::to_json(share.share)},
          {"even_share", share.even_share},
          {"shown_sample", share.shown_sample},
          {"shown_share", finite_or_null(share.shown.value)},
          {"scatter_of_piles", finite_or_null(scatter_of_piles(share))},
          {"reason", "a share is null where the two bands are nowhere apart, or no pile was completed"},
          {"depths", depths}};
}

class ChainShareStudy final : public CopiedStudy<ChainShareStudy> {
 public:
  std::string id() const override { return "chain_share"; }

  std::vector<Key> keys() override {
    return {
        make_key(table(), "samples", "piles",
                 "piles of the size of scenes.force_chains from which the share of the response along the rays is "
                 "taken, at least eight per block; 0: none",
                 samples_),
        make_key(table(), "least_share", "", "force-chains: share of the response that the two rays must carry",
                 least_share_,
                 KeyRange{.why = "it is not a share that the response could fall short of or exceed"}.above(0).below(1))
            .formerly_at("claims.chain_share")};
  }

  bool asked() const override { return samples_ > 0; }

  Problem find_problem(const MainLine& main) const override {
    if (auto found = find_samples_problem(key("samples"), samples_, main.response.blocks)) return found;
    const ForceChainSpec& chains = main.force_chains;
    const double least = 2 * (tan30 * Lattice::depth(chains.layers - 1) + chain_half_width);
    if (chains.columns >= least) return {};
    return problem("scenes.force_chains.columns",
                   "with {} columns the two rays of the response meet behind the ring above layer {}, so that {} would "
                   "count one for the other; give at least {} columns",
                   chains.columns, chains.layers, table(), std::ceil(least));
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    const ForceChainSpec& chains = main.force_chains;
    EnsembleSpec spec = main.ensemble_at(chains.mu, {chains.columns, chains.computed_layers()}, samples_);
    spec.layers.resize(static_cast<std::size_t>(chains.layers));
    std::iota(spec.layers.begin(), spec.layers.end(), 0);
    return {{fmt::format("share along the rays, mu = {}", chains.mu), "chain-share", spec}};
  }

  void begin(const MainLine& main, int) override { shown_sample_ = main.force_chains.sample; }

  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override {
    measured_.push_back(measure_chain_share(ensemble));
    measure_shown_pile(measured_.back(), shown_sample_);
  }

  std::vector<Claim> claims(const ClaimSpec&) const override { return {judge_force_chains(measured_, least_share_)}; }

  Json json() const override { return list_of(measured_, to_json); }

  std::vector<ReportPart> parts(const Json&) const override { return {part()}; }

 private:
  std::uint64_t samples_ = 0;
  double least_share_ = 0.5;          ///< fixed beforehand
  std::uint64_t shown_sample_ = 0;    ///< of the picture
  std::vector<ChainShare> measured_;  ///< at most one
};

}  // namespace

std::unique_ptr<Study> chain_share_study() { return std::make_unique<ChainShareStudy>(); }

}  // namespace granuscope
