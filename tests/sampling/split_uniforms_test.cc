#include "sampling/pile_group.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "model/audit.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

struct Drawn {
  Pile pile;
  std::unique_ptr<Sampler> sampler;
};

Drawn draw(Law law, double mu, LatticeSpec size, std::uint64_t sample, const std::vector<double>& load) {
  const Lattice lattice(size);
  SamplerSpec spec;
  spec.law = law;
  spec.mu = mu;
  spec.seed = 31;
  Drawn drawn{Pile(lattice), make_sampler(spec, lattice)};
  REQUIRE_FALSE(drawn.sampler->draw(sample, load, drawn.pile).has_value());
  return drawn;
}

std::size_t count_redrawn(const Pile& first, const Pile& again) {
  std::vector<unsigned char> redrawn;
  find_redrawn(first, again, redrawn);
  return std::accumulate(redrawn.begin(), redrawn.end(), std::size_t{0});
}

constexpr LatticeSpec small{.columns = 40, .layers = 50}, tiny{.columns = 4, .layers = 4};

}  // namespace

TEST_CASE("numbers are the places of the splits in their intervals") {
  const Drawn first = draw(Law::rejection, 0.3, tiny, 2, std::vector<double>(4, 1.0));
  std::vector<double> numbers;
  read_split_uniforms(first.pile, numbers);
  const RandomKey key(31, 2);
  // The try that was accepted is the last one; every number is then the one it drew.
  const auto attempt = static_cast<std::uint32_t>(first.sampler->counts().tries);
  for (int n = 0; n < 4; ++n) {
    for (int i = 0; i < 4; ++i) {
      CHECK(numbers[first.pile.lattice.index(n, i)] == Approx(key.attempt(n, i, attempt).first).margin(1e-12));
    }
  }
}

TEST_CASE("solved again under the same load a pile is the same, byte for byte") {
  // Byte for byte: forces as a function of the numbers are chaotic, and at mu = 1 rounding alone would change every
  // force below 50 layers.
  for (const double mu : {0.0, 0.02, 0.1, 0.5, 1.0, 1.7}) {
    const std::vector<double> load(40, 1.0);
    Drawn first = draw(Law::granusolve, mu, {.columns = 40, .layers = 400}, 3, load);
    Pile again(first.pile.lattice);
    const auto uniforms_before = first.sampler->counts().uniforms;
    REQUIRE_FALSE(first.sampler->draw_again(3, load, first.pile, again).has_value());
    INFO("mu " << mu);
    CHECK(count_redrawn(first.pile, again) == 0);
    CHECK(first.sampler->counts().uniforms == uniforms_before);  // nothing was drawn
    CHECK(again.H_R == first.pile.H_R);
    CHECK(again.V_L == first.pile.V_L);
  }
}

TEST_CASE("a load multiplied by a power of two redraws nothing and scales the pile") {
  const std::vector<double> load(40, 1.0), quadrupled(40, 4.0);
  Drawn first = draw(Law::granusolve, 0.3, small, 5, load);
  Pile again(first.pile.lattice);
  REQUIRE_FALSE(first.sampler->draw_again(5, quadrupled, first.pile, again).has_value());
  CHECK(count_redrawn(first.pile, again) == 0);
  for (std::size_t at = 0; at < again.V_R.size(); ++at) {
    CHECK(again.V_R[at] == Approx(4 * first.pile.V_R[at]).epsilon(1e-9));
  }
}

