// Source: a draw that is stopped leaves a sampler that draws as if nothing had been.
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>
#include <vector>

#include "sampling/sampler.h"
#include "support/error.h"
#include "support/progress.h"

namespace granuscope {
namespace {

/// Asked for until the end of its life.
class Stop {
 public:
  Stop() { request_interruption(true); }
  ~Stop() { request_interruption(false); }
  Stop(const Stop&) = delete;
  Stop& operator=(const Stop&) = delete;
};

TEST_CASE("every law stops in the midst of a pile where that is asked for, and goes on afterwards") {
  const Lattice lattice({6, 6});
  const std::vector<double> load(6, 1.0);
  const std::vector<std::span<const double>> loads(8, load);
  const std::vector<std::uint64_t> samples = {0, 1, 2, 3, 4, 5, 6, 7};
  for (const Law law : all_laws) {
    CAPTURE(name_of(law));
    SamplerSpec spec;
    spec.law = law;
    spec.mu = 0.5;
    spec.burn_in = spec.thinning = law == Law::polytope ? 50 : 0;
    const auto stopped = make_sampler(spec, lattice), other = make_sampler(spec, lattice);
    Pile pile(lattice), expected(lattice);
    std::vector<std::optional<SamplingFailure>> failures(8);
    {
      const Stop stop;
      CHECK_THROWS_AS(stopped->draw(3, load, pile), Interrupted);
      CHECK_THROWS_AS(stopped->draw_groups(samples, loads, failures), Interrupted);
    }
    stopped->take_counts();
    REQUIRE_FALSE(other->draw(5, load, expected));
    REQUIRE_FALSE(stopped->draw(5, load, pile));
    CHECK(pile.H_R == expected.H_R);
    CHECK(stopped->counts().uniforms == other->counts().uniforms);
    const auto groups = stopped->draw_groups(samples, loads, failures);
    double weight = 0;
    for (const PileGroup& group : groups) weight += group.weight(group.row(5));
    CHECK(weight > 0);
  }
}

TEST_CASE("a backtrack that finds no way does not outlive a request to stop") {
  const Lattice lattice({16, 40});
  const std::vector<double> load(16, 1.0);
  SamplerSpec spec;
  spec.mu = 0.3;
  spec.rules = RepairRules::backtrack_only;
  spec.effort = 1e9;
  Pile pile(lattice);
  const auto sampler = make_sampler(spec, lattice);
  // By backtracks alone no such pile is completed; without the request this would go on for days.
  const std::jthread later([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    request_interruption(true);
  });
  CHECK_THROWS_AS(sampler->draw(0, load, pile), Interrupted);
  request_interruption(false);
}

}  // namespace
}  // namespace granuscope
