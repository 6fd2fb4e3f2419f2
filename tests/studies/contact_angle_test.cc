// The study of contacts at other angles.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>

#include "analysis/synthetic_ensemble.h"
#include "kit/temporary_folder.h"
#include "plot/figure_texts.h"
#include "studies/study.h"
#include "studies/study_page.h"

namespace granuscope {

std::unique_ptr<Study> contact_angle_study();  // NOLINT(readability-redundant-declaration)

namespace {

std::unique_ptr<Study> study_of(const std::vector<double>& angles, const std::vector<double>& mu) {
  auto study = contact_angle_study();
  for (const Key& key : study->keys()) {
    if (key.name == "angles") key.set(angles);
    if (key.name == "mu") key.set(mu);
  }
  return study;
}

}  // namespace

// Source of the expected numbers: the same response in columns and layers, read on lattices of two angles.
TEST_CASE("The study of angles tells c over c0 and D in bead diameters") {
  const auto study = study_of({30, 45, 60}, {0.1, 0.3});
  const MainLine main;
  study->begin(main, 1);
  const KnownTransport known;
  for (const StudyEnsemble& one : study->ensembles(main)) {
    CHECK(one.spec.response.estimator == EstimatorName::multiplexed);
    MeasuredEnsemble made = synthetic_ensemble(known, {1e-6, 1}, one.spec.lattice.columns, one.spec.layers, 32, 8);
    made.spec.lattice = one.spec.lattice;
    made.record.sums.rows = rows_of({}, one.spec.lattice.angle);
    study->add(one, made);
  }
  const auto rows = study->json();
  REQUIRE(rows.size() == 6);
  for (const auto& row : rows) {
    INFO(row.dump());
    const double angle = row["angle"].get<double>() * std::numbers::pi / 180, mu = row["mu"];
    const double small = mu / std::sin(2 * angle), share = known.c / tan30, of_layer = known.D * sqrt3 / 2;
    CHECK(row["c0"].get<double>() == Approx(std::tan(angle)));
    CHECK(row["c_over_c0"]["value"].get<double>() == Approx(share).epsilon(1e-5));
    CHECK(row["slowing"]["value"].get<double>() == Approx((1 - share) / mu / mu).epsilon(1e-3));
    CHECK(row["widening"]["value"].get<double>() == Approx(of_layer / small / small).epsilon(1e-3));
    CHECK(row["D"]["value"].get<double>() ==
          Approx(of_layer * std::pow(2 * std::sin(angle), 2) / std::cos(angle)).epsilon(1e-3));
  }
  CHECK(study_page(*study).texts.contains("/studies/contact_angle/0/D"));
  const test::TemporaryFolder run;
  const Figure figure = study->figures({}).at(0)(run.path());
  CHECK(figure.failure.empty());
  check_at_widths_of_journals(run / "figures", figure.id);
}

TEST_CASE("Angles are measured where beads have such friction, and refused where they never have") {
  const MainLine main;
  CHECK(study_of({30, 60}, {0.3, 0.7})->ensembles(main).size() == 3);  // at 60 degrees below 1/sqrt 3
  CHECK(study_of({60}, {0.7})->find_problem(main));
  CHECK_FALSE(study_of({30, 60}, {0.3, 0.7})->find_problem(main));
}

}  // namespace granuscope
