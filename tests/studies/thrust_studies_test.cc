#include "studies/thrust_studies.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "analysis/claims.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/estimator.h"
#include "kit/estimates.h"
#include "kit/naive_rejection.h"
#include "kit/sanitized.h"
#include "kit/small_piles.h"
#include "kit/text_parts.h"
#include "model/lattice.h"
#include "sampling/sampler.h"
#include "studies/made_up_ensemble.h"
#include "studies/study.h"
#include "studies/study_page.h"
#include "support/error.h"

namespace granuscope {
namespace {

using Catch::Matchers::Contains;
using test::known;

EnsembleSpec paired(double mu) {
  EnsembleSpec spec;
  spec.response.estimator = EstimatorName::paired;
  spec.sampler.mu = mu;
  spec.sampler.seed = 11;
  spec.lattice = {.columns = 80, .layers = 60};
  spec.response.samples = 128;
  spec.response.blocks = 8;
  spec.record_profiles = false;
  return spec;
}

}  // namespace

TEST_CASE(
    "Beads that fail when a pile is solved again are those that the sampler repairs, and fewer than those that "
    "change") {
  const EnsembleSpec spec = paired(0.3);
  const RedrawnBeads measured = measure_redrawn_beads({spec, run_ensemble(spec, 0, nullptr)});
  const Lattice lattice(spec.lattice);
  const auto sampler = make_sampler(spec.sampler, lattice);
  const std::vector<double> uniform(80, 1.0);
  std::vector<double> overloaded = uniform;
  overloaded[static_cast<std::size_t>(lattice.middle())] += spec.response.overload;
  Pile before(lattice), after(lattice);
  std::uint64_t repaired = 0;
  for (std::uint64_t sample = 0; sample < 128; ++sample) {
    REQUIRE(!sampler->draw(sample, uniform, before));
    sampler->take_counts();
    REQUIRE(!sampler->draw_again(sample, overloaded, before, after));
    const SamplerCounts counts = sampler->take_counts();
    repaired += counts.repaired_by_pair + counts.repaired_by_arc + counts.repaired_by_ring + counts.backtracked;
  }
  CHECK(measured.failing.value == Approx(static_cast<double>(repaired) / (128.0 * 80 * 60)).epsilon(1e-12));
  CHECK(measured.failing.standard_error > 0);
  CHECK(measured.failing.value < measured.whole_pile.value);
}

TEST_CASE("Shares in piles of other depths stand beside those of the experiment, which alone decide the claims") {
  const auto study = redrawn_beads_study();
  for (const Key& key : study->keys()) {
    if (key.name == "mu") key.set(std::vector<double>{0.1, 0.3});
    if (key.name == "other_layers") key.set(std::vector<std::int64_t>{40});
    if (key.name == "samples") key.set(std::int64_t{64});
  }
  MainLine main;
  main.lattice = {60, 60};
  main.response.blocks = 8;
  for (const StudyEnsemble& one : study->ensembles(main))
    study->add(one, {one.spec, run_ensemble(one.spec, 0, nullptr)});
  const auto json = study->json();
  REQUIRE(json.size() == 4);
  CHECK(json[3]["layers"] == 40);
  CHECK(json[3]["whole_pile"]["value"] < json[1]["whole_pile"]["value"]);
  CHECK(study->claims({}).at(0).measured.value == json[1]["whole_pile"]["value"]);
}

TEST_CASE("shares of redrawn beads are the means over the usable layers") {
  const EnsembleSpec spec = paired(0.3);
  EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  const RedrawnBeads shares = measure_redrawn_beads({spec, record});
  const Lattice lattice(spec.lattice);
  double whole = 0, below = 0, beads_below = 0;
  for (int layer = 0; layer < 40; ++layer) {
    int here = 0;
    for (int i = 0; i < 80; ++i) here += std::abs(lattice.x(layer, i)) <= Lattice::depth(layer) ? 1 : 0;
    CHECK(beads_below_overload(lattice, layer) == here);
    beads_below += here;
    for (std::size_t b = 0; b < 8; ++b) {
      const std::size_t row = b * 60 + static_cast<std::size_t>(layer);
      whole += record.sums.quantities.at("redrawn").sum[row] / (40.0 * 128);
      below += record.sums.quantities.at("redrawn_below_overload").sum[row] * here / 128;
    }
  }
  CHECK(shares.whole_pile.value == Approx(whole).epsilon(1e-12));
  CHECK(shares.below_overload.value == Approx(below / beads_below).epsilon(1e-12));
  CHECK(shares.whole_pile.standard_error > 0);
  CHECK(shares.whole_pile.standard_error < 0.2 * shares.whole_pile.value);
  double force = 0, redrawn = 0, usual = 0;
  const auto& sums = record.sums.quantities;
  for (int layer = 0; layer < 40; ++layer) {
    double force_here = 0, redrawn_here = 0, least_here = 0;
    for (std::size_t b = 0; b < 8; ++b) {
      const std::size_t row = b * 60 + static_cast<std::size_t>(layer);
      force_here += sums.at("redrawn_force").sum[row];
      redrawn_here += sums.at("redrawn").sum[row];
      least_here += sums.at("least_force").sum[row];
    }
    CHECK(least_here / 128 < 0.5 + 1e-12);  // half of the mean weight at most
    force += force_here;
    redrawn += redrawn_here;
    usual += redrawn_here * least_here / 128;
  }
  CHECK(shares.force.value == Approx(force / redrawn).epsilon(1e-12));
  CHECK(shares.relative_force.value == Approx(force / usual).epsilon(1e-12));
  CHECK(shares.together.value > 1);
  CHECK(shares.samples == 128);
  CHECK(shares.failed == 0);
  // The layers below the usable ones do not count.
  for (std::size_t b = 0; b < 8; ++b) record.sums.quantities.at("redrawn").sum[b * 60 + 40] = 1e9;
  CHECK(measure_redrawn_beads({spec, record}).whole_pile.value == shares.whole_pile.value);
}

TEST_CASE("more friction makes more beads redraw, and none without it") {
  double before = 0;
  for (const double mu : {0.05, 0.1, 0.3, 0.8}) {
    const EnsembleSpec spec = paired(mu);
    const RedrawnBeads shares = measure_redrawn_beads({spec, run_ensemble(spec, 0, nullptr)});
    CHECK(shares.whole_pile.value > before + 3 * shares.whole_pile.standard_error);
    CHECK(shares.below_overload.value > shares.whole_pile.value);
    before = shares.whole_pile.value;
  }
  const EnsembleSpec spec = paired(0);
  const RedrawnBeads none = measure_redrawn_beads({spec, run_ensemble(spec, 0, nullptr)});
  CHECK_FALSE(none.force.known());
  CHECK(none.whole_pile.value == 0);
  CHECK(none.whole_pile.standard_error == 0);
}

TEST_CASE("redrawn beads need the estimator paired, all usable layers and completed pairs") {
  EnsembleSpec spec = paired(0.3);
  EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  record.sums.count[2] = 0;
  const RedrawnBeads unknown = measure_redrawn_beads({spec, record});
  CHECK_FALSE(unknown.whole_pile.known());
  CHECK_FALSE(unknown.whole_pile.reason.empty());
  spec.layers = {0, 5, 39};
  CHECK_THROWS_AS(measure_redrawn_beads({spec, run_ensemble(spec, 0, nullptr)}), InputError);
  spec = paired(0.3);
  spec.response.estimator = EstimatorName::point;
  CHECK_THROWS_AS(measure_redrawn_beads({spec, run_ensemble(spec, 0, nullptr)}), InputError);
}

TEST_CASE("Rearrangements are what touches, counted by contacts and around the ring") {
  const Lattice lattice({.columns = 8, .layers = 6});
  std::vector<unsigned char> redrawn(lattice.beads(), 0);
  std::vector<int> beads;
  const auto at = [&](int layer, int bead) { return lattice.index(layer, bead); };
  redrawn[at(1, 2)] = redrawn[at(1, 3)] = 1;  // neighbours of a layer do not touch by a contact
  measure_rearrangements(lattice, redrawn, beads);
  CHECK(beads[at(1, 2)] == 1);
  CHECK(beads[at(0, 0)] == 0);
  redrawn[at(2, lattice.lower_right(1, 2))] = 1;                     // joins the two
  redrawn[at(4, 0)] = redrawn[at(5, lattice.lower_left(4, 0))] = 1;  // behind the ring
  measure_rearrangements(lattice, redrawn, beads);
  CHECK(beads[at(1, 2)] == 3);
  CHECK(beads[at(1, 3)] == 3);
  CHECK(lattice.lower_left(4, 0) == 7);
  CHECK(beads[at(4, 0)] == 2);
}

TEST_CASE("Rearrangements are local and prefer small forces if both hold at every friction") {
  std::vector<RedrawnBeads> measured;
  const auto beads = [](double mu, double force, double together) {
    RedrawnBeads made;
    made.spec.sampler.mu = mu;
    made.spec.response.overload = 2;
    made.force = known(force / 2, 0.01);
    made.relative_force = known(force, 0.01);
    made.together = known(together, 0.1);
    return made;
  };
  CHECK(judge_rearrangements(measured, 10).verdict == not_tested);
  measured = {beads(0.1, 0.6, 2), beads(0.3, 0.7, 5)};
  const Claim small = judge_rearrangements(measured, 10);
  CHECK(small.verdict == reproduced);
  CHECK(small.measured.value == 0.7);  // the one nearer to no preference
  CHECK(small.rival_distance == Approx(-30));
  CHECK_THAT(
      small.explanation,
      Contains("0.700(10) times the mean (0.17 of the overload) in rearrangements of 5.00(10) beads at μ = 0.3"));
  CHECK(judge_rearrangements(measured, 4).verdict == not_reproduced);
  CHECK(judge_rearrangements(measured, 5.1).verdict == not_decided);
  measured[0] = beads(0.1, 0.9, 2);  // ten errors below the mean, and no preference worth the name
  CHECK(judge_rearrangements(measured, 10).verdict == not_decided);
  measured[0] = beads(0.1, 1.04, 2);
  CHECK(judge_rearrangements(measured, 10).verdict == not_reproduced);
}

TEST_CASE("Both shares of redrawn beads must hold") {
  std::vector<RedrawnBeads> measured;
  const auto beads = [](double mu, double share, double error) {
    RedrawnBeads made;
    made.spec.sampler.mu = mu;
    made.samples = 512;
    made.whole_pile = known(share, error);
    made.below_overload = known(2 * share, error);
    return made;
  };
  measured = {beads(0.1, 0.0052, 0.0001), beads(0.3, 0.0235, 0.0002)};
  CHECK(judge_redraw_share(measured).verdict == reproduced);
  // "Of the order of": within a factor of 2, by three standard errors.
  measured[1] = beads(0.3, 0.031, 0.0002);
  const Claim more = judge_redraw_share(measured);
  CHECK(more.verdict == reproduced);
  CHECK(more.measured.value == 0.031);
  CHECK(more.paper == 0.024);
  CHECK_FALSE(std::isfinite(more.z_score));
  measured[1] = beads(0.3, 0.06, 0.0002);
  CHECK(judge_redraw_share(measured).verdict == not_reproduced);
  measured[1] = beads(0.3, 0.01, 0.0002);
  CHECK(judge_redraw_share(measured).verdict == not_reproduced);
  measured[1] = beads(0.3, 0.047, 0.001);
  CHECK(judge_redraw_share(measured).verdict == not_decided);
  measured[1] = beads(0.3, 0.0235, 0.01);
  CHECK(judge_redraw_share(measured).verdict == not_decided);
  measured.pop_back();
  const Claim half = judge_redraw_share(measured);
  CHECK(half.verdict == not_tested);
  CHECK_THAT(half.remarks, Contains("studies.redrawn_beads.mu"));
}

}  // namespace granuscope

