// Sources: balances and cones hold whatever the friction or the load; which loads have a solution follows from t-.
#include "analysis/stress.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <string>

#include "model/audit.h"
#include "model/friction_cone.h"
#include "sampling/sampler.h"

using namespace granuscope;

TEST_CASE("Every pile of the stress test is solved with small residuals or named") {
  const auto trials = run_stress({500, 32}, 3);
  CHECK(trials.size() == 4 * stress_friction().size());
  std::set<std::string> loads;
  for (const StressTrial& trial : trials) {
    CAPTURE(trial.mu, trial.load, trial.outcome, trial.reason);
    loads.insert(trial.load);
    if (trial.outcome == "solved") {
      CHECK(trial.residual <= 1e-10);
      CHECK(trial.rounded_per_bead >= 0);
      CHECK(trial.depths.front().first_layer == 0);
      CHECK(trial.depths.back().last_layer == trial.layers - 1);
    } else {
      CHECK_FALSE(trial.reason.empty());
      CHECK(trial.depths.empty());
      CHECK_FALSE(trial.deep);
    }
    if (trial.load == "half of the beads unloaded" && std::abs(trial.mu - tan30) > 1e-6) {
      CHECK(trial.outcome == (trial.mu < tan30 ? "refused" : "solved"));
    }
  }
  CHECK(loads.size() == 3);
  CHECK(run_stress({}, 3).empty());
}

TEST_CASE("The audit by layers has the worst layer of the whole") {
  const Lattice lattice({8, 30});
  SamplerSpec spec;
  spec.mu = 0.3;
  Pile pile(lattice);
  REQUIRE_FALSE(make_sampler(spec, lattice)->draw(0, std::vector<double>(8, 1.0), pile));
  pile.H_R[lattice.index(17, 3)] += 0.5;
  const AuditResult whole = audit(pile);
  const auto layers = audit_layers(pile);
  REQUIRE(layers.size() == 30);
  CHECK(whole.max_balance_residual > 0.01);
  CHECK(layers[static_cast<std::size_t>(whole.balance_layer)].balance == whole.max_balance_residual);
  CHECK(layers[static_cast<std::size_t>(whole.cone_layer)].cone == whole.max_cone_violation);
  CHECK((whole.balance_layer == 17 || whole.balance_layer == 18));
}
