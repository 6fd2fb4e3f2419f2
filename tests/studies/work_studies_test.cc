#include "studies/work_studies.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/claims.h"
#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/figure_texts.h"
#include "plot/synthetic_analysis.h"
#include "studies/made_up_ensemble.h"
#include "support/error.h"
#include "support/files.h"

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

using test::contains;
using test::TemporaryFolder;

namespace {

/// Scatter that falls exactly as samples^(-1/2), from what one sample scatters.
ErrorCurve curve(EstimatorName estimator, double epsilon, double one_c, double one_D) {
  ErrorCurve made;
  made.spec.response.estimator = estimator;
  made.spec.sampler.mu = 0.3;
  made.spec.lattice.columns = 256;
  made.spec.lattice.layers = 120;
  made.spec.response.epsilon = epsilon;
  made.samples = 1600;
  made.beads = 1600ULL * 256 * 120;
  for (const std::uint64_t samples : {25ULL, 100ULL}) {
    const double root = std::sqrt(static_cast<double>(samples));
    made.points.push_back({samples, 16, one_c / root, one_D / root});
  }
  made.c = synthetic::known(0.56, 0.001);
  made.D = synthetic::known(0.07, 0.002);
  made.shift_c = made.shift_D = synthetic::known(0, 0.001);
  made.slope_c = made.slope_D = synthetic::known(-0.5, 0.1);
  return made;
}

/// Without any load, in deeper piles.
ErrorCurve unloaded_curve() {
  ErrorCurve made = curve(EstimatorName::fluctuation, 0, 0.004, 0.005);
  made.spec.lattice.layers = 480;
  made.beads = 1600ULL * 256 * 480;
  return made;
}

/// The paper's procedure, the standard one without any fit, and a multiplexed one of a twentieth of the scatter.
std::vector<ErrorCurve> three_curves() {
  std::vector<ErrorCurve> curves = {curve(EstimatorName::point, 0, 0.04, 0.2),
                                    curve(EstimatorName::paired, 0, 0.03, 0.1),
                                    curve(EstimatorName::multiplexed, 0.25, 0.002, 0.02)};
  curves[0].shift_c = synthetic::known(0.004, 0.001);    // four standard errors
  curves[0].shift_D = synthetic::known(-0.002, 0.0008);  // two and a half
  curves[1].points.clear();
  return curves;
}

}  // namespace

TEST_CASE("Errors against time compare with the paper's procedure, number what is shown, and name what is not") {
  const TemporaryFolder run;
  const Figure figure = plot_error_against_time(three_curves(), run.path());
  check_at_widths_of_journals(run / "figures", figure.id);
  // (0.04 / 0.002)^2 and (0.2 / 0.02)^2, each of as many beads for each sample.
  CHECK(contains(figure.details, "the factors 400 for c and 100 for D (multiplexed, ε = 0.25), each known to about "));
  CHECK(contains(figure.details, "something else: point (c by 0.0040(10))."));  // and not D
  CHECK(contains(figure.details, "no fit of two peaks: paired"));
  CHECK(contains(figure.details, "against the number of beads drawn"));
  CHECK_FALSE(contains(figure.details, "e+"));
  CHECK(contains(figure.alternative, "level off"));
  // The curve that is not shown has no number, so that the data follow the legend.
  CHECK(figure.data.size() == 4);
  CHECK(std::filesystem::exists(run.path() / "figures/error-against-time-c-2.csv"));
  CHECK_FALSE(std::filesystem::exists(run.path() / "figures/error-against-time-c-3.csv"));
  const std::string points = read_file(run.path() / "figures/error-against-time-D-2.csv");
  CHECK(std::count(points.begin(), points.end(), '\n') == 4);
  CHECK(contains(points, "\n0.768,0.004,"));  // 25 samples of 256 x 120 beads, 0.02 / 5
  CHECK(contains(points, ",25,16\n"));
  // With the shift of c the total error levels off at 0.004, and only there.
  const std::string script = read_file(run.path() / "figures/error-against-time.gp");
  CHECK(contains(script, " + 1.6e-05)) with lines"));
  const std::string levels = " + 0)) with lines";
  int straight = 0;
  for (std::size_t at = script.find(levels); at != std::string::npos; at = script.find(levels, at + 1)) ++straight;
  CHECK(straight == 3);
  const std::string svg = read_file(run.path() / figure.screen);
  for (const char* label : {"million beads drawn", "standard error of D", "multiplexed, ε = 0.25"}) {
    INFO(label);
    CHECK(contains(svg, label));
  }
}