using namespace granuscope;
using namespace granuscope::made_up;
using granuscope::test::known;

namespace {

/// Every layer down to the last one shown.
std::vector<int> shown_layers(int count) {
  std::vector<int> layers(static_cast<std::size_t>(count));
  std::iota(layers.begin(), layers.end(), 0);
  return layers;
}

}  // namespace

TEST_CASE("Without friction the whole response lies along the rays") {
  EnsembleSpec spec;
  spec.sampler.mu = 0;
  spec.lattice = {70, 80};
  spec.response.samples = 256;
  spec.layers = shown_layers(60);
  const ChainShare share = measure_chain_share({spec, run_ensemble(spec, 1, nullptr)});
  CHECK(share.layers == 60);
  CHECK(std::abs(share.c.value - tan30) < 1e-14);
  CHECK(std::abs(share.share.value - 1) < 1e-12);
  // From c0 z >= 6 on: z = 10.39, layer 12 of 0 .. 59.
  REQUIRE(share.depths.size() == 48);
  CHECK(share.depths.front().layer == 12);
  CHECK(share.depths.front().even_share == Approx(6 / (tan30 * Lattice::depth(12) + 3)));
}

TEST_CASE("A response spread evenly between the rays has the even share") {
  const LatticeSpec lattice{200, 100};
  MeasuredEnsemble ensemble = ensemble_of(0.3, lattice, shown_layers(80));
  const Lattice geometry(lattice);
  add_quantity(ensemble.record.sums, "thrust", 1, [](int, int, int) { return 0.81; });
  const double c = tan30 * 0.9;
  add_quantity(ensemble.record.sums, "weight", lattice.columns, [&](int, int row, int i) {
    const double reach = c * Lattice::depth(row) + chain_half_width, x = geometry.x(row, i);
    const double covered = std::max(0.0, std::min(x + 0.5, reach) - std::max(x - 0.5, -reach));
    return 1 + covered / (2 * reach);
  });
  const ChainShare share = measure_chain_share(ensemble);
  CHECK(share.c.value == Approx(c));
  for (const ChainShareAtDepth& depth : share.depths) {
    CAPTURE(depth.layer);
    // A bead that an edge of a band cuts is counted by width, whatever lies in it: an error of a few percent of a bead.
    CHECK(std::abs(depth.share.value - depth.even_share) < 0.5 / (c * depth.z + chain_half_width));
  }
  // Of an edge bead of which the part f is inside, f^2 is counted: on average 1/6 too little on either side.
  CHECK(share.share.value == Approx(share.even_share * (1 - 1 / (12 * chain_half_width))).epsilon(0.005));
}

