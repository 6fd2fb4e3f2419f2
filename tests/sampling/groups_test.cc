// Piles drawn side by side in one vector: the same ones, and the same bytes, as one by one.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "kit/instruction_sets.h"
#include "kit/pile_of_group.h"
#include "kit/same_bytes.h"
#include "kit/sanitized.h"
#include "model/audit.h"
#include "sampling/pile_group.h"
#include "sampling/sampler.h"
#include "support/error.h"

namespace granuscope {
namespace {

using test::same_bytes;

// Source: piles drawn side by side are those drawn one by one; equality is exact.

void check_same_counts(const SamplerCounts& a, const SamplerCounts& b) {
  CHECK(a.beads == b.beads);
  CHECK(a.uniforms == b.uniforms);
  CHECK(a.tries == b.tries);
  CHECK(a.repaired_by_pair == b.repaired_by_pair);
  CHECK(a.repaired_by_arc == b.repaired_by_arc);
  CHECK(a.repaired_by_ring == b.repaired_by_ring);
  CHECK(a.backtracked == b.backtracked);
  CHECK(a.pairs == b.pairs);
  CHECK(a.arcs == b.arcs);
  CHECK(a.rings == b.rings);
  CHECK(a.backtracks == b.backtracks);
  CHECK(a.rounded == b.rounded);
}

struct Done {
  SamplerCounts counts;
  int failures = 0;
};

/// Draws `count` samples from `first` on side by side and one by one, each under its own load; gives what was done.
Done check_group(const SamplerSpec& spec, LatticeSpec lattice_spec, std::uint64_t first, std::size_t count,
                 const std::vector<std::vector<double>>& loads) {
  const Lattice lattice(lattice_spec);
  const auto together = make_sampler(spec, lattice), single = make_sampler(spec, lattice);
  std::vector<std::span<const double>> views(loads.begin(), loads.begin() + static_cast<std::ptrdiff_t>(count));
  std::vector<std::optional<SamplingFailure>> failures(count);
  std::vector<std::uint64_t> samples(count);
  std::iota(samples.begin(), samples.end(), first);
  std::vector<Pile> piles;
  for (const PileGroup& group : together->draw_groups(samples, views, failures)) {
    CHECK(group.first_sample == first + piles.size());
    for (std::size_t k = 0; k < group.piles; ++k) {
      piles.push_back(test::pile_of(group, k));
    }
  }
  REQUIRE(piles.size() == count);
  Done done;
  for (std::size_t k = 0; k < count; ++k) {
    Pile pile(lattice);
    const auto failure = single->draw(first + k, loads[k], pile);
    CAPTURE(k, first);
    REQUIRE(failure.has_value() == failures[k].has_value());
    if (failure) {
      ++done.failures;
      CHECK(failure->layer == failures[k]->layer);
    } else {
      CHECK(same_bytes(pile, piles[k]));
      CHECK(test::same_key(pile, piles[k]));
    }
  }
  check_same_counts(together->counts(), single->counts());
  done.counts = single->counts();
  return done;
}

std::vector<std::vector<double>> even_loads(int columns) {
  return std::vector<std::vector<double>>(8, std::vector<double>(static_cast<std::size_t>(columns), 1.0));
}

constexpr double inverse_sqrt3 = 0.57735026918962576451;

TEST_CASE("piles drawn side by side are those drawn one by one, at every friction, width and number of piles") {
  for_each_instruction_set([] {
    for (const double mu : {0.0, 1e-9, 1e-3, 0.1, 0.3, std::nextafter(inverse_sqrt3, 0.0), inverse_sqrt3,
                            std::nextafter(inverse_sqrt3, 1.0), 0.8, 1.3, 1.7, 1.73}) {
      // The arrays are those of a width: under the sanitizers each has a small, a middling and a large friction.
      if (test::sanitized && mu != 1e-9 && mu != 0.3 && mu != 1.7) continue;
      for (const int columns : {4, 5, 63, 64, 65, 130}) {
        CAPTURE(mu, columns);
        SamplerSpec spec;
        spec.mu = mu;
        spec.seed = 99;
        auto loads = even_loads(columns);
        loads[1][1] += 1;  // a load of its own for some piles
        loads[5][2] += 0.25;
        for (const std::size_t count : {1U, 3U, 8U}) check_group(spec, {columns, 40}, 16, count, loads);
        check_group(spec, {columns, 20}, 13, 7, loads);  // across the border of two groups
      }
    }
  });
}

TEST_CASE("piles drawn side by side are those drawn one by one, with contacts at any angle, and pass the audit") {
  for_each_instruction_set([] {
    for (const double angle : {20.0, 45.0, 60.0}) {
      const BeadGeometry geometry(angle);
      for (const double share : {0.1, 0.3, 0.6, 0.99}) {  // of the largest friction
        CAPTURE(angle, share);
        SamplerSpec spec;
        spec.mu = share * geometry.cotangent;
        spec.seed = 7;
        auto loads = even_loads(65);
        loads[1][1] += 1;
        check_group(spec, {65, 40, angle}, 8, 8, loads);
      }
    }
  });
  // Balances and cones by N and T, from forces that were drawn by V and H.
  for (const Law law : {Law::granusolve, Law::eloy_clement, Law::rejection, Law::polytope}) {
    for (const double angle : {20.0, 45.0, 60.0}) {
      SamplerSpec spec;
      spec.law = law;
      spec.mu = 0.3;
      spec.effort = 1e5;  // of which the law eloy-clement needs many
      const bool large = law == Law::granusolve;
      const Lattice lattice({large ? 100 : 6, large ? 200 : 4, angle});
      Pile pile(lattice);
      const std::vector<double> load(static_cast<std::size_t>(lattice.columns()), 1.0);
      CAPTURE(name_of(law), angle);
      REQUIRE_FALSE(make_sampler(spec, lattice)->draw(3, load, pile).has_value());
      const AuditResult found = audit(pile);
      CHECK(found.max_balance_residual < 1e-12);
      CHECK(found.max_cone_violation < 1e-12);
      CHECK_NOTHROW(assert_identities(pile));
    }
  }
}

TEST_CASE("piles drawn side by side are those drawn one by one in a fixed order and where the effort runs out") {
  SamplerSpec spec;
  spec.mu = 0.3;
  spec.order = LayerOrder::fixed;
  check_group(spec, {50, 60}, 0, 8, even_loads(50));
  spec.order = LayerOrder::random;
  // Some of the eight run out of an effort that is about the average one.
  int with_some = 0;
  for (const double effort : {1.0, 1.23, 1.25, 1.27, 1.3, 1.4}) {
    spec.effort = effort;
    const int failures = check_group(spec, {50, 60}, 8, 8, even_loads(50)).failures;
    if (failures > 0 && failures < 8) ++with_some;
  }
  CHECK(with_some >= 2);
  // A heavy bead beside light ones: backtracks, one of which leaves the window of layers that a group holds, rings, and
  // a failure by name.
  spec.effort = 20;
  auto loads = even_loads(50);
  for (std::size_t k = 0; k < 8; k += 2) loads[k][25] = std::pow(10.0, static_cast<double>(k));
  check_group(spec, {50, 60}, 24, 8, loads);
}

TEST_CASE("piles side by side are those drawn one by one where nearly all that holds a bead is rounding") {
  // Friction of a few ulps and loads over several orders of magnitude: intervals that rounding has emptied are met by
  // failing beads in one pile of twenty here.
  std::mt19937_64 generator(11);
  std::uniform_real_distribution<double> uniform;
  std::uint64_t rounded = 0;
  for (int trial = 0; trial < 100; ++trial) {
    SamplerSpec spec;
    spec.mu = std::pow(10.0, -16 + 3.5 * uniform(generator));
    spec.seed = generator();
    spec.effort = 20;
    const int columns = 8 + static_cast<int>(32 * uniform(generator));
    const int layers = 15 + static_cast<int>(40 * uniform(generator));
    const double orders = 3 + 2 * uniform(generator);
    auto loads = even_loads(columns);
    for (auto& load : loads) {
      for (double& force : load) force = std::pow(10.0, orders * uniform(generator));
    }
    CAPTURE(spec.mu, spec.seed, columns, layers);
    rounded += check_group(spec, {columns, layers}, 8, 8, loads).counts.rounded;
  }
  CHECK(rounded > 10'000);  // it is rounding that is tested
}

/// Every kept layer of a group against the piles themselves.
void check_kept(const PileGroup& group, std::span<const Pile> piles, const std::vector<int>& layers) {
  REQUIRE(group.piles == piles.size());
  for (std::size_t k = 0; k < group.piles; ++k) {
    const Pile& pile = piles[k];
    CAPTURE(k, pile.sample);
    // Rounding apart: groups check the horizontal force as a whole.
    CHECK(group.residuals[k].wave_equation == Approx(identity_residuals(pile).wave_equation).margin(1e-15));
    for (const int layer : layers) {
      double thrust = 0, variance = 0;
      for (std::size_t i = 0; i < static_cast<std::size_t>(pile.lattice.columns()); ++i) {
        const std::size_t bead = pile.lattice.index(layer, 0) + i;
        const double w = pile.V_R[bead] + pile.V_L[bead];
        const std::size_t entry = group.row(layer) + group.stride * i + k;
        CHECK(group.weight(entry) == w);
        if (group.V_R != nullptr || group.horizontal != nullptr) {
          CHECK(group.H(entry) == pile.H_R[bead] + pile.H_L[bead]);
        }
        thrust += pile.H_R[bead] - pile.H_L[bead];
        variance += (w - 1) * (w - 1);
      }
      CHECK(group.moments_of(layer).thrust[k] == thrust);
      CHECK(group.moments_of(layer).variance[k] == variance);
    }
  }
}

TEST_CASE("what groups keep of a layer is what its piles say, of those drawn anew by themselves, too") {
  const Lattice lattice({50, 60});
  SamplerSpec spec;
  spec.mu = 0.3;
  spec.effort = 1000;
  std::vector<std::vector<double>> loads(19, std::vector<double>(50, 1.0));
  loads[3][25] = 1e3;  // a backtrack of its pile leaves the window of layers that a group holds
  const std::vector<std::span<const double>> views(loads.begin(), loads.end());
  std::vector<std::uint64_t> samples(19);  // two whole groups and a part of one
  std::iota(samples.begin(), samples.end(), std::uint64_t{24});
  const auto single = make_sampler(spec, lattice);
  std::vector<Pile> piles;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    REQUIRE_FALSE(single->draw(samples[k], loads[k], piles.emplace_back(lattice)));
    // A backtrack of 29 layers takes 27 backtracks of one bead before it.
    if (k == 3) CHECK(single->counts().backtracks > 10 * 27);
  }
  for_each_instruction_set([&] {
    const auto sampler = make_sampler(spec, lattice);
    std::vector<std::optional<SamplingFailure>> failures(samples.size());
    const auto check_all = [&](const std::vector<int>& layers, bool forces) {
      const auto groups = sampler->draw_groups(samples, views, failures);
      REQUIRE(groups.size() == 3);
      std::size_t first = 0;
      for (const PileGroup& group : groups) {
        CHECK((group.V_R != nullptr) == forces);
        check_kept(group, std::span(piles).subspan(first, group.piles), layers);
        first += group.piles;
      }
      CHECK(std::none_of(failures.begin(), failures.end(), [](const auto& failure) { return failure.has_value(); }));
    };
    std::vector<int> all(60);
    std::iota(all.begin(), all.end(), 0);
    check_all(all, true);
    for (const std::vector<int>& layers : {std::vector<int>{0, 7, 31, 32, 59}, {58}, {1, 2, 3}}) {
      for (const bool horizontal : {false, true}) {
        sampler->keep_layers({layers, horizontal});
        check_all(layers, false);
      }
    }
  });
}

TEST_CASE("groups are not asked for what they have not kept, nor to keep what there is not") {
  const Lattice lattice({8, 12});
  SamplerSpec spec;
  spec.mu = 0.2;
  const auto sampler = make_sampler(spec, lattice);
  for (const std::vector<int>& layers : {std::vector<int>{}, {3, 2}, {3, 3}, {-1}, {12}}) {
    CHECK_THROWS_AS(sampler->keep_layers({layers}), std::logic_error);
  }
  sampler->keep_layers({{2, 5}});
  const std::vector<double> load(8, 1.0);
  const std::vector<std::span<const double>> loads(8, load);
  const std::vector<std::uint64_t> samples = {0, 1, 2, 3, 4, 5, 6, 7};
  std::vector<std::optional<SamplingFailure>> failures(8);
  const PileGroup group = sampler->draw_groups(samples, loads, failures).front();
  CHECK_NOTHROW(group.moments_of(5));
  CHECK_THROWS_AS(group.row(4), std::logic_error);
  CHECK_THROWS_AS(group.moments_of(4), std::logic_error);
  CHECK_THROWS_AS(identity_residuals(group), std::logic_error);
}

TEST_CASE("a group of the paper's size is the same piles", "[long]") {
  for (const double mu : {0.05, 0.1, 0.3, 0.6, 1.0, 1.5, 1.72}) {
    CAPTURE(mu);
    SamplerSpec spec;
    spec.mu = mu;
    auto loads = even_loads(500);
    for (auto& load : loads) load[250] += 1;
    for (std::uint64_t first = 0; first < 32; first += 8) check_group(spec, {500, 200}, first, 8, loads);
  }
}

// Source: the identities of model/audit.h, broken by hand in one pile of a group at a time.

/// Piles side by side whose forces may be changed.
class Forces {
 public:
  explicit Forces(const PileGroup& group)
      : group_(group), loads_(group.loads.begin(), group.loads.end()), size_(group.lattice.beads() * group.stride) {
    for (const double* from : {group.V_R, group.V_L, group.H_R, group.H_L}) arrays_.emplace_back(from, from + size_);
  }
  std::size_t at(int layer, int bead, std::size_t pile) const {
    return group_.lattice.index(layer, bead) * group_.stride + pile;
  }
  std::vector<double>& of(std::size_t array) { return arrays_[array]; }
  /// Of all layers, handed over `together` at a time; with the forces that enter beads instead of H_L or without.
  std::array<IdentityResiduals, group_lanes> residuals(bool totals) const {
    std::vector<double> H(size_);
    for (std::size_t i = 0; i < size_; ++i) H[i] = arrays_[2][i] + arrays_[3][i];
    GroupIdentities identities;
    identities.begin(group_.lattice, group_.stride, loads_, group_.bead_weight);
    const auto row = [&](int layer) {
      const std::size_t from = at(std::max(layer, 0), 0, 0);
      return ForceRow{&arrays_[0][from], &arrays_[1][from], &arrays_[2][from], totals ? &H[from] : &arrays_[3][from],
                      totals};
    };
    for (int layer = 0; layer < group_.lattice.layers(); ++layer) {
      identities.add_layer(row(layer), row(layer - 1), row(layer - 2));
    }
    return identities.residuals();
  }

