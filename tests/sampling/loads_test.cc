// Loads: beads with weight, lines of loads, and extreme loads, sizes and friction.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "kit/instruction_sets.h"
#include "kit/naive_granusolve.h"
#include "kit/naive_rejection.h"
#include "kit/pile_of_group.h"
#include "kit/sampling_statistics.h"
#include "model/audit.h"
#include "model/lattice.h"
#include "sampling/sampler.h"
#include "support/error.h"

namespace granuscope {

// Beads that have a weight of their own, under every law. Source of the expected numbers: the balances, and the laws
// "rejection" and "granusolve" a second time (tests/kit).

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

TEST_CASE("The weight of beads goes down whole, under every law, and the audit finds every balance", "[unsanitized]") {
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
          const Pile other = test::pile_of(group, k), &one = expected[group.first_sample + k];
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

TEST_CASE("The law granusolve with heavy beads is that of a second implementation, and differs from light ones",
          "[unsanitized]") {
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

// Loads that lean or act beside the centres of the top beads, under every law.

namespace {

struct Sums {
  double weight = 0, horizontal = 0, torque = 0;  ///< T_R + T_L
};

Sums sums_of(const Pile& pile, int layer) {
  Sums sums;
  for (int i = 0; i < pile.lattice.columns(); ++i) {
    const std::size_t at = pile.lattice.index(layer, i);
    const double H = pile.H_R[at] + pile.H_L[at];
    sums.weight += pile.V_R[at] + pile.V_L[at];
    sums.horizontal += H;
    sums.torque += (std::sqrt(3) * H - pile.V_R[at] + pile.V_L[at]) / 2;
  }
  return sums;
}

SamplerSpec loaded(double mu, double angle, double offset, Law law = Law::granusolve) {
  SamplerSpec spec;
  spec.law = law;
  spec.mu = mu;
  spec.load_angle = angle;
  spec.load_offset = offset;
  return spec;
}

Pile drawn_under(const SamplerSpec& spec, LatticeSpec size) {
  CAPTURE(name_of(spec.law), spec.mu, spec.load_angle, spec.load_offset);
  Pile pile{Lattice(size)};
  const std::vector<double> load(static_cast<std::size_t>(size.columns), 1.0);
  REQUIRE_FALSE(make_sampler(spec, pile.lattice)->draw(3, load, pile));
  return pile;
}

double thrust(const Pile& pile) {
  double sum = 0;
  for (std::size_t at = 0; at < pile.lattice.beads(); ++at) sum += pile.H_R[at] - pile.H_L[at];
  return std::sqrt(3) * sum / static_cast<double>(pile.lattice.beads());
}

}  // namespace

TEST_CASE("Weight, horizontal force and alternating torque are handed down whole, under every law", "[unsanitized]") {
  struct Case {
    Law law;
    LatticeSpec size;
    double mu;
  };
  for (const auto& [law, size, mu] : {Case{Law::granusolve, {48, 40}, 0.3}, Case{Law::granusolve, {48, 40}, 0.8},
                                      Case{Law::eloy_clement, {4, 4}, 0.5}, Case{Law::rejection, {5, 5}, 0.5},
                                      Case{Law::polytope, {6, 6}, 0.5}, Case{Law::granusolve, {16, 12}, 0}}) {
    for (const double angle : {0.0, 4.0, -4.0}) {
      for (const double offset : {0.0, 0.03, -0.03}) {
        if (mu == 0 && offset != 0) continue;
        const Pile pile = drawn_under(loaded(mu, angle, offset, law), size);
        CAPTURE(name_of(law), mu, angle, offset);
        const AuditResult result = audit(pile);
        CHECK(result.max_balance_residual < 1e-12);
        CHECK(result.max_cone_violation < 1e-12);
        CHECK_NOTHROW(assert_identities(pile));
        const double slope = std::tan(angle * std::acos(-1) / 180);
        for (int layer = 0; layer < size.layers; ++layer) {
          const Sums sums = sums_of(pile, layer);
          CHECK(sums.weight == Approx(size.columns));
          CHECK(sums.horizontal == Approx(slope * size.columns).margin(1e-10));
          // The load's own contacts turn the other way.
          const double sign = layer % 2 == 0 ? -1 : 1;
          CHECK(sums.torque == Approx(sign * offset * size.columns).margin(1e-10));
        }
      }
    }
  }
}

TEST_CASE(
    "Where the excess of a load leans alone, the rest of the pile is upright, and torque alternates with it alone") {
  for (const Law law : {Law::granusolve, Law::polytope, Law::eloy_clement}) {
    SamplerSpec spec = loaded(0.5, 8, 0.4, law);
    spec.lean_excess = true;
    Pile pile{Lattice({6, 6})};
    const std::vector<double> load{1, 1.25, 1, 1, 0.9, 1};
    REQUIRE_FALSE(make_sampler(spec, pile.lattice)->draw(3, load, pile));
    CAPTURE(name_of(law));
    CHECK(audit(pile).max_balance_residual < 1e-12);
    CHECK_NOTHROW(assert_identities(pile));
    for (int layer = 0; layer < 6; ++layer) {
      const Sums sums = sums_of(pile, layer);
      CHECK(sums.horizontal == Approx(std::tan(8 * std::acos(-1) / 180) * 0.15).margin(1e-10));
      CHECK(sums.torque == Approx((layer % 2 == 0 ? -1 : 1) * 0.4 * 0.15).margin(1e-10));
    }
    // Torque and slope of one bead, by hand: V_R - V_L = 2 sqrt(3) H - (V_UL - V_UR).
    const double H = std::tan(8 * std::acos(-1) / 180) * 0.25;
    CHECK(pile.V_R[1] - pile.V_L[1] == Approx(std::sqrt(3) * H + 2 * 0.4 * 0.25));
    CHECK(pile.V_R[0] == pile.V_L[0]);
  }
}

TEST_CASE("Piles drawn side by side bear a leaning load as those drawn alone, bit by bit") {
  const bool of_excess = GENERATE(false, true);
  SamplerSpec spec = loaded(0.4, 6, -0.07);
  spec.lean_excess = of_excess;
  const Lattice lattice({40, 64});
  const auto together = make_sampler(spec, lattice);
  std::vector<double> load(40, 1.0);
  for (std::size_t i = 0; of_excess && i < load.size(); i += 3) load[i] += i % 2 == 0 ? 0.2 : -0.3;
  const std::vector<std::uint64_t> samples{0, 1, 2, 3, 4, 5, 6, 7};
  const std::vector<std::span<const double>> loads(samples.size(), load);
  std::vector<std::optional<SamplingFailure>> failures(samples.size());
  const auto alone = make_sampler(spec, lattice);
  Pile one(lattice);
  for (const PileGroup& group : together->draw_groups(samples, loads, failures)) {
    for (std::size_t k = 0; k < group.piles; ++k) {
      REQUIRE_FALSE(alone->draw(group.first_sample + k, load, one));
      const Pile other = test::pile_of(group, k);
      CHECK(other.V_R == one.V_R);
      CHECK(other.V_L == one.V_L);
      CHECK(other.H_R == one.H_R);
      CHECK(other.H_L == one.H_L);
      CHECK(other.load_line == one.load_line);
      CHECK(audit(other).max_balance_residual < 1e-12);
    }
  }
}

TEST_CASE("Torque lowers the thrust, a horizontal force raises it, whichever way they point") {
  const LatticeSpec size{256, 200};
  const auto at = [&](double angle, double offset) { return thrust(drawn_under(loaded(0.3, angle, offset), size)); };
  const double upright = at(0, 0);
  for (const double side : {1.0, -1.0}) {
    CHECK(at(10 * side, 0) > upright + 0.005);
    CHECK(at(0, 0.12 * side) < upright - 0.03);
  }
}

TEST_CASE("A load that friction cannot bear is refused") {
  const Lattice lattice({8, 8});
  const auto refused = [&](const SamplerSpec& spec) { CHECK_THROWS_AS(make_sampler(spec, lattice), InputError); };
  refused(loaded(0.3, 30, 0));
  refused(loaded(0.3, std::nan(""), 0));
  refused(loaded(0.3, 0, std::nan("")));
  refused(loaded(0, 0, 0.01));
  // Both contacts may bear 2/sqrt(3) mu of torque, but not with the vertical forces that go with it.
  refused(loaded(0.3, 0, 0.33));
  // A top bead would bear this one, on the side to which the load leans; the second layer has its torque turned.
  for (const double side : {1.0, -1.0}) refused(loaded(0.3, 29, 0.16 * side));
  CHECK_NOTHROW(make_sampler(loaded(0.3, -29.9, 0), lattice));
  CHECK(find_problem(loaded(0.3, 0, 0.33))->message.find("up to 0.3176 to either side") != std::string::npos);
}

TEST_CASE("Slope and torque together are accepted up to where a mean bead slides or is pulled, and can be drawn",
          "[unsanitized]") {
  for (const double mu : {0.1, 0.3, 0.8}) {
    const double pi = std::acos(-1), t_plus = std::tan(pi / 6 + std::atan(mu)),
                 t_minus = std::tan(pi / 6 - std::atan(mu));
    for (const double angle : {0.0, 8.0, -20.0, 29.0}) {
      const double slope = std::abs(std::tan(angle * pi / 180));
      // Of the mean bead, V_R + V_L = 1 and V_R - V_L = sqrt(3) slope +- 2 offset: neither force pulls, and both fit
      // into their cones with H_R + H_L = slope.
      const double largest =
          std::min(1 - std::sqrt(3) * slope,
                   ((t_plus - t_minus) - slope * (std::sqrt(3) * (t_plus + t_minus) - 2)) / (t_plus + t_minus)) /
          2;
      for (const double side : {1.0, -1.0}) {
        CAPTURE(mu, angle, side, largest);
        CHECK(find_problem(loaded(mu, angle, 1.00001 * side * largest)));
        CHECK_FALSE(find_problem(loaded(mu, angle, 0.99999 * side * largest)));
        for (const Law law : {Law::granusolve, Law::polytope}) {
          const AuditResult result = audit(drawn_under(loaded(mu, angle, 0.98 * side * largest, law), {4, 4}));
          CHECK(result.max_balance_residual < 1e-12);
          CHECK(result.max_cone_violation < 1e-12);
        }
      }
    }
  }
}

namespace {

// Sources: balances and cones hold whatever the size, the friction or the load. Residuals are those of an audit in
// another form than the sampler's, relative to the largest force of the layer.

/// The largest residual of a pile that counts as solved, relative to the largest force of its layer.
constexpr double stability_tolerance = 1e-10;

enum class Outcome { solved, stuck, refused };

struct Trial {
  Outcome outcome = Outcome::solved;
  double worst = 0;  ///< residual of balance or cone
  int stuck_layer = 0;
  double rounded_per_bead = 0;
  double early = 0, late = 0;  ///< residuals of the second and of the last tenth of the layers
};

Trial attempt(LatticeSpec size, double mu, const std::vector<double>& load, std::uint64_t seed,
              Law law = Law::granusolve) {
  const Lattice lattice(size);
  SamplerSpec spec;
  spec.mu = mu;
  spec.seed = seed;
  spec.law = law;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice);
  Trial trial;
  try {
    if (const auto failure = sampler->draw(0, load, pile)) {
      trial.outcome = Outcome::stuck;
      trial.stuck_layer = failure->layer;
      return trial;
    }
  } catch (const InputError&) {
    trial.outcome = Outcome::refused;
    return trial;
  }
  // Refuses whatever is not finite.
  const AuditResult result = audit(pile);
  trial.worst = std::max(result.max_balance_residual, result.max_cone_violation);
  const std::vector<LayerResidual> layers = audit_layers(pile);
  const std::size_t tenth = layers.size() / 10;
  for (std::size_t n = 0; n < tenth; ++n) {
    const LayerResidual &second = layers[tenth + n], &last = layers[layers.size() - 1 - n];
    trial.early = std::max({trial.early, second.balance, second.cone});
    trial.late = std::max({trial.late, last.balance, last.cone});
  }
  trial.rounded_per_bead =
      static_cast<double>(sampler->counts().rounded) / static_cast<double>(sampler->counts().beads);
  return trial;
}

std::vector<double> even(int columns) { return std::vector<double>(static_cast<std::size_t>(columns), 1.0); }

std::vector<double> overloaded(int columns) {
  std::vector<double> load = even(columns);
  load[load.size() / 2] = 2;
  return load;
}

std::vector<double> half_unloaded(int columns) {
  std::vector<double> load = even(columns);
  std::fill(load.begin(), load.begin() + columns / 2, 0.0);
  return load;
}

/// Ten orders of magnitude side by side, in random order.
std::vector<double> ten_orders(int columns, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> power(-5, 5);
  std::vector<double> load;
  for (int i = 0; i < columns; ++i) load.push_back(std::pow(10.0, power(engine)));
  load.front() = 1e5, load[1] = 1e-5;
  return load;
}

std::vector<double> extreme_friction() {
  return {1e-9, 1e-3, std::nextafter(tan30, 0.0), tan30, std::nextafter(tan30, 1.0), 1.7, 1.73};
}

void survive(int columns, int layers, int seeds) {
  for (const double mu : extreme_friction()) {
    for (const auto& load : {even(columns), overloaded(columns)}) {
      for (int seed = 1; seed <= seeds; ++seed) {
        const Trial trial = attempt({columns, layers}, mu, load, static_cast<std::uint64_t>(seed));
        INFO(columns << " x " << layers << ", mu " << mu << ", seed " << seed << ", residual " << trial.worst);
        CHECK(trial.outcome == Outcome::solved);
        CHECK(trial.worst <= stability_tolerance);
      }
    }
  }
}

TEST_CASE("extreme friction on four columns and on wide piles") {
  survive(4, 200, 3);
  survive(64, 50, 1);
}

TEST_CASE("extreme friction on four columns and on wide piles, many seeds", "[long]") {
  survive(4, 10'000, 3);
  survive(500, 100, 3);
}

TEST_CASE("100 000 layers of 64 columns are solved, and residuals do not grow with depth", "[long]") {
  for (const double mu : extreme_friction()) {
    const Trial deep = attempt({64, 100'000}, mu, overloaded(64), 1);
    INFO("mu " << mu << ", worst " << deep.worst << ", early " << deep.early << ", late " << deep.late << ", rounded "
               << deep.rounded_per_bead);
    CHECK(deep.outcome == Outcome::solved);
    CHECK(deep.worst <= stability_tolerance);
    // The largest of as many layers each time: a sum of rounding would be some nine times as large at the end, or three
    // if its signs were random.
    CHECK(deep.early > 0);
    CHECK(deep.late < 2 * deep.early);
    // A last resort against rounding, not a rule of the law.
    CHECK(deep.rounded_per_bead < 1e-4);
  }
}

// At t- = 0 the empty half can be entered along single rays of solutions only, which no draw meets: on many columns the
// effort runs out, by name.
TEST_CASE("half the top unloaded is refused below 30 degrees of friction angle and solved above, under every law") {
  auto friction = extreme_friction();
  friction.insert(friction.end(), {0.58, 0.7, 1.0});
  for (const double mu : friction) {
    const FrictionCone cone(mu);
    for (const int columns : {4, 40}) {
      const Trial trial = attempt({columns, 60}, mu, half_unloaded(columns), 1);
      CAPTURE(mu, columns, cone.t_minus(), trial.worst, trial.stuck_layer);
      CHECK(trial.worst <= stability_tolerance);
      if (trial.outcome == Outcome::stuck) {
        CHECK(std::abs(cone.t_minus()) < 1e-12);
      } else {
        CHECK(trial.outcome == (cone.t_minus() > 0 ? Outcome::refused : Outcome::solved));
        // Next to t- = 0 the cone's edge is as narrow as rounding, and what rounding decides is counted.
        if (columns > 4 && cone.t_minus() > -1e-12 && cone.t_minus() < 0) CHECK(trial.rounded_per_bead > 0);
      }
    }
  }
  for (const Law law : {Law::eloy_clement, Law::rejection, Law::polytope}) {
    for (const double mu : {0.3, 0.7}) {
      const Trial trial = attempt({5, 2}, mu, {1, 0, 0, 1, 1}, 1, law);
      CAPTURE(name_of(law), mu, trial.worst);
      CHECK(trial.outcome == (mu < tan30 ? Outcome::refused : Outcome::solved));
      CHECK(trial.worst <= stability_tolerance);
    }
    CHECK(attempt({5, 2}, 0.7, {0, 0, 0, 0, 0}, 1, law).outcome == Outcome::refused);
  }
}

TEST_CASE("a contact that is pulled is no solution, however small the friction is against rounding", "[unsanitized]") {
  int solved = 0;
  for (const double mu : {1e-9, 1e-7}) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      const Trial trial = attempt({64, 60}, mu, ten_orders(64, seed), seed);
      CAPTURE(mu, seed, trial.worst);
      CHECK(trial.worst <= stability_tolerance);
      solved += trial.outcome == Outcome::solved ? 1 : 0;
    }
  }
  CHECK(solved >= 1);
}

TEST_CASE("loads over ten orders of magnitude side by side: a pile with small residuals, or a failure by name") {
  int solved = 0, steep = 0;
  for (const double mu : extreme_friction()) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const Trial trial = attempt({24, 30}, mu, ten_orders(24, seed), seed);
      CAPTURE(mu, seed, trial.worst, trial.stuck_layer);
      CHECK(trial.outcome != Outcome::refused);
      CHECK(trial.worst <= stability_tolerance);
      solved += trial.outcome == Outcome::solved ? 1 : 0;
      if (mu > 1) {
        ++steep;
        CHECK(trial.outcome == Outcome::solved);
      }
    }
  }
  CAPTURE(solved);
  CHECK(solved >= steep);
  CHECK(steep == 6);
}

}  // namespace

}  // namespace granuscope