TEST_CASE("Piles too shallow for two bands give a reason instead of a share") {
  MeasuredEnsemble ensemble = ensemble_of(0.3, {70, 30}, shown_layers(10));
  add_quantity(ensemble.record.sums, "thrust", 1, [](int, int, int) { return 0.9; });
  add_quantity(ensemble.record.sums, "weight", 70, [](int, int, int) { return 1.0; });
  const ChainShare share = measure_chain_share(ensemble);
  CHECK_FALSE(share.share.known());
  CHECK_FALSE(share.share.reason.empty());
}

TEST_CASE("Force chains carry more than half of the response and more than an even spread would put there") {
  ChainShare chains;
  chains.spec.sampler.mu = 0.1;
  chains.spec.lattice.columns = 70;
  chains.layers = 60;
  chains.samples = 512;
  chains.c = known(0.575, 0.001);
  chains.even_share = 0.3;
  chains.share = known(0.8, 0.01);
  chains.shown = known(0.9, 0);
  CHECK(judge_force_chains({chains}, 0.5).verdict == reproduced);
  CHECK(judge_force_chains({chains}, 0.5).measured.value == 0.9);
  chains.shown = known(0.4, 0);  // in the pile shown, whatever the mean
  CHECK(judge_force_chains({chains}, 0.5).verdict == not_reproduced);
  chains.shown = known(0.6, 0);
  chains.even_share = 0.7;
  CHECK(judge_force_chains({chains}, 0.5).verdict == not_reproduced);
  chains.shown = test::unknown("no layer lies deep enough");
  CHECK(judge_force_chains({chains}, 0.5).verdict == not_tested);
}