TEST_CASE("an overload redraws beads inside its light cone only, and the piles stay solutions") {
  // A failing bead makes its parents change, and those their children: the disturbance spreads by a column or so per
  // layer, whatever the friction; on the far side of the ring the two piles are the same.
  const LatticeSpec wide{.columns = 300, .layers = 40};
  std::vector<double> load(300, 1.0);
  for (const double mu : {0.1, 0.3, 1.0}) {
    std::size_t redrawn_beads = 0;
    for (std::uint64_t sample = 0; sample < 20; ++sample) {
      load[150] = 1;
      Drawn first = draw(Law::granusolve, mu, wide, sample, load);
      load[150] = 2;
      Pile again(first.pile.lattice);
      REQUIRE_FALSE(first.sampler->draw_again(sample, load, first.pile, again).has_value());
      const AuditResult residuals = granuscope::audit(again);
      CHECK(residuals.max_balance_residual < 1e-10);
      CHECK(residuals.max_cone_violation < 1e-10);
      std::vector<unsigned char> redrawn;
      find_redrawn(first.pile, again, redrawn);
      for (int n = 0; n < 40; ++n) {
        for (int i = 0; i < 300; ++i) {
          const std::size_t at = again.lattice.index(n, i);
          redrawn_beads += redrawn[at];
          if (std::abs(again.lattice.x(n, i)) > 120) {
            CHECK(redrawn[at] == 0);
            CHECK(again.V_R[at] == first.pile.V_R[at]);
          }
        }
      }
    }
    INFO("mu " << mu);
    CHECK(redrawn_beads > 0);
  }
}

// A pair draws two numbers and the three ancestors at the top of a first backtrack (four where the backtrack ends at
// the top of the pile) one each. Nothing else does: beads that draw again because a neighbour was repaired or a
// backtrack has unsolved them, and beads that had no solution themselves, keep their numbers.
TEST_CASE("solved again, only repaired parents and the top of a backtrack draw numbers") {
  const LatticeSpec size{.columns = 60, .layers = 40};
  std::vector<double> load(60, 1.0), overloaded = load;
  overloaded[30] = 2;
  int pairs_alone = 0, one_backtrack = 0;
  std::uint64_t redrawn_beads = 0, numbers = 0;
  for (const double mu : {0.1, 0.3, 0.8}) {
    SamplerSpec spec;
    spec.mu = mu;
    spec.seed = 31;
    const Lattice lattice(size);
    const auto sampler = make_sampler(spec, lattice);
    Pile first(lattice), again(lattice);
    for (std::uint64_t sample = 0; sample < 100; ++sample) {
      REQUIRE_FALSE(sampler->draw(sample, load, first));
      const SamplerCounts before = sampler->counts();
      REQUIRE_FALSE(sampler->draw_again(sample, overloaded, first, again));
      const SamplerCounts after = sampler->counts();
      if (after.arcs + after.rings > before.arcs + before.rings) continue;
      const std::uint64_t drawn = after.uniforms - before.uniforms, of_pairs = 2 * (after.pairs - before.pairs),
                          backtracks = after.backtracks - before.backtracks;
      CAPTURE(mu, sample, drawn, of_pairs, backtracks);
      if (backtracks == 0) {
        CHECK(drawn == of_pairs);
        pairs_alone += drawn > 0 ? 1 : 0;
        redrawn_beads += count_redrawn(first, again);
        numbers += drawn;
      } else if (backtracks == 1) {
        CHECK(drawn >= of_pairs + 3);
        CHECK(drawn <= of_pairs + 4);
        ++one_backtrack;
      }
    }
  }
  CAPTURE(pairs_alone, one_backtrack, redrawn_beads, numbers);
  CHECK(pairs_alone >= 50);
  CHECK(one_backtrack >= 10);
  // A parent that was repaired stands elsewhere than its number would put it, unless it was repaired more than once.
  CHECK(redrawn_beads <= numbers);
  CHECK(10 * redrawn_beads > 7 * numbers);
}

// What is drawn when a pile is solved again is independent of the numbers it keeps, of which some are later attempts of
// the first solution. The numbers of both are told apart by their attempts.
TEST_CASE("numbers drawn when a pile is solved again are none of the first solution") {
  const LatticeSpec size{.columns = 60, .layers = 40};
  const Lattice lattice(size);
  std::vector<double> load(60, 1.0), overloaded = load;
  overloaded[30] = 2;
  constexpr std::uint32_t tries = 16, again_after = std::uint32_t{1} << 23;
  std::vector<unsigned char> redrawn;
  std::vector<double> numbers;
  int of_first = 0, of_again = 0;
  for (std::uint64_t sample = 0; sample < 100; ++sample) {
    Drawn first = draw(Law::granusolve, 0.1, size, sample, load);
    Pile again(lattice);
    REQUIRE_FALSE(first.sampler->draw_again(sample, overloaded, first.pile, again));
    find_redrawn(first.pile, again, redrawn);
    read_split_uniforms(again, numbers);
    const RandomKey key(31, sample);
    for (int n = 0; n < size.layers; ++n) {
      for (int i = 0; i < size.columns; ++i) {
        const std::size_t at = lattice.index(n, i);
        if (redrawn[at] == 0) continue;
        for (std::uint32_t k = 1; k <= tries; ++k) {
          of_first += std::abs(key.attempt(n, i, k).first - numbers[at]) < 1e-9 ? 1 : 0;
          of_again += std::abs(key.attempt(n, i, again_after + k).first - numbers[at]) < 1e-9 ? 1 : 0;
        }
      }
    }
  }
  CHECK(of_first == 0);
  CHECK(of_again >= 20);  // beads at the top of a backtrack stand where their number says
}

