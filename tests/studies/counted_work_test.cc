#include "studies/counted_work.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/claims.h"
#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/figure_texts.h"
#include "studies/made_up_ensemble.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using namespace granuscope::made_up;
using granuscope::test::contains;
using granuscope::test::TemporaryFolder;

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

TEST_CASE("Counted work is drawn per bead and names what was not completed") {
  const TemporaryFolder run;
  std::vector<CountedWork> work;
  for (const double mu : {0.1, 1.7}) {
    for (const int size : {100, 200, 400}) {
      CountedWork one;
      one.spec.sampler.mu = mu;
      one.spec.lattice.columns = one.spec.lattice.layers = size;
      one.samples = 64;
      one.draws_per_bead = 1 + 2 * mu + 0.0005 * size;
      work.push_back(one);
    }
  }
  work.back().failed = 3;
  const Figure figure = plot_counted_work(work, run.path());
  check_at_widths_of_journals(run / "figures", figure.id);
  CHECK(figure.data.size() == 2);
  CHECK(contains(figure.details, "by a factor of 1.12"));  // 1.4 / 1.25
  CHECK(contains(figure.details, "means of 64 piles"));
  CHECK(contains(figure.details, "3 of 67 piles of 400 × 400 beads at μ = 1.7"));
  const std::string svg = read_file(run.path() / figure.screen);
  CHECK(contains(svg, "draws per bead"));
  CHECK(contains(svg, "μ = 1.7"));
  CHECK_THROWS_AS(plot_counted_work({}, run.path()), InputError);

  // Without friction nothing is drawn, whatever the size.
  for (CountedWork& one : work) {
    EnsembleSpec without_friction;
    without_friction.sampler.mu = 0;
    without_friction.lattice = one.spec.lattice;
    one = {.spec = without_friction, .samples = 64};
  }
  work.resize(3);
  CHECK(contains(read_file(run.path() / plot_counted_work(work, run.path()).screen), "μ = 0"));
}