TEST_CASE("The share of the pile shown is that of the sample of the picture") {
  EnsembleSpec spec;
  spec.lattice = {70, 60 + bottom_margin};
  spec.sampler.mu = 0.1;
  spec.response.samples = 256;
  spec.layers = shown_layers(60);
  ChainShare chains = measure_chain_share({spec, run_ensemble(spec, 1, nullptr)});
  double sum = 0;
  for (std::uint64_t sample = 0; sample < spec.response.samples; ++sample) {
    measure_shown_pile(chains, sample);
    REQUIRE(chains.shown.known());
    sum += chains.shown.value;
  }
  // The same piles: their shares average to that of their mean.
  CHECK(sum / 256 == Approx(chains.share.value).epsilon(1e-9));
}

// Sources: sums made by hand; and naive_rejection.h, the law rejection by sequential Monte Carlo, a code of its own
// that shares nothing with the program.

using test::contains;
using test::piles_of;

TEST_CASE("The bulk leaves out a margin at both ends; its halves leave out the middle layer of an odd number") {
  const EnsembleSpec spec = piles_of(Law::rejection, 0.3, {4, 13}, 256);
  EnsembleRecord record = run_ensemble(spec, 1, nullptr);
  BlockSums& sums = record.sums;
  const auto set_thrust = [&](const auto& alpha_of) {
    auto& sum = sums.quantities.at("thrust").sum;
    for (std::size_t block = 0; block < sums.count.size(); ++block) {
      for (std::size_t row = 0; row < sums.layers.size(); ++row) {
        sum[block * sums.layers.size() + row] = static_cast<double>(sums.count[block]) * alpha_of(sums.layers[row]);
      }
    }
  };
  set_thrust([](int layer) { return layer < 4 || layer > 8 ? 100.0 : 0.9 + 0.01 * layer; });
  const RejectionThrust measured = measure_rejection_thrust({spec, record}, 4);
  CHECK(measured.first_layer == 4);
  CHECK(measured.last_layer == 8);
  CHECK(measured.samples == 256);
  CHECK(measured.alpha.value == Approx(0.96));
  CHECK(measured.deficit_over_mu2.value == Approx(0.04 / 0.09));
  CHECK(measured.change_with_depth.value == Approx(0.03));  // layers 7, 8 over 4, 5
  CHECK(measured.alpha_of_last_layer.value == Approx(100));
}

