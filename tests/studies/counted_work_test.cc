#include "studies/work_studies.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/claims.h"
#include "studies/made_up_ensemble.h"

using namespace granuscope;
using namespace granuscope::made_up;

TEST_CASE("Counted work divides the counts by the beads that were completed") {
  MeasuredEnsemble ensemble = ensemble_of(0.3, {10, 30}, {5});
  ensemble.record.counts.beads = 1000;
  ensemble.record.counts.uniforms = 1500;
  ensemble.record.counts.repaired_by_pair = 100;
  ensemble.record.counts.repaired_by_arc = 20;
  ensemble.record.counts.repaired_by_ring = 3;
  ensemble.record.counts.backtracked = 7;
  ensemble.record.failed.push_back({3, 4, ""});
  const CountedWork work = counted_work(ensemble);
  CHECK(work.samples == 256);
  CHECK(work.failed == 1);
  CHECK(work.draws_per_bead == 1.5);
  CHECK(work.repaired_per_bead == 0.123);
  CHECK(work.backtracked_per_bead == 0.007);
  ensemble.record.counts = {};
  CHECK_FALSE(std::isfinite(counted_work(ensemble).draws_per_bead));
}

TEST_CASE("Work is linear if draws per bead do not grow and the largest piles are completed") {
  std::vector<CountedWork> measured;
  for (const double mu : {0.3, 1.7}) {
    for (const int size : {125, 250, 500, 1000}) {
      CountedWork work;
      work.spec.sampler.mu = mu;
      work.spec.lattice.columns = work.spec.lattice.layers = size;
      work.samples = 64;
      work.draws_per_bead = 1.4 + mu + 0.001 * (size % 3);
      measured.push_back(work);
    }
  }
  CHECK(judge_linear_time(measured, {}).verdict == reproduced);
  std::vector<CountedWork> failing = measured;
  failing.back().failed = 1;
  CHECK(judge_linear_time(failing, {}).verdict == not_reproduced);
  std::vector<CountedWork> growing = measured;
  for (CountedWork& work : growing) {
    if (work.spec.sampler.mu == 0.3)
      work.draws_per_bead *= std::pow(work.spec.lattice.columns * work.spec.lattice.layers, 0.08);
  }
  const Claim worse = judge_linear_time(growing, {});
  CHECK(worse.verdict == not_reproduced);
  CHECK(worse.measured.value == Approx(1.08).margin(0.001));
  std::vector<CountedWork> small = measured;
  small.pop_back();
  CHECK(judge_linear_time(small, {}).verdict == not_tested);
  std::vector<CountedWork> single = measured;
  single = {measured.back()};
  CHECK(judge_linear_time(single, {}).verdict == not_tested);
}
