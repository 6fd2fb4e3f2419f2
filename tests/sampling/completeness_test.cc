// Source: the paper solves 500 x 200 and 1000 x 1000 beads up to mu ~ 1.7 in a time linear in the number of beads.
// Every pile must complete, balance and stay in its cones.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "kit/sampling_statistics.h"
#include "model/audit.h"
#include "model/lattice.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

/// Largest residual of an audited pile: rounding of sums of a few forces, with room.
constexpr double audit_tolerance = 1e-12;

struct Survey {
  int piles = 0, stuck = 0, bad = 0;
  double worst_balance = 0, worst_cone = 0, worst_identity = 0;
  SamplerCounts counts;
};

void draw_one(LatticeSpec size, double mu, std::uint64_t seed, const std::vector<double>& load, Survey& survey) {
  const Lattice lattice(size);
  SamplerSpec spec;
  spec.mu = mu;
  spec.seed = seed;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice);
  ++survey.piles;
  if (sampler->draw(0, load, pile)) {
    ++survey.stuck;
    UNSCOPED_INFO("stuck: " << size.columns << " x " << size.layers << ", mu " << mu << ", seed " << seed);
    return;
  }
  const AuditResult result = audit(pile);
  const IdentityResiduals identities = identity_residuals(pile);
  survey.worst_balance = std::max(survey.worst_balance, result.max_balance_residual);
  survey.worst_cone = std::max(survey.worst_cone, result.max_cone_violation);
  survey.worst_identity = std::max({survey.worst_identity, identities.weight_sum, identities.wave_equation});
  if (!(result.max_balance_residual <= audit_tolerance && result.max_cone_violation <= audit_tolerance &&
        identities.weight_sum <= identity_tolerance && identities.wave_equation <= identity_tolerance)) {
    ++survey.bad;
    UNSCOPED_INFO("bad: " << size.columns << " x " << size.layers << ", mu " << mu << ", seed " << seed);
  }
  survey.counts = sampler->counts();
}

std::vector<double> point_load(int columns) {
  std::vector<double> load(static_cast<std::size_t>(columns), 1.0);
  load[load.size() / 2] = 2;
  return load;
}

void survey_paper(int seeds) {
  Survey survey;
  const LatticeSpec size = test::sanitized ? LatticeSpec{100, 200} : LatticeSpec{500, 200};
  for (int step = 0; step <= 65; ++step) {
    for (int seed = 1; seed <= seeds; ++seed) {
      draw_one(size, 0.02 * step, static_cast<std::uint64_t>(seed), point_load(size.columns), survey);
    }
  }
  CAPTURE(survey.worst_balance, survey.worst_cone, survey.worst_identity);
  CHECK(survey.piles == 66 * seeds);
  CHECK(survey.stuck == 0);
  CHECK(survey.bad == 0);
}

/// Piles of 4 to 64 columns, 1 to 80 layers, mu from 0.005 to `most_friction`, under uniform, point and uneven loads.
void survey_random_sizes(int piles, double most_friction) {
  constexpr std::uint64_t seed = 1234;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  Survey survey;
  for (int k = 0; k < piles; ++k) {
    const double mu = 0.005 + (most_friction - 0.005) * unit(engine);
    const int columns = 4 + static_cast<int>(61 * unit(engine) * unit(engine)),
              layers = 1 + static_cast<int>(80 * unit(engine));
    std::vector<double> load(static_cast<std::size_t>(columns), 1.0);
    const double kind = unit(engine);
    if (kind < 0.3) load = point_load(columns);
    if (kind > 0.6) {
      for (double& force : load) force = 0.7 + 0.6 * unit(engine);
    }
    draw_one({.columns = columns, .layers = layers}, mu, static_cast<std::uint64_t>(k), load, survey);
  }
  CAPTURE(survey.worst_balance, survey.worst_cone, survey.worst_identity);
  CHECK(survey.piles == piles);
  CHECK(survey.stuck == 0);
  CHECK(survey.bad == 0);
}