TEST_CASE("Under the exact law the thrust ratio settles below 1 by a share of mu squared, as another code has it",
          "[unsanitized]") {
  struct Size {
    double mu;
    LatticeSpec lattice;
  };
  constexpr std::size_t particles = test::sanitized ? 2000 : 10'000;
  for (const auto& [mu, lattice] : {Size{0.1, {6, 30}}, {0.2, {6, 20}}, {0.3, {6, 13}}}) {
    const EnsembleSpec spec = piles_of(Law::rejection, mu, lattice, 1024);
    const RejectionThrust measured = measure_rejection_thrust({spec, run_ensemble(spec, 2, nullptr)}, 4);
    const test::Estimated expected = test::naive_rejection_thrust(
        mu, lattice.columns, lattice.layers, measured.first_layer, measured.last_layer, particles, 8, 11);
    CAPTURE(mu, measured.alpha.value, measured.alpha.standard_error, measured.change_with_depth.value);
    CAPTURE(expected.value, expected.error);
    REQUIRE(measured.alpha.known());
    CHECK(std::abs(measured.alpha.value - expected.value) <
          5 * std::hypot(measured.alpha.standard_error, expected.error));
    CHECK(expected.error < 0.002);
    CHECK(1 - measured.alpha.value > 5 * measured.alpha.standard_error);
    CHECK(measured.deficit_over_mu2.value == Approx((1 - measured.alpha.value) / (mu * mu)));
  }
}

TEST_CASE("Piles for the exact thrust have about as many beads at each width, and a bulk between the margins") {
  for (const double mu : {1e-3, 0.05, 0.1, 0.2, 0.25, 0.3}) {
    const auto sizes = rejection_thrust_sizes(mu);
    REQUIRE(sizes.size() == 3);
    for (const RejectionThrustSize& size : sizes) {
      CAPTURE(mu, size.lattice.columns, size.lattice.layers, size.margin);
      CHECK(size.margin >= 4);
      CHECK(size.lattice.layers - 2 * size.margin >= 2);
      CHECK(size.lattice.layers <= 400);
    }
    CHECK(sizes.front().lattice.columns < sizes.back().lattice.columns);
    CHECK(sizes.front().margin == sizes.back().margin);
  }
}

TEST_CASE("The thrust of the exact law is said to settle below 1 only where the numbers say so") {
  const auto page = [](const std::vector<RejectionThrust>& measured) {
    return study_page(*rejection_thrust_study(measured));
  };
  CHECK_FALSE(contains(page({}).html, "tend to 1 under the exact law"));
  RejectionThrust one;
  one.spec.sampler.mu = 0.3;
  one.spec.lattice = {4, 20};
  one.alpha = known(0.93, 0.001);
  one.deficit_over_mu2 = known(0.78, 0.01);
  one.change_with_depth = known(0.002, 0.002);
  one.alpha_of_last_layer = known(0.99, 0.002);
  std::vector<RejectionThrust> measured(2, one);
  const auto settles = [&] { return contains(page(measured).html, "It does not: at every friction"); };
  CHECK(settles());
  CHECK(page(measured).texts.at("/studies/rejection_thrust/1/deficit_over_mu_squared") == "0.780(10)");
  measured[1].alpha = known(0.996, 0.001);
  CHECK_FALSE(settles());
  measured[1] = one;
  measured[1].change_with_depth = known(0.03, 0.01);
  CHECK_FALSE(settles());
  measured[1].change_with_depth = test::unknown("too few");
  CHECK_FALSE(settles());
  CHECK(contains(page(measured).html, "These piles do not decide it"));
}
