// Source: piles drawn side by side are those drawn one by one; equality is exact.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <vector>

#include "instruction_sets.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

bool same_bytes(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

bool same_bytes(const Pile& a, const Pile& b) {
  return same_bytes(a.V_R, b.V_R) && same_bytes(a.V_L, b.V_L) && same_bytes(a.H_R, b.H_R) && same_bytes(a.H_L, b.H_L) &&
         same_bytes(a.load, b.load) && a.sample == b.sample && a.seed == b.seed && a.law == b.law && a.mu == b.mu;
}

void check_same_counts(const SamplerCounts& a, const SamplerCounts& b) {
  CHECK(a.beads == b.beads);
  CHECK(a.uniforms == b.uniforms);
  CHECK(a.tries == b.tries);
  CHECK(a.mended_by_pair == b.mended_by_pair);
  CHECK(a.mended_by_arc == b.mended_by_arc);
  CHECK(a.mended_by_ring == b.mended_by_ring);
  CHECK(a.climbed == b.climbed);
  CHECK(a.pairs == b.pairs);
  CHECK(a.arcs == b.arcs);
  CHECK(a.rings == b.rings);
  CHECK(a.climbs == b.climbs);
  CHECK(a.rounded == b.rounded);
}

/// Draws `count` samples from `first` on side by side and one by one, each under its own load.
void check_group(const SamplerSpec& spec, LatticeSpec lattice_spec, std::uint64_t first, std::size_t count,
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
  for (std::size_t k = 0; k < count; ++k) {
    Pile pile(lattice);
    const auto failure = single->draw(first + k, loads[k], pile);
    CAPTURE(k, first);
    REQUIRE(failure.has_value() == failures[k].has_value());
    if (failure) {
      CHECK(failure->layer == failures[k]->layer);
    } else {
      CHECK(same_bytes(pile, piles[k]));
    }
  }
  check_same_counts(together->counts(), single->counts());
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
  const Lattice lattice({50, 60});
  for (const double effort : {1.0, 1.6, 1.62, 1.64, 1.66, 1.7}) {
    spec.effort = effort;
    check_group(spec, {50, 60}, 8, 8, even_loads(50));
  }
  // A heavy bead beside light ones: climbs, one of which leaves the window of layers that a group holds, rings, and a
  // failure by name.
  spec.effort = 20;
  auto loads = even_loads(50);
  for (std::size_t k = 0; k < 8; k += 2) loads[k][25] = std::pow(10.0, static_cast<double>(k));
  check_group(spec, {50, 60}, 24, 8, loads);
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
