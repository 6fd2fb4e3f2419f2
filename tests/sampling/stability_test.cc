// Sources: balances and cones hold whatever the size, the friction or the load. Residuals are those of an audit in
// another form than the sampler's, relative to the largest force of the layer.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "kit/sampling_statistics.h"
#include "model/audit.h"
#include "model/lattice.h"
#include "sampling/sampler.h"
#include "support/error.h"

namespace granuscope {
namespace {

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

TEST_CASE("a contact that is pulled is no solution, however small the friction is against rounding") {
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
