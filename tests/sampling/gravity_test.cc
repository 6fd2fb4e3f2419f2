// Beads that have a weight of their own, under every law. Source of the expected numbers: the balances, and the laws
// "rejection" and "granusolve" a second time (tests/kit).
#include <catch2/catch.hpp>
#include <cmath>

#include "kit/instruction_sets.h"
#include "kit/naive_granusolve.h"
#include "kit/naive_rejection.h"
#include "model/audit.h"
#include "sampling/sampler.h"
#include "support/error.h"

namespace granuscope {
namespace {

SamplerSpec heavy(double mu, double bead_weight, Law law = Law::granusolve) {
  SamplerSpec spec;
  spec.law = law;
  spec.mu = mu;
  spec.bead_weight = bead_weight;
  return spec;
}

Pile drawn(const SamplerSpec& spec, LatticeSpec size, double load = 1) {
  Pile pile{Lattice(size)};
  const std::vector<double> loads(static_cast<std::size_t>(size.columns), load);
  REQUIRE_FALSE(make_sampler(spec, pile.lattice)->draw(3, loads, pile));
  return pile;
}

/// Mean weight that leaves the beads of a layer, and sqrt(3) times the mean of H_R - H_L.
std::pair<double, double> weight_and_thrust(const Pile& pile, int layer) {
  double weight = 0, thrust = 0;
  for (int i = 0; i < pile.lattice.columns(); ++i) {
    const std::size_t at = pile.lattice.index(layer, i);
    weight += pile.V_R[at] + pile.V_L[at];
    thrust += std::sqrt(3.0) * (pile.H_R[at] - pile.H_L[at]);
  }
  return {weight / pile.lattice.columns(), thrust / pile.lattice.columns()};
}

std::vector<double> uniform(int columns) { return std::vector<double>(static_cast<std::size_t>(columns), 1.0); }

}  // namespace

TEST_CASE("The weight of beads goes down whole, under every law, and the audit finds every balance") {
  struct Case {
    Law law;
    LatticeSpec size;
    double mu;
  };
  for (const auto& [law, size, mu] :
       {Case{Law::granusolve, {48, 40}, 0.1}, Case{Law::granusolve, {48, 40}, 0.8},
        Case{Law::granusolve, {48, 40}, 1.7}, Case{Law::eloy_clement, {4, 4}, 0.5}, Case{Law::rejection, {5, 5}, 0.5},
        Case{Law::polytope, {8, 8}, 0.5}, Case{Law::granusolve, {16, 12}, 0}}) {
    for (const double g : {0.01, 1.0, 50.0}) {
      CAPTURE(name_of(law), mu, g);
      const Pile pile = drawn(heavy(mu, g, law), size);
      CHECK(pile.bead_weight == g);
      const AuditResult result = audit(pile);
      CHECK(result.max_balance_residual < 1e-12);
      CHECK(result.max_cone_violation < 1e-12);
      CHECK_NOTHROW(assert_identities(pile));
      for (int layer = 0; layer < size.layers; ++layer) {
        CHECK(weight_and_thrust(pile, layer).first == Approx(1 + g * (layer + 1)).epsilon(1e-13));
      }
      // Neither would hold of beads without weight.
      Pile light = pile;
      light.bead_weight = 0;
      CHECK(audit(light).max_balance_residual > 1e-4);
      CHECK_THROWS_AS(assert_identities(light), std::logic_error);
    }
  }
}

TEST_CASE("Without friction half of each bead's weight goes down either lattice row") {
  const Pile pile = drawn(heavy(0, 0.25), {8, 10}, 2);
  for (int layer = 0; layer < 10; ++layer) {
    for (int i = 0; i < 8; ++i) {
      const std::size_t at = pile.lattice.index(layer, i);
      CHECK(pile.V_R[at] == 1 + 0.125 * (layer + 1));  // exact in binary
      CHECK(pile.V_L[at] == pile.V_R[at]);
    }
  }
}

TEST_CASE("Twice the loads and twice the weights are twice the forces, bit by bit") {
  const LatticeSpec size{40, 50};
  const Pile one = drawn(heavy(0.4, 0.3), size), two = drawn(heavy(0.4, 0.6), size, 2);
  for (std::size_t at = 0; at < one.lattice.beads(); ++at) {
    REQUIRE(two.V_R[at] == 2 * one.V_R[at]);
    REQUIRE(two.H_R[at] == 2 * one.H_R[at]);
  }
}

TEST_CASE("Heavy beads drawn side by side are those drawn alone, bit by bit, on every instruction set") {
  // The last friction has arcs and backtracks.
  for (const auto& [mu, g] : {std::pair{0.1, 0.02}, {0.3, 1.0}, {1.2, 0.3}}) {
    const SamplerSpec spec = heavy(mu, g);
    const Lattice lattice({40, 64});
    const std::vector<double> load = uniform(40);
    const std::vector<std::uint64_t> samples{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    const std::vector<std::span<const double>> loads(samples.size(), load);
    std::vector<std::optional<SamplingFailure>> failures(samples.size());
    const auto alone = make_sampler(spec, lattice);
    std::vector<Pile> expected;
    for (const std::uint64_t sample : samples) {
      REQUIRE_FALSE(alone->draw(sample, load, expected.emplace_back(lattice)));
    }
    for_each_instruction_set([&] {
      const auto together = make_sampler(spec, lattice);
      for (const PileGroup& group : together->draw_groups(samples, loads, failures)) {
        CHECK_NOTHROW(assert_identities(group, failures));
        for (std::size_t k = 0; k < group.piles; ++k) {
          const Pile other = pile_of(group, k), &one = expected[group.first_sample + k];
          CHECK(other.V_R == one.V_R);
          CHECK(other.V_L == one.V_L);
          CHECK(other.H_R == one.H_R);
          CHECK(other.H_L == one.H_L);
          CHECK(other.bead_weight == g);
        }
      }
    });
  }
}

TEST_CASE("The law rejection with heavy beads is that of a second implementation") {
  constexpr double mu = 0.4, g = 0.5;
  constexpr int columns = 5, layers = 4, accepted = 4000;
  const auto sampler = make_sampler(heavy(mu, g, Law::rejection), Lattice({columns, layers}));
  Pile pile{Lattice({columns, layers})};
  test::NaiveRejection law(mu, columns, 7, g);
  std::vector<test::NaiveRejection::Layer> naive(layers, law.empty_layer());
  std::vector<test::RunningMean> found(layers), expected(layers);
  for (std::uint64_t sample = 0; sample < accepted; ++sample) {
    REQUIRE_FALSE(sampler->draw(sample, uniform(columns), pile));
    std::size_t n = 0;
    while (n < layers) n = law.draw_layer(n == 0 ? nullptr : &naive[n - 1], naive[n]) ? n + 1 : 0;
    for (n = 0; n < layers; ++n) {
      found[n].add(weight_and_thrust(pile, static_cast<int>(n)).second);
      expected[n].add(law.thrust_ratio(naive[n]));
    }
  }
  for (std::size_t n = 0; n < layers; ++n) {
    CAPTURE(n, found[n].estimate().value, expected[n].estimate().value, found[n].estimate().error);
    CHECK(std::abs(test::sigmas(found[n].estimate(), expected[n].estimate())) < test::sigma_bound(layers));
    CHECK(found[n].estimate().error < 0.01 * found[n].estimate().value);
  }
}

TEST_CASE("The law granusolve with heavy beads is that of a second implementation, and differs from light ones") {
  constexpr double mu = 0.5, g = 0.5;
  constexpr int first = 8, last = 23;
  const Lattice lattice({48, 44});
  const std::vector<double> load = uniform(48);
  const auto sampler = make_sampler(heavy(mu, g), lattice), light = make_sampler(heavy(mu, 0), lattice);
  test::NaiveGranusolve law(lattice, mu, 5, g);
  Pile pile(lattice), naive(lattice);
  test::RunningMean found[2], expected[2], without[2];
  // Thrust ratio, and variance of weights over the square of their mean.
  const auto add = [](test::RunningMean* means, const Pile& of) {
    double ratio = 0, variance = 0;
    for (int layer = first; layer <= last; ++layer) {
      const auto [weight, thrust] = weight_and_thrust(of, layer);
      ratio += thrust / weight / (last - first + 1);
      for (int i = 0; i < 48; ++i) {
        const std::size_t at = of.lattice.index(layer, i);
        variance += std::pow((of.V_R[at] + of.V_L[at]) / weight - 1, 2) / (48 * (last - first + 1));
      }
    }
    means[0].add(ratio);
    means[1].add(variance);
  };
  for (std::uint64_t sample = 0; sample < 400; ++sample) {
    REQUIRE_FALSE(sampler->draw(sample, load, pile));
    add(found, pile);
    REQUIRE_FALSE(light->draw(sample, load, pile));
    add(without, pile);
    REQUIRE(law.draw(load, naive));
    REQUIRE(audit(naive).max_balance_residual < 1e-12);
    add(expected, naive);
  }
  for (int k = 0; k < 2; ++k) {
    CAPTURE(k, found[k].estimate().value, expected[k].estimate().value, found[k].estimate().error);
    CHECK(std::abs(test::sigmas(found[k].estimate(), expected[k].estimate())) < test::sigma_bound(2));
    CHECK(std::abs(test::sigmas(found[k].estimate(), without[k].estimate())) > 10);
  }
}

TEST_CASE("A weight that is none is refused, and models without beads have none") {
  const Lattice lattice({8, 8});
  const auto key_of = [&](const SamplerSpec& spec) {
    CHECK_THROWS_AS(make_sampler(spec, lattice), InputError);
    return find_problem(spec)->key;
  };
  for (const double g : {-0.1, std::nan(""), 1001.0}) CHECK(key_of(heavy(0.3, g)) == "bead_weight");
  SamplerSpec model = heavy(0, 0.1);
  model.model.name = ModelName::three_leg;
  CHECK(key_of(model) == "bead_weight");
  CHECK_NOTHROW(make_sampler(heavy(0.3, 1000), lattice));
}

}  // namespace granuscope
