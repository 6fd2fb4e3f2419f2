// Source: piles drawn side by side are those drawn one by one; equality is exact.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "kit/instruction_sets.h"
#include "kit/same_bytes.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

using test::same_bytes;

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
      piles.push_back(pile_of(group, k));
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
  CHECK_THROWS_AS(pile_of(group, 0), std::logic_error);
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

}  // namespace
}  // namespace granuscope
