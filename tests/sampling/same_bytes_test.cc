// Source: a pile is a pure function of its key, and the law has no unit of force; equality is exact.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "kit/same_bytes.h"
#include "model/audit.h"
#include "sampling/sampler.h"
#include "support/error.h"

namespace granuscope {
namespace {

using test::same_bytes;

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

TEST_CASE("loads in another unit of force give the pile in that unit, bit for bit") {
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
