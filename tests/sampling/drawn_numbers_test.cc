// Source: the law's description (granusolve.h). Every bead stands where one of its own numbers puts it, unless a repair
// of a bead below has changed its split: of the last layer nobody's is changed, and every bead there keeps its first
// number.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "sampling/layer_kernels.h"
#include "sampling/pile_group.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

/// Beads of each layer that stand where none of their numbers puts them, of the first `attempts` after the first one.
std::vector<int> beads_off_their_numbers(const Pile& pile, std::uint32_t attempts) {
  constexpr double rounding = 1e-9;  // of a number recomputed from forces; two numbers are as close once in 1e9 times
  const auto columns = static_cast<std::size_t>(pile.lattice.columns());
  std::vector<double> numbers, first(columns + uniform_padding);
  read_split_uniforms(pile, numbers);
  const RandomKey key(pile.seed, pile.sample);
  std::vector<int> off;
  for (int n = 0; n < pile.lattice.layers(); ++n) {
    fill_first_uniforms(pile.seed, static_cast<std::uint32_t>(pile.sample), n, first.data(), columns);
    off.push_back(0);
    for (int i = 0; i < pile.lattice.columns(); ++i) {
      const double number = numbers[pile.lattice.index(n, i)];
      bool found = std::abs(first[static_cast<std::size_t>(i)] - number) < rounding;
      for (std::uint32_t k = 1; k <= attempts && !found; ++k) {
        found = std::abs(key.attempt(n, i, k).first - number) < rounding;
      }
      off.back() += found ? 0 : 1;
    }
  }
  return off;
}

TEST_CASE("in the last layer every bead keeps its first number, however it was solved") {
  for (const double mu : {0.1, 0.3, 0.8, 1.3}) {
    SamplerSpec spec;
    spec.mu = mu;
    spec.seed = 8;
    const Lattice lattice({.columns = 24, .layers = 12});
    const auto sampler = make_sampler(spec, lattice);
    Pile pile(lattice);
    for (std::uint64_t sample = 0; sample < 20; ++sample) {
      REQUIRE_FALSE(sampler->draw(sample, std::vector<double>(24, 1.0), pile));
      CAPTURE(mu, sample);
      CHECK(beads_off_their_numbers(pile, 0).back() == 0);
    }
    CHECK(sampler->counts().pairs + sampler->counts().backtracks > 10);
  }
}

// A pair changes two splits of the layer above. Of P pairs at least half as many as the top layer has changed splits
// were repaired in the middle layer; only the others have changed anything there. A bead of the middle layer that a
// backtrack solves again, or that draws again below a changed parent, stands where a number of its own puts it.
TEST_CASE(
    "beads that a backtrack or a repair above has solved again stand where a later number of their own puts them") {
  const std::vector<double> load = {1, 1, 1, 1, 8, 1, 1, 1};
  const Lattice lattice({.columns = 8, .layers = 3});
  SamplerSpec spec;
  spec.mu = 0.3;
  spec.seed = 17;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice);
  int backtracked = 0, repaired_after_backtrack = 0;
  for (std::uint64_t sample = 0; sample < 6000; ++sample) {
    const SamplerCounts before = sampler->counts();
    REQUIRE_FALSE(sampler->draw(sample, load, pile));
    const SamplerCounts after = sampler->counts();
    if (after.backtracks != before.backtracks + 1 || after.arcs + after.rings != before.arcs + before.rings) continue;
    ++backtracked;
    const int pairs = static_cast<int>(after.pairs - before.pairs);
    // The backtrack solves three beads of the top layer and four of the middle one again, with a number each; what else
    // draws are neighbours of beads of the middle layer that are repaired then.
    const auto numbers = static_cast<int>(after.uniforms - before.uniforms);
    const int neighbours = numbers - 24 - 2 * pairs - 7;
    const std::vector<int> off = beads_off_their_numbers(pile, 32);
    CAPTURE(sample, pairs, numbers, neighbours, off);
    CHECK(neighbours >= 0);
    CHECK(off[1] <= 2 * (pairs - (off[0] + 1) / 2));
    CHECK(off[2] == 0);
    repaired_after_backtrack += neighbours > 0 && off[1] == 2 * (pairs - (off[0] + 1) / 2) ? 1 : 0;
  }
  CAPTURE(backtracked, repaired_after_backtrack);
  CHECK(repaired_after_backtrack >= 40);
}

}  // namespace
}  // namespace granuscope
