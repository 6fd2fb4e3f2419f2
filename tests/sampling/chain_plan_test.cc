#include "sampling/polytope.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "support/error.h"
#include "support/progress.h"

namespace granuscope {
namespace {

TEST_CASE("a chain is measured once in a program, and another one anew", "[unsanitized]") {
  const Lattice lattice({.columns = 6, .layers = 7});
  std::vector<double> load(6, 1.0);
  SamplerSpec spec;
  spec.law = Law::polytope;
  spec.mu = 0.3;
  spec.seed = 4711;  // asked for by no other test
  const auto seconds = [&] {
    const double start = processor_seconds();
    const SamplerSpec measured = with_measured_chain(spec, lattice, load);
    const double took = processor_seconds() - start;
    const ChainPlan plan = plan_chain(spec, lattice, load);
    CHECK(measured.burn_in == plan.burn_in);
    CHECK(measured.thinning == plan.thinning);
    return took;
  };
  const double first = seconds(), again = seconds();
  CHECK(again < 0.1 * first);
  // Whatever it depends on makes it another one.
  spec.seed += std::uint64_t{1} << 40;
  CHECK(seconds() > again);
  spec.lambda = 0.5;
  CHECK(seconds() > again);
  load[2] = 1.5;
  CHECK(seconds() > again);
}

TEST_CASE("that a chain cannot be measured is said again in the same words") {
  const Lattice lattice({.columns = 4, .layers = 12});
  // Loads so uneven that the pile a chain starts from runs out of its effort.
  const std::vector<double> load = {1, 1, 1e300, 1};
  SamplerSpec spec;
  spec.law = Law::polytope;
  spec.mu = 0.1;
  std::vector<std::string> words;
  for (int k = 0; k < 2; ++k) {
    try {
      (void)with_measured_chain(spec, lattice, load);
    } catch (const InputError& refused) {
      words.emplace_back(refused.what());
    }
  }
  REQUIRE(words.size() == 2);
  CHECK(words[0] == words[1]);
  CHECK_THAT(words[0], Catch::Contains("none could be completed under this load"));
}

}  // namespace
}  // namespace granuscope
