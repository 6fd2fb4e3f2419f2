#include "studies/thrust_studies.h"

#include <fmt/ranges.h>

#include <array>
#include <numeric>

#include "analysis/claims.h"
#include "ensemble/estimator.h"
#include "sampling/sampler.h"

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
  result.samples = sums.samples();
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

void to_json(Json& json, const RejectionThrust& one) {
  json = {{"law", "rejection"},
          {"mu", one.spec.sampler.mu},
          {"columns", one.spec.lattice.columns},
          {"layers", one.spec.lattice.layers},
          {"samples", one.samples},
          {"failed", one.failed},
          {"bulk_layers", {one.first_layer, one.last_layer}},
          {"alpha_thrust", one.alpha},
          {"deficit_over_mu_squared", one.deficit_over_mu2},
          {"change_with_depth", one.change_with_depth},
          {"alpha_of_last_layer", one.alpha_of_last_layer}};
}

namespace {

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
    return {make_key(table(), "mu", "",
                     "friction coefficients, at most 0.3, at which the thrust ratio under the law rejection is taken "
                     "from piles of several widths and depths; none: not at all",
                     mu_,
                     KeyRange{.ascending = true,
                              .why = "without friction the thrust ratio is 1 by definition, and above 0.3 rejection "
                                     "takes for ever on piles deep enough to have a bulk"}
                         .within(0, 0.3)
                         .above(0)),
            make_key(table(), "samples", "piles", "piles of each of these sizes", samples_)};
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

  Json json() const override { return measured_; }

  std::vector<ReportPart> parts() const override {
    ReportPart thrust = part();
    thrust.overlay["exact_below_one"] = std::ranges::all_of(measured_, settles_below_one);
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

std::string percent_text(const Estimate& share) {
  return value_with_error(100 * share.value, 100 * share.standard_error) + " %";
}

/// Adds the share of the beads below the overload to a list in words.
void say_below(std::string& list, const RedrawnBeads& beads) {
  if (!beads.below_overload.known()) return;
  list += fmt::format("{}{} at μ = {}", list.empty() ? "" : ", ", percent_text(beads.below_overload),
                      beads.spec.sampler.mu);
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
        "the ensemble does not hold the redrawn beads of all usable layers, so that their share is not known; draw it "
        "with the estimator paired, more than {} layers, and all of them recorded",
        bottom_margin);
  }
  RedrawnBeads result;
  result.spec = spec;
  result.failed = record.failed.size();
  result.samples = sums.samples();
  if (std::ranges::find(sums.count, 0) != sums.count.end()) {
    for (Estimate* one : {&result.whole_pile, &result.below_overload, &result.failing, &result.force,
                          &result.relative_force, &result.together}) {
      one->reason = "a block of the ensemble holds no completed pair of piles";
    }
    return result;
  }
  const auto in_pile = [&](const char* quantity) {
    return share_of_pile(sums, quantity, usable, [](int) { return 1.0; });
  };
  const Replicated redrawn = in_pile("redrawn");
  result.whole_pile = estimate(redrawn);
  result.failing = estimate(block_mean(sums, "failing_again", 0));
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
                           "With the standard procedure of the order of 0.5 % (μ = 0.1) and 2.4 % (μ = 0.3) of the "
                           "beads change their random number.",
                           "share of beads");
  std::vector<double> missing;
  std::vector<std::string> clauses;
  std::string below;
  bool failed = false, open = false;
  double farthest = 0;
  for (const StatedShare& one : stated_shares) {
    const auto found = std::ranges::find_if(
        measured, [&](const RedrawnBeads& beads) { return std::abs(beads.spec.sampler.mu - one.mu) < 1e-9; });
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
    const std::string failing =
        found->failing.known() ? fmt::format(" ({} find no solution)", percent_text(found->failing)) : "";
    clauses.push_back(fmt::format("{} of the beads draw again{} at μ = {}, {} times {} the paper’s {} %",
                                  percent_text(share), failing, one.mu, significant(factor, 3),
                                  share.value > one.share ? "as many as" : "fewer than", 100 * one.share));
    say_below(below, *found);
    if (factor > farthest) {
      farthest = factor;
      claim.quantity = fmt::format("share of beads at μ = {}; a factor of {} is allowed", one.mu, same_order_up_to);
      claim.measured = share;
      claim.paper = one.share;
    }
  }
  if (!claim.measured.known()) {
    leave_open(claim, clauses.empty()
                          ? "nothing was measured with the standard procedure: set studies.redrawn_beads.mu = [0.1, "
                            "0.3]; a few hundred pairs of piles are enough"
                          : fmt::format("studies.redrawn_beads has no share: {}", fmt::join(clauses, "; ")));
    return claim;
  }
  claim.verdict = failed ? not_reproduced : !missing.empty() ? not_tested : open ? not_decided : reproduced;
  add_sentence(claim, "{}; up to a factor of {} counts as of that order.", fmt::join(clauses, "; "), same_order_up_to);
  if (!missing.empty()) {
    add_sentence(claim, "The other number of the paper needs {} in studies.redrawn_beads.mu.", list_of_values(missing));
  }
  if (!below.empty()) add_sentence(claim, "Of the beads with |x| ≤ z it is {}.", below);
  return claim;
}

