// Sources: each rule's counter is 0 where the rule is off; every pile is held to the audit. Without friction's help the
// frictionless pile is admissible wherever t- <= 0 <= t+ around the direction of a contact.
#include <catch2/catch.hpp>
#include <vector>

#include "model/audit.h"
#include "model/lattice.h"
#include "sampling/sampler.h"
#include "sampling/simple_laws.h"
#include "support/error.h"

namespace granuscope {
namespace {

constexpr double residual_of_rounding = 1e-12;

SamplerSpec spec_with(RepairRules rules) {
  SamplerSpec spec;
  spec.mu = 0.3;
  spec.rules = rules;
  return spec;
}

TEST_CASE("without some of its rules granusolve repairs by the others, and its piles stay solutions") {
  const Lattice lattice({16, 40});
  const std::vector<double> load(16, 1.0);
  for (const RepairRules rules :
       {RepairRules::all, RepairRules::no_pair, RepairRules::no_arcs, RepairRules::backtrack_only}) {
    CAPTURE(name_of(rules));
    SamplerSpec spec = spec_with(rules);
    if (rules == RepairRules::backtrack_only) spec.mu = 0.05;  // at 0.3 it completes nothing: see below
    const auto sampler = make_sampler(spec, lattice);
    Pile pile(lattice);
    for (std::uint64_t sample = 0; sample < 40; ++sample) {
      REQUIRE_FALSE(sampler->draw(sample, load, pile));
      const AuditResult result = audit(pile);
      CHECK(result.max_balance_residual < residual_of_rounding);
      CHECK(result.max_cone_violation < residual_of_rounding);
    }
    const bool pair = rules == RepairRules::all || rules == RepairRules::no_arcs;
    const bool arcs = rules == RepairRules::no_pair;
    CHECK((sampler->counts().repaired_by_pair > 0) == pair);
    if (arcs) CHECK(sampler->counts().repaired_by_arc > 0);
    if (rules == RepairRules::no_arcs || rules == RepairRules::backtrack_only) {
      CHECK(sampler->counts().repaired_by_arc + sampler->counts().repaired_by_ring == 0);
    }
    CHECK(repair_rules_named(name_of(rules)) == rules);
  }
}

TEST_CASE("piles side by side are those of one by one under any repair rules") {
  const Lattice lattice({12, 20});
  const std::vector<double> load(12, 1.0);
  for (const RepairRules rules : {RepairRules::no_pair, RepairRules::no_arcs}) {
    const auto together = make_sampler(spec_with(rules), lattice), alone = make_sampler(spec_with(rules), lattice);
    std::vector<std::uint64_t> samples;
    for (std::uint64_t k = 0; k < 8; ++k) samples.push_back(k);
    const std::vector<std::span<const double>> loads(8, load);
    std::vector<std::optional<SamplingFailure>> failures(8);
    together->draw_groups(samples, loads, failures);
    Pile pile(lattice);
    for (const std::uint64_t sample : samples) CHECK_FALSE(alone->draw(sample, load, pile));
    CHECK(together->counts().uniforms == alone->counts().uniforms);
  }
}

TEST_CASE("by backtracks alone nothing is completed at mu = 0.3: the effort runs out, by name") {
  const Lattice lattice({16, 40});
  const std::vector<double> load(16, 1.0);
  const auto sampler = make_sampler(spec_with(RepairRules::backtrack_only), lattice);
  Pile pile(lattice);
  CHECK(sampler->draw(0, load, pile).has_value());
}

TEST_CASE("repair rules are refused by name where they mean nothing") {
  CHECK_THROWS_AS(repair_rules_named("none"), InputError);
  SamplerSpec spec = spec_with(RepairRules::no_pair);
  spec.law = Law::rejection;
  CHECK_THROWS_AS(validate(spec), InputError);
}

TEST_CASE("at t- = 0 a half unloaded top has a solution: the frictionless pile") {
  const Lattice lattice({40, 60});
  std::vector<double> load(40, 1.0);
  std::fill(load.begin(), load.begin() + 20, 0.0);
  Pile pile(lattice);
  fill_frictionless(load, pile);
  pile.mu = tan30;
  REQUIRE(FrictionCone(tan30).t_minus() == 0);
  const AuditResult result = audit(pile);
  CHECK(result.max_balance_residual < residual_of_rounding);
  CHECK(result.max_cone_violation < residual_of_rounding);
}

}  // namespace
}  // namespace granuscope