 private:
  PileGroup group_;
  std::vector<std::span<const double>> loads_;
  std::size_t size_;
  std::vector<std::vector<double>> arrays_;
};

/// Eight piles side by side, and one by itself.
struct Drawn {
  explicit Drawn(int columns) : load(static_cast<std::size_t>(columns), 1.0), loads(8, load) {
    const Lattice lattice({columns, 20});
    SamplerSpec spec;
    spec.mu = 0.4;
    const std::vector<std::uint64_t> samples = {0, 1, 2, 3, 4, 5, 6, 7};
    for (const std::size_t count : {8U, 1U}) {
      samplers.push_back(make_sampler(spec, lattice));
      groups.push_back(samplers.back()
                           ->draw_groups(std::span(samples).first(count), std::span(loads).first(count),
                                         std::span(failures).first(count))
                           .front());
    }
  }
  std::vector<double> load;
  std::vector<std::span<const double>> loads;
  std::vector<std::optional<SamplingFailure>> failures = std::vector<std::optional<SamplingFailure>>(8);
  std::vector<std::unique_ptr<Sampler>> samplers;
  std::vector<PileGroup> groups;
};

TEST_CASE("a broken pile is seen wherever it stands in a group, and the others are not blamed") {
  for_each_instruction_set([] {
    for (const int columns : {4, 9, 64}) {
      const Drawn drawn(columns);
      for (const PileGroup& group : drawn.groups) {
        for (const bool totals : {false, true}) {
          if (totals && group.stride == 1) continue;  // single piles know H_L
          CAPTURE(columns, group.stride, totals);
          for (const IdentityResiduals& whole : Forces(group).residuals(totals)) {
            CHECK(whole.weight_sum < 1e-14);
            CHECK(whole.wave_equation < 1e-14);
          }
          for (std::size_t pile = 0; pile < group.piles; ++pile) {
            for (const int layer : {0, 1, 2, 11, 19}) {
              const int bead = layer % columns, next = (layer + 1) % columns;
              CAPTURE(pile, layer);
              const auto expect_only = [&](const Forces& forces, auto broken) {
                const auto found = forces.residuals(totals);
                for (std::size_t k = 0; k < group.piles; ++k) CHECK(broken(found[k]) == (k == pile));
              };
              Forces heavier(group);
              heavier.of(0)[heavier.at(layer, bead, pile)] += 1e-9;
              expect_only(heavier, [](const IdentityResiduals& r) { return r.weight_sum > 1e-11; });
              // Weight that moves to a neighbour leaves the sum as it is; the layers below see it.
              Forces moved(group);
              moved.of(1)[moved.at(layer, bead, pile)] += 1e-6;
              moved.of(1)[moved.at(layer, next, pile)] -= 1e-6;
              if (layer > 1) expect_only(moved, [](const IdentityResiduals& r) { return r.wave_equation > 1e-8; });
              for (const std::size_t array : {0U, 1U, 2U}) {
                for (const double bad :
                     {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
                  Forces ruined(group);
                  ruined.of(array)[ruined.at(layer, bead, pile)] = bad;
                  expect_only(ruined, [](const IdentityResiduals& r) {
                    return !(std::isfinite(r.weight_sum) && std::isfinite(r.wave_equation));
                  });
                }
              }
            }
          }
        }
      }
    }
  });
}

TEST_CASE("a group with a broken pile is refused, unless that pile has failed anyway") {
  Drawn drawn(8);
  PileGroup& group = drawn.groups.front();
  std::vector<IdentityResiduals> residuals(8);
  group.residuals = residuals;
  CHECK_NOTHROW(assert_identities(group, drawn.failures));
  for (const bool sum : {false, true}) {
    for (std::size_t k = 0; k < 8; ++k) {
      residuals.assign(8, {});
      (sum ? residuals[k].weight_sum : residuals[k].wave_equation) = 1e-9;
      CHECK_THROWS_AS(assert_identities(group, drawn.failures), std::logic_error);
      drawn.failures[k] = SamplingFailure{3};
      CHECK_NOTHROW(assert_identities(group, drawn.failures));
      drawn.failures[k].reset();
    }
  }
  // Found where they were not yet.
  group.residuals = {};
  CHECK_NOTHROW(assert_identities(group, drawn.failures));
  std::vector<double> V_R(group.V_R, group.V_R + group.lattice.beads() * group_lanes);
  V_R[group.row(7) + 5] *= 1 + 1e-8;
  group.V_R = V_R.data();
  CHECK_THROWS_AS(assert_identities(group, drawn.failures), std::logic_error);
}

// Source: a pile is a pure function of its key, and the law has no unit of force; equality is exact.

SamplerSpec spec_of(double mu, Law law = Law::granusolve) {
  SamplerSpec spec;
  spec.mu = mu;
  spec.law = law;
  spec.seed = 42;
  return spec;
}

Pile drawn(Sampler& sampler, const Lattice& lattice, std::uint64_t sample, const std::vector<double>& load) {
  Pile pile(lattice);
  const auto failure = sampler.draw(sample, load, pile);
  REQUIRE_FALSE(failure.has_value());
  return pile;
}

TEST_CASE("a pile has the same bytes whatever the sampler drew before it; other samples and seeds differ") {
  for (const double mu : {0.1, 0.6, 1.3}) {
    for (const int columns : {4, 5, 33}) {
      INFO("mu " << mu << ", columns " << columns);
      const Lattice lattice({.columns = columns, .layers = 30});
      const std::vector<double> load(static_cast<std::size_t>(columns), 1.0);
      const auto fresh = make_sampler(spec_of(mu), lattice), used = make_sampler(spec_of(mu), lattice);
      for (std::uint64_t sample = 0; sample < 20; ++sample) drawn(*used, lattice, sample, load);
      const Pile first = drawn(*fresh, lattice, 7, load);
      CHECK(same_bytes(first, drawn(*used, lattice, 7, load)));
      CHECK(same_bytes(first, drawn(*used, lattice, 7, load)));
      CHECK(first.sample == 7);
      CHECK(first.seed == 42);
      CHECK_FALSE(same_bytes(first, drawn(*used, lattice, 8, load)));
      CHECK_FALSE(same_bytes(first, drawn(*used, lattice, 15, load)));
      SamplerSpec other = spec_of(mu);
      other.seed = 43;
      CHECK_FALSE(same_bytes(first, drawn(*make_sampler(other, lattice), lattice, 7, load)));
    }
  }
}

TEST_CASE("a pile of every law has the same bytes whatever the sampler drew before it, and under other loads") {
  const Lattice lattice({.columns = 5, .layers = 4});
  const std::vector<double> load(5, 1.0), other_load = {1, 2, 1, 1, 0.5};
  for (const Law law : all_laws) {
    for (const double lambda : {1.0, 0.25}) {
      if (law != Law::polytope && lambda != 1) continue;
      CAPTURE(name_of(law), lambda);
      SamplerSpec spec = spec_of(0.3, law);
      spec.lambda = lambda;
      const auto used = make_sampler(spec, lattice);
      for (std::uint64_t sample : {0, 3, 7, 8, 15, 1}) drawn(*used, lattice, sample, load);
      drawn(*used, lattice, 7, other_load);
      for (std::uint64_t sample : {7, 12, 6, 6, 0}) {
        const Pile alone = drawn(*make_sampler(spec, lattice), lattice, sample, load);
        CHECK(same_bytes(alone, drawn(*used, lattice, sample, load)));
        CHECK(alone.law == name_of(law));
        CHECK(alone.sample == sample);
        CHECK_FALSE(same_bytes(alone, drawn(*used, lattice, sample + 1, load)));
        CHECK_FALSE(same_bytes(alone, drawn(*used, lattice, sample + 8, load)));
        assert_identities(alone);
        const AuditResult result = audit(alone);
        CHECK(result.max_balance_residual <= 1e-12);
        CHECK(result.max_cone_violation <= 1e-12);
      }
    }
  }
}

TEST_CASE("a failure leaves nothing behind in the sampler") {
  const Lattice lattice({.columns = 60, .layers = 60});
  SamplerSpec spec = spec_of(0.1);
  std::vector<double> infeasible(60, 1.0);
  infeasible[30] = 1e6;  // next to this load the others vanish, and an isolated load has no solution at small friction
  const std::vector<double> load(60, 1.0);
  spec.effort = 2;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice);
  REQUIRE(sampler->draw(0, infeasible, pile).has_value());
  CHECK(same_bytes(drawn(*sampler, lattice, 3, load), drawn(*make_sampler(spec, lattice), lattice, 3, load)));
}

TEST_CASE("loads in another unit of force give the pile in that unit, bit for bit", "[unsanitized]") {
  for (const Law law : all_laws) {
    for (const double mu : {0.0, 0.1, 0.3, 0.8, 1.3, 1.7}) {
      for (const int columns : {4, 5, 24}) {
        if (law != Law::granusolve && (columns > 5 || mu > 0.8)) continue;
        const Lattice lattice({.columns = columns, .layers = law == Law::granusolve ? 40 : 3});
        std::vector<double> load(static_cast<std::size_t>(columns), 1.0);
        load[1] = 1.75;
        SamplerSpec spec = spec_of(mu, law);
        if (law == Law::eloy_clement) spec.effort = 1e6;  // it takes some hundred draws per bead
        if (law == Law::polytope)
          spec.lambda = columns == 4 ? 0.3 : 1;  // 0.3 needs a power, which must have no unit either
        const auto sampler = make_sampler(spec, lattice);
        CAPTURE(name_of(law), mu, columns);
        for (std::uint64_t sample = 0; sample < 5; ++sample) {
          const Pile plain = drawn(*sampler, lattice, sample, load);
          for (const int power : {-500, -1, 1, 500}) {
            INFO("mu " << mu << ", columns " << columns << ", sample " << sample << ", unit 2^" << power);
            std::vector<double> scaled_load = load;
            for (double& force : scaled_load) force = std::ldexp(force, power);
            Pile expected = plain;
            for (auto array : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L, &Pile::load}) {
              for (double& force : expected.*array) force = std::ldexp(force, power);
            }
            CHECK(same_bytes(drawn(*sampler, lattice, sample, scaled_load), expected));
          }
        }
      }
    }
  }
}

TEST_CASE("an effort that runs out is a named failure, not an endless loop") {
  const Lattice lattice({.columns = 60, .layers = 60});
  std::vector<double> load(60, 1.0);
  load[30] = 1e6;
  const auto sampler = make_sampler(spec_of(0.1), lattice);
  Pile pile(lattice);
  const auto failure = sampler->draw(0, load, pile);
  REQUIRE(failure.has_value());
  CHECK(failure->layer >= 1);
  CHECK(failure->layer < 60);
  // The same failure every time.
  const auto again = make_sampler(spec_of(0.1), lattice)->draw(0, load, pile);
  REQUIRE(again.has_value());
  CHECK(again->layer == failure->layer);
}

TEST_CASE("the smallest effort either completes a pile or fails by name") {
  const Lattice lattice({.columns = 40, .layers = 40});
  SamplerSpec spec = spec_of(0.6);
  spec.effort = 1;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice);
  for (std::uint64_t sample = 0; sample < 200; ++sample) {
    if (const auto failure = sampler->draw(sample, std::vector<double>(40, 1.0), pile)) {
      CHECK(failure->layer > 0);
    } else {
      assert_identities(pile);
    }
  }
}