Claim judge_rearrangements(const std::vector<RedrawnBeads>& measured, double most_together) {
  Claim claim = open_claim("local-rearrangements",
                           "The beads that change their random number are few together, and preferably those of forces "
                           "small beside the overload.",
                           "force of such a bead over the mean");
  // A preference is told from none by its size, not by how sharply it is known: as much as must be detected elsewhere.
  constexpr double no_preference = 1, preference = no_preference - deviation_to_detect;
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
    open = open || above(one.relative_force, preference) > -agreement || large > -agreement;
    clauses.push_back(fmt::format("{} times the mean ({} of the overload) in rearrangements of {} beads at μ = {}",
                                  value_with_error(one.relative_force),
                                  significant(one.force.value / one.spec.response.overload, 2),
                                  value_with_error(one.together), one.spec.sampler.mu));
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
  add_sentence(claim,
               "Before the overload acts the smaller force that a bead which draws again hands down is {}; the mean is "
               "that of all beads at its depth, and up to {} beads that touch count as local.",
               fmt::join(clauses, ", "), most_together);
  add_sentence(claim,
               "Against the mean of all beads the weakest preference is {} %; the paper does not say how strong, and "
               "from {} % on it counts as one here.",
               significant(100 * (no_preference - claim.measured.value), 2),
               significant(100 * (no_preference - preference), 2));
  return claim;
}

void to_json(Json& json, const RedrawnBeads& redrawn) {
  json = {{"mu", redrawn.spec.sampler.mu},
          {"columns", redrawn.spec.lattice.columns},
          {"layers", redrawn.spec.lattice.layers},
          {"overload", redrawn.spec.response.overload},
          {"samples", redrawn.samples},
          {"failed", redrawn.failed},
          {"whole_pile", redrawn.whole_pile},
          {"below_overload", redrawn.below_overload},
          {"failing", redrawn.failing},
          {"force", redrawn.force},
          {"relative_force", redrawn.relative_force},
          {"together", redrawn.together}};
}

namespace {

class RedrawnBeadsStudy final : public CopiedStudy<RedrawnBeadsStudy> {
 public:
  std::string id() const override { return "redrawn_beads"; }

