// Source: backtracks that draw their numbers eight at a time are those that draw one after the other; equality is
// exact, of failures and counts too.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "kit/instruction_sets.h"
#include "kit/same_bytes.h"
#include "sampling/layer_kernels.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

using test::same_bytes;

struct Drawn {
  std::vector<Pile> piles;
  std::vector<int> failed_in;  ///< layer, or -1
  SamplerCounts counts;
};

Drawn drawn_alone(const SamplerSpec& spec, const Lattice& lattice, const std::vector<double>& load) {
  Drawn drawn;
  const auto sampler = make_sampler(spec, lattice);
  for (std::uint64_t sample = 0; sample < 4; ++sample) {
    drawn.piles.emplace_back(lattice);
    const auto failure = sampler->draw(sample, load, drawn.piles.back());
    drawn.failed_in.push_back(failure ? failure->layer : -1);
  }
  drawn.counts = sampler->counts();
  return drawn;
}

/// Draws piles with single numbers and with eight at a time; gives how often they backtracked.
std::uint64_t check_backtracks(const SamplerSpec& spec, LatticeSpec lattice_spec, const std::vector<double>& load) {
  CAPTURE(spec.mu, spec.seed, spec.effort, name_of(spec.rules), lattice_spec.columns, lattice_spec.layers);
  const Lattice lattice(lattice_spec);
  const auto one_by_one = [&] {
    const PlainKernels plain;
    return drawn_alone(spec, lattice, load);
  };
  const Drawn expected = one_by_one(), drawn = drawn_alone(spec, lattice, load);
  CHECK(drawn.failed_in == expected.failed_in);
  for (std::size_t k = 0; k < drawn.piles.size(); ++k) {
    if (drawn.failed_in[k] >= 0) continue;
    CHECK(same_bytes(drawn.piles[k].V_R, expected.piles[k].V_R));
    CHECK(same_bytes(drawn.piles[k].V_L, expected.piles[k].V_L));
    CHECK(same_bytes(drawn.piles[k].H_R, expected.piles[k].H_R));
    CHECK(same_bytes(drawn.piles[k].H_L, expected.piles[k].H_L));
  }
  const SamplerCounts &a = drawn.counts, &b = expected.counts;
  CHECK(a.uniforms == b.uniforms);
  CHECK(a.backtracks == b.backtracks);
  CHECK(a.pairs == b.pairs);
  CHECK(a.arcs == b.arcs);
  CHECK(a.rings == b.rings);
  CHECK(a.repaired_by_pair == b.repaired_by_pair);
  CHECK(a.backtracked == b.backtracked);
  CHECK(a.rounded == b.rounded);
  return b.backtracks;
}

/// Piles of all kinds; `rounding`: friction of a few ulps under loads of several orders of magnitude, so that nearly
/// all that holds a bead is rounding.
std::uint64_t check_random_backtracks(std::mt19937_64& generator, int trial, bool rounding) {
  std::uniform_real_distribution<double> uniform;
  SamplerSpec spec;
  spec.mu = rounding ? std::pow(10.0, -16 + 3.5 * uniform(generator)) : 0.02 + 0.3 * uniform(generator);
  spec.seed = generator();
  spec.rules = trial % 5 == 0 ? RepairRules::no_arcs : trial % 5 == 1 ? RepairRules::no_pair : RepairRules::all;
  // In one trial of three some run out of it.
  spec.effort = trial % 3 == 0 ? 1 + 0.3 * uniform(generator) * uniform(generator) : 20;
  // Narrow ones: backtracks at the seam, and at the ends of a layer's order.
  const int columns = 4 + static_cast<int>(26 * uniform(generator));
  const int layers = 4 + static_cast<int>(46 * uniform(generator));
  std::vector<double> load(static_cast<std::size_t>(columns), 1.0);
  if (rounding || trial % 2 == 0) {
    const double orders = rounding ? 3 + 2 * uniform(generator) : 3;
    for (double& force : load) force = std::pow(10.0, orders * uniform(generator));
  }
  return check_backtracks(spec, {columns, layers}, load);
}

TEST_CASE("backtracks that draw eight numbers at a time are those that draw one by one, wherever they set out from") {
  for_each_instruction_set([] {
    std::mt19937_64 generator(23);
    std::uint64_t backtracks = 0;
    for (int trial = 0; trial < 600; ++trial) backtracks += check_random_backtracks(generator, trial, trial % 3 == 1);
    CHECK(backtracks > 10'000);
  });
}

TEST_CASE("backtracks of a wide pile that draw eight numbers at a time are those that draw one by one") {
  SamplerSpec spec;
  std::uint64_t backtracks = 0;
  for (const double mu : {0.05, 0.1, 0.2}) {
    spec.mu = mu;
    backtracks += check_backtracks(spec, {200, 150}, std::vector<double>(200, 1.0));
  }
  CHECK(backtracks > 300);
}

}  // namespace
}  // namespace granuscope