TEST_CASE("loads and specs without a meaning are refused") {
  const Lattice lattice({.columns = 6, .layers = 6});
  for (const Law law : all_laws) {
    for (const double mu : {0.0, 0.3}) {
      const auto sampler = make_sampler(spec_of(mu, law), lattice);
      Pile pile(lattice);
      for (const double force :
           {0.0, -0.0, -1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
        std::vector<double> load(6, 1.0);
        load[5] = force;
        CHECK_THROWS_AS(sampler->draw(0, load, pile), InputError);
      }
      CHECK_THROWS_AS(sampler->draw(std::uint64_t{1} << 32, std::vector<double>(6, 1.0), pile), InputError);
      CHECK_THROWS_AS(sampler->draw(0, std::vector<double>(7, 1.0), pile), std::logic_error);
    }
  }
  SamplerSpec spec = spec_of(0.3);
  for (const double effort :
       {0.0, 0.99, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    spec.effort = effort;
    INFO("effort " << effort);
    CHECK_THROWS_AS(make_sampler(spec, lattice), InputError);
  }
  spec = spec_of(std::numeric_limits<double>::quiet_NaN());
  CHECK_THROWS_AS(make_sampler(spec, lattice), InputError);
  spec = spec_of(1.8);
  CHECK_THROWS_AS(make_sampler(spec, lattice), InputError);
  spec = spec_of(0.3, Law::rejection);
  spec.max_tries = 0;
  CHECK_THROWS_AS(make_sampler(spec, lattice), InputError);
  for (const double lambda :
       {-0.001, 1.001, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    spec = spec_of(0.3, Law::polytope);
    spec.lambda = lambda;
    CHECK_THROWS_AS(make_sampler(spec, lattice), InputError);
  }
  spec = spec_of(0.3, Law::polytope);
  spec.burn_in = most_sweeps + 1;
  CHECK_THROWS_AS(make_sampler(spec, lattice), InputError);
  CHECK_THROWS_AS(law_named("granusolver"), InputError);
  for (const Law law : all_laws) CHECK(law_named(name_of(law)) == law);
}

}  // namespace

}  // namespace granuscope