TEST_CASE(
    "the law rejection, solved again, keeps every number, or draws a pile anew from tries that are not the first's") {
  const std::vector<double> load(4, 1.0), other = {1, 1, 1.6, 1};
  const Lattice lattice(tiny);
  int kept = 0, drawn_anew = 0;
  std::vector<double> numbers;
  for (std::uint64_t sample = 0; sample < 300; ++sample) {
    Drawn first = draw(Law::rejection, 0.3, tiny, sample, load);
    const auto tries = static_cast<std::uint32_t>(first.sampler->counts().tries);
    const auto uniforms = first.sampler->counts().uniforms;
    CAPTURE(sample, tries);
    Pile again(lattice);
    REQUIRE_FALSE(first.sampler->draw_again(sample, load, first.pile, again));
    CHECK(again.H_R == first.pile.H_R);
    CHECK(again.V_L == first.pile.V_L);
    CHECK(first.sampler->counts().tries == tries + 1);
    REQUIRE_FALSE(first.sampler->draw_again(sample, other, first.pile, again));
    if (first.sampler->counts().tries == tries + 2) {
      CHECK(first.sampler->counts().uniforms == uniforms);
      CHECK(count_redrawn(first.pile, again) == 0);
      ++kept;
      continue;
    }
    ++drawn_anew;
    read_split_uniforms(again, numbers);
    const RandomKey key(31, sample);
    int of_first = 0;
    for (std::uint32_t attempt = 1; attempt <= tries; ++attempt) {
      of_first += std::abs(key.attempt(0, 0, attempt).first - numbers[0]) < 1e-12 ? 1 : 0;
    }
    CHECK(of_first == 0);
  }
  CHECK(kept > 20);
  CHECK(drawn_anew > 20);
}

TEST_CASE("solving again depends on its arguments only, for every law") {
  for (const Law law : {Law::granusolve, Law::rejection}) {
    std::vector<double> load(4, 1.0);
    Drawn first = draw(law, 0.3, tiny, 9, load);
    load[2] = 2;
    Pile again(first.pile.lattice), once_more(first.pile.lattice), other(first.pile.lattice);
    REQUIRE_FALSE(first.sampler->draw_again(9, load, first.pile, again).has_value());
    REQUIRE_FALSE(first.sampler->draw(17, load, other).has_value());
    REQUIRE_FALSE(first.sampler->draw_again(9, load, first.pile, once_more).has_value());
    CHECK(again.H_R == once_more.H_R);
    // After solving again, an ordinary pile is an ordinary pile.
    Pile plain(first.pile.lattice);
    REQUIRE_FALSE(first.sampler->draw(9, std::vector<double>(4, 1.0), plain).has_value());
    CHECK(plain.H_R == first.pile.H_R);
  }
}

TEST_CASE("a first pile of another lattice, or the same pile twice, is refused") {
  const std::vector<double> load(4, 1.0);
  Drawn first = draw(Law::granusolve, 0.3, tiny, 9, load);
  CHECK_THROWS_AS(first.sampler->draw_again(9, load, first.pile, first.pile), std::logic_error);
  Pile again(first.pile.lattice);
  CHECK_THROWS_AS(first.sampler->draw_again(9, load, Pile(Lattice(small)), again), std::logic_error);
}

}  // namespace granuscope
