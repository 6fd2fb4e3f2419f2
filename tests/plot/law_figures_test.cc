#include <catch2/catch.hpp>
#include <cmath>

#include "kit/temporary_folder.h"
#include "plot/law_cost.h"
#include "plot/synthetic_analysis.h"
#include "support/atomic_file.h"
#include "support/error.h"

using namespace granuscope;
using test::TemporaryFolder;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("Work of the laws against size leaves out and names what was not completed") {
  const TemporaryFolder run;
  std::vector<LawOnPiles> costs;
  for (const Law law : {Law::granusolve, Law::eloy_clement}) {
    for (const int size : {4, 6, 8}) {
      LawOnPiles one;
      one.spec.sampler.law = law;
      one.spec.sampler.mu = 0.3;
      one.spec.lattice.columns = one.spec.lattice.layers = size;
      one.samples = 64;
      one.draws_per_bead = law == Law::granusolve ? 1.4 : std::exp(size);
      costs.push_back(one);
    }
  }
  costs.back().failed = 5;
  const Figure figure = draw_law_cost(costs, run.path());
  CHECK(figure.data.size() == 2);
  CHECK(contains(figure.caption, "5 of 69 piles of 8 × 8 beads under eloy-clement at μ = 0.3"));
  CHECK(contains(figure.caption,
                 "Means of 64 piles. From 4 × 4 to 8 × 8 beads a bead takes: eloy-clement 54.6 to 403 at μ = "
                 "0.3 up to 6 × 6 beads; granusolve 1.40 to 1.40 at μ = 0.3."));
  CHECK(contains(read_file(run.path() / figure.screen), "eloy-clement, μ = 0.3"));
  CHECK_THROWS_AS(draw_law_cost({}, run.path()), InputError);
}
