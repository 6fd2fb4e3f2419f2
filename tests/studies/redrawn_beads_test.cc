#include "studies/thrust_studies.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/claims.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/estimator.h"
#include "kit/estimates.h"
#include "sampling/sampler.h"
#include "studies/study.h"
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