  std::vector<Key> keys() override {
    return {make_key(table(), "mu", "",
                     "friction coefficients at which the standard procedure is followed too; none: not at all", mu_,
                     friction_range_above_zero()),
            make_key(table(), "samples", "pairs of piles", "pairs per friction coefficient, at least eight per block",
                     samples_),
            make_key(table(), "other_layers", "layers", "also in piles of so many layers, beside the experiment's own",
                     other_layers_,
                     KeyRange{.why = "the shares are those of the layers above the last 20"}.within(bottom_margin + 1,
                                                                                                    100'000)),
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
    for (std::size_t k = 0; k < mu_.size() * (1 + other_layers_.size()); ++k) {
      const double mu = mu_[k % mu_.size()];
      LatticeSpec lattice = main.lattice;
      if (k >= mu_.size()) lattice.layers = other_layers_[k / mu_.size() - 1];
      EnsembleSpec spec = main.ensemble_at(mu, lattice, samples_);
      spec.response.estimator = EstimatorName::paired;
      spec.layers.resize(static_cast<std::size_t>(Lattice(spec.lattice).usable_layers()));
      std::iota(spec.layers.begin(), spec.layers.end(), 0);
      spec.record_profiles = false;
      const std::string size = k < mu_.size() ? "" : fmt::format("-layers-{}", lattice.layers);
      all.push_back({fmt::format("redrawn beads{}, mu = {}", size, mu),
                     fmt::format("redrawn-beads{}-mu-{}", size, exact(mu)), spec, size.empty() ? 0 : 1});
    }
    return all;
  }

  void add(const StudyEnsemble& one, const MeasuredEnsemble& ensemble) override {
    (one.part == 0 ? measured_ : other_sizes_).push_back(measure_redrawn_beads(ensemble));
  }

  std::vector<Claim> claims(const ClaimSpec&) const override {
    return {judge_redraw_share(measured_), judge_rearrangements(measured_, most_together_)};
  }

  Json json() const override {
    std::vector<RedrawnBeads> all = measured_;
    all.insert(all.end(), other_sizes_.begin(), other_sizes_.end());
    return all;
  }

  std::vector<ReportPart> parts() const override { return {table_part()}; }

 private:
  std::vector<double> mu_;       ///< empty: not measured
  std::uint64_t samples_ = 512;  ///< pairs of piles per friction coefficient
  double most_together_ = 10;    ///< chosen before it was measured
  std::vector<int> other_layers_;
  std::vector<RedrawnBeads> measured_, other_sizes_;  ///< ascending in mu; claims look at the former
};

}  // namespace

std::unique_ptr<Study> redrawn_beads_study() { return std::make_unique<RedrawnBeadsStudy>(); }

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

/// Standard deviation of the share between single piles.
double scatter_of_piles(const ChainShare& chains) {
  return chains.share.standard_error * std::sqrt(static_cast<double>(chains.samples));
}

}  // namespace

ChainShare measure_chain_share(const MeasuredEnsemble& ensemble) {
  const BlockSums& sums = ensemble.record.sums;
  const Lattice lattice(ensemble.spec.lattice);
  ChainShare result;
  result.spec = ensemble.spec;
  result.layers = static_cast<int>(sums.layers.size());
  result.samples = sums.samples();
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
               "the share of the response along the rays was not measured: set studies.chain_share.samples; a few "
               "hundred piles of 70 × 60 beads are enough");
    return claim;
  }
  const ChainShare& chains = measured.front();
  claim.statement = fmt::format("The picture of {} × {} beads at μ = {} shows two oblique force chains.",
                                chains.spec.lattice.columns, chains.layers, chains.spec.sampler.mu);
  if (!chains.shown.known()) {
    leave_open(claim, "the share of the response along the rays is unknown: {}", chains.shown.reason);
    return claim;
  }
  claim.measured.value = chains.shown.value;  // of one picture: without an error
  const double needed = std::max(least_share, chains.even_share);
  claim.verdict = chains.shown.value > needed ? reproduced : not_reproduced;
  claim.explanation = fmt::format(
      "In the pile shown a share of {} of the response lies within {} beads of the rays x = ±c z, c = {} by the thrust "
      "ratio of such piles; spread evenly between the rays it would be {}, and more than {} is asked for.",
      significant(chains.shown.value, 2), chains.half_width, value_with_error(chains.c),
      significant(chains.even_share, 2), significant(needed, 2));
  add_sentence(claim, "The mean over {} piles is {}; single piles scatter by {}.", chains.samples,
               value_with_error(chains.share), significant(scatter_of_piles(chains), 2));
  return claim;
}