double draws_per_bead(int size, double mu) {
  Survey survey;
  draw_one({.columns = size, .layers = size}, mu, 9, point_load(size), survey);
  REQUIRE(survey.stuck == 0);
  REQUIRE(survey.bad == 0);
  return static_cast<double>(survey.counts.uniforms) / static_cast<double>(survey.counts.beads);
}

TEST_CASE("every friction coefficient 0, 0.02 ... 1.3 completes at the paper's size") { survey_paper(1); }

TEST_CASE("every friction coefficient completes at the paper's size, many seeds", "[long]") { survey_paper(20); }

TEST_CASE("piles of every size complete") { survey_random_sizes(5000 / test::share_of_samples, 1.73); }

TEST_CASE("41 000 piles of every size complete", "[long]") { survey_random_sizes(41'000, 1.73); }

TEST_CASE("the smallest piles complete: four columns, one and two layers, extreme friction") {
  Survey survey;
  for (const int columns : {4, 5, 6, 7, 8, 9}) {
    for (const int layers : {1, 2, 3, 30}) {
      for (const double mu : {1e-9, 1e-3, 0.1, 0.57735, tan30, 1.0, 1.7, 1.73}) {
        for (std::uint64_t seed = 0; seed < 10; ++seed) {
          draw_one({.columns = columns, .layers = layers}, mu, seed, point_load(columns), survey);
        }
      }
    }
  }
  CAPTURE(survey.worst_balance, survey.worst_cone, survey.worst_identity);
  CHECK(survey.stuck == 0);
  CHECK(survey.bad == 0);
}

// Where the cone is within 1e-3 of the horizontal, t_plus amplifies rounding (4e5 at mu = 1.73204) and splits that were
// solvable on paper are not; beads are then repaired more than once, and none may be left with forces of the past.
TEST_CASE("next to the limit of sqrt 3 piles complete and balance up to rounding times t_plus") {
  const LatticeSpec size{test::sanitized ? 100 : 500, 100};
  for (const double mu : {1.7315, 1.732, 1.73204, 1.73205, 1.7320508}) {
    const FrictionCone cone(mu);
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      Survey survey;
      draw_one(size, mu, seed, point_load(size.columns), survey);
      CAPTURE(mu, seed, cone.t_plus());
      CHECK(survey.stuck == 0);
      CHECK(survey.worst_balance <= 64 * std::numeric_limits<double>::epsilon() * cone.t_plus());
      CHECK(survey.worst_cone <= audit_tolerance);
    }
  }
}

TEST_CASE("a million beads complete at any friction, with work per bead that does not grow", "[long]") {
  for (const double mu : {0.05, 0.1, 0.3, 0.6, 1.0, 1.3, 1.6, 1.73}) {
    const double small = draws_per_bead(250, mu), large = draws_per_bead(1000, mu);
    CAPTURE(mu, small, large);
    CHECK(large < 1.2 * small);
    CHECK(large > small / 1.2);
  }
}

// Source: numbers on record: draws per bead of an independent implementation that is not in the repository, 500 x 200
// beads under a uniform load, printed to the digits given. Its repairs differ in details only, so that a tenth is
// allowed. It draws a new number for the solved bead beside one that a pair repairs, which keeps its first one here.
TEST_CASE("the number of draws per bead is that of an independent implementation") {
  const Lattice lattice({.columns = test::sanitized ? 100 : 500, .layers = 200});
  const std::vector<double> load(static_cast<std::size_t>(lattice.columns()), 1.0);
  for (const auto& [mu, expected] : {std::pair{0.1, 1.11}, {0.3, 1.40}, {0.8, 2.36}, {1.3, 3.15}, {1.72, 4.5}}) {
    SamplerSpec spec;
    spec.mu = mu;
    const auto sampler = make_sampler(spec, lattice);
    Pile pile(lattice);
    for (std::uint64_t sample = 0; sample < 4; ++sample)
      REQUIRE_FALSE(sampler->draw(8 * sample, load, pile).has_value());
    const double measured = static_cast<double>(sampler->counts().uniforms + sampler->counts().pairs) /
                            static_cast<double>(sampler->counts().beads);
    CAPTURE(mu, measured, expected);
    CHECK(measured == Approx(expected).epsilon(0.1));
  }
}

}  // namespace
}  // namespace granuscope