TEST_CASE("Errors of fluctuations stand beside those of loads, counted in the beads of their deeper piles") {
  const TemporaryFolder run;
  std::vector<ErrorCurve> curves = three_curves();
  curves.push_back(unloaded_curve());
  const Figure figure = plot_error_against_time(curves, run.path());
  check_at_widths_of_journals(run / "figures", figure.id);
  // (0.04 / 0.004)^2 and (0.2 / 0.005)^2, each of four times as many beads for each sample.
  CHECK(contains(figure.details, "25 for c and 400 for D (fluctuation"));
  CHECK(contains(figure.details, "(fluctuation, over the same depths: 480 layers)"));
  CHECK(figure.data.size() == 6);
  const std::string points = read_file(run.path() / "figures/error-against-time-D-3.csv");
  CHECK(contains(points, "\n3.072,0.001,"));  // 25 samples of 256 x 480 beads, 0.005 / 5
  CHECK(contains(read_file(run.path() / figure.screen), "fluctuation"));
}

TEST_CASE("The coupled form of the paper's procedure is held against the literal one, wherever it stands") {
  const TemporaryFolder run;
  std::vector<ErrorCurve> curves = three_curves();
  curves[1] = curve(EstimatorName::point, 0, 0.01, 0.1);
  curves[1].spec.response.coupled = true;
  const Figure figure = plot_error_against_time(curves, run.path());
  CHECK(contains(figure.details, "16 for c and 4 for D (point, coupled) and 400 for c and 100 for D (multiplexed"));
  CHECK(contains(read_file(run.path() / figure.screen), "point, coupled"));
}

TEST_CASE("Errors are measured of the literal form, whatever the main line takes") {
  const auto study = error_against_time_study();
  for (const Key& key : study->keys()) {
    if (key.name == "repetitions") key.set(std::int64_t{8});
  }
  MainLine main;
  main.response = {.overload = 0.5, .overloads = 0, .coupled = true};
  const auto ensembles = study->ensembles(main);
  REQUIRE(ensembles.size() == 8);
  CHECK(configuration_text(ensembles[0].spec) == configuration_text(study->ensembles(MainLine{})[0].spec));
  CHECK(ensembles[0].spec.response.overload == 1);
  for (const StudyEnsemble& one : ensembles) {
    CHECK(moves_loads(one.spec) == (one.file == "error-point-coupled"));
    CHECK(one.spec.response.blocks == 8 * repetition_blocks);
    CHECK(one.spec.response.samples % (8 * repetition_blocks * group_size) == 0);
  }
}

TEST_CASE("Without shifts no error against beads levels off") {
  const TemporaryFolder run;
  std::vector<ErrorCurve> curves = three_curves();
  curves[0].shift_c = synthetic::unknown("nothing stands for the linear response");
  const Figure figure = plot_error_against_time(curves, run.path());
  check_at_widths_of_journals(run / "figures", figure.id);
  CHECK(contains(figure.details, "No shift from it exceeds three standard errors"));
  CHECK_FALSE(contains(figure.alternative, "level off"));
}

TEST_CASE("Errors against time without any curve are refused") {
  const TemporaryFolder run;
  std::vector<ErrorCurve> curves = three_curves();
  for (ErrorCurve& one : curves) one.points.clear();
  CHECK_THROWS_AS(plot_error_against_time(curves, run.path()), InputError);
}