void to_json(Json& json, const ChainShare& share) {
  Json depths = Json::array();
  for (const ChainShareAtDepth& depth : share.depths) {
    depths.push_back(
        {{"layer", depth.layer}, {"z", depth.z}, {"share", depth.share}, {"even_share", depth.even_share}});
  }
  json = {{"mu", share.spec.sampler.mu},
          {"columns", share.spec.lattice.columns},
          {"layers", share.layers},
          {"overload", share.spec.response.overload},
          {"samples", share.samples},
          {"half_width", share.half_width},
          {"c", share.c},
          {"share", share.share},
          {"even_share", share.even_share},
          {"shown_sample", share.shown_sample},
          {"shown_share", finite_or_null(share.shown.value)},
          {"scatter_of_piles", finite_or_null(scatter_of_piles(share))},
          {"reason", "a share is null where the two bands are nowhere apart, or no pile was completed"},
          {"depths", depths}};
}

namespace {

class ChainShareStudy final : public CopiedStudy<ChainShareStudy> {
 public:
  std::string id() const override { return "chain_share"; }

  std::vector<Key> keys() override {
    return {
        make_key(table(), "samples", "piles",
                 "piles of the size of scenes.force_chains from which the share of the response along the rays is "
                 "taken, at least eight per block; 0: none",
                 samples_),
        make_key(
            table(), "least_share", "", "force-chains: share of the response that the two rays must carry",
            least_share_,
            KeyRange{.why = "it is not a share that the response could fall short of or exceed"}.above(0).below(1))};
  }

  bool asked() const override { return samples_ > 0; }

  void derive(MainLine& main, const IsOpen& open) override {
    ForceChainSpec& chains = main.force_chains;
    if (open("scenes.force_chains.columns"))
      chains.columns = std::max(chains.columns, static_cast<int>(std::ceil(least_columns(chains))));
    Study::derive(main, open);
  }

  Problem find_problem(const MainLine& main) const override {
    if (auto found = find_samples_problem(key("samples"), samples_, main.response.blocks)) return found;
    const ForceChainSpec& chains = main.force_chains;
    if (chains.columns >= least_columns(chains)) return {};
    return problem("scenes.force_chains.columns",
                   "with {} columns the two rays of the response meet behind the ring above layer {}, so that {} would "
                   "count one for the other; give at least {} columns",
                   chains.columns, chains.layers, table(), std::ceil(least_columns(chains)));
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    const ForceChainSpec& chains = main.force_chains;
    EnsembleSpec spec = main.ensemble_at(chains.mu, {chains.columns, chains.computed_layers()}, samples_);
    spec.layers.resize(static_cast<std::size_t>(chains.layers));
    std::iota(spec.layers.begin(), spec.layers.end(), 0);
    return {{fmt::format("share along the rays, mu = {}", chains.mu), "chain-share", spec}};
  }

  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override {
    measured_.push_back(measure_chain_share(ensemble));
    measure_shown_pile(measured_.back(), main_.force_chains.sample);
  }

  std::vector<Claim> claims(const ClaimSpec&) const override { return {judge_force_chains(measured_, least_share_)}; }

  Json json() const override { return measured_; }

  std::vector<ReportPart> parts() const override { return {part()}; }

 private:
  /// So that the two rays of the response do not meet behind the ring.
  static double least_columns(const ForceChainSpec& chains) {
    return 2 * (tan30 * Lattice::depth(chains.layers - 1) + chain_half_width);
  }

  std::uint64_t samples_ = 0;
  double least_share_ = 0.5;          ///< fixed beforehand
  std::vector<ChainShare> measured_;  ///< at most one
};

}  // namespace

std::unique_ptr<Study> chain_share_study() { return std::make_unique<ChainShareStudy>(); }

}  // namespace granuscope
