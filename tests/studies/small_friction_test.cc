#include "studies/small_friction.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "ensemble/ensemble_runner.h"
#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "model/lattice.h"
#include "plot/figure_texts.h"
#include "plot/synthetic_analysis.h"
#include "studies/made_up_ensemble.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using namespace granuscope::made_up;
using granuscope::test::contains;
using granuscope::test::TemporaryFolder;

namespace {

/// Made-up piles at small friction: variance 1 - exp(-n/saturation), deficit of the thrust ratio proportional to mu^2.
SmallFriction small_friction(double mu) {
  SmallFriction made;
  made.spec.sampler.mu = mu;
  made.spec.lattice.columns = 32;
  made.spec.lattice.layers = static_cast<int>(2.4 / (mu * mu));
  made.samples = 256;
  made.depth_over_saturation = 4;
  made.first_layer = made.spec.lattice.layers / 2;
  made.last_layer = made.spec.lattice.layers - 21;
  const double saturation = made.spec.lattice.layers / 4.0, deficit = 0.5 * mu * mu;
  for (int layer = 0; layer <= made.last_layer; layer += 1 + layer / 8) {
    ThrustAtDepth depth;
    depth.layer = layer;
    depth.z = Lattice::depth(layer);
    depth.thrust_ratio = synthetic::known(1 - deficit, 0.02 * deficit);
    depth.weight_variance = synthetic::known(0.1 * (1 - std::exp(-layer / saturation)), 0.002);
    made.depths.push_back(depth);
  }
  made.alpha_thrust = synthetic::known(1 - deficit, 0.01 * deficit);
  made.c_thrust = synthetic::known(tan30 * std::sqrt(1 - deficit), 0.003 * deficit);
  made.c0_minus_c = synthetic::known(tan30 - made.c_thrust.value, 0.003 * deficit);
  return made;
}

}  // namespace

TEST_CASE("The layers of a deep narrow pile are usable, ascending and of both row parities") {
  for (const int layers : {45, 260, 6020, 100'000}) {
    const std::vector<int> recorded = thrust_layers(layers);
    CAPTURE(layers);
    CHECK(std::is_sorted(recorded.begin(), recorded.end()));
    CHECK(recorded.back() == layers - bottom_margin - 1);
    CHECK(recorded.front() >= 0);
    CHECK(recorded.size() <= 1050);
    const auto odd = std::count_if(recorded.begin(), recorded.end(), [](int layer) { return layer % 2 == 1; });
    CHECK(std::abs(2.0 * static_cast<double>(odd) - static_cast<double>(recorded.size())) <=
          0.2 * static_cast<double>(recorded.size()) + 4);
  }
}

TEST_CASE("A thrust that falls as mu squared gives the exponent 2 within its error") {
  const std::vector<double> friction{0.02, 0.03, 0.05, 0.1};
  constexpr double prefactor = 0.25;  // c0 - c = 0.25 mu^2
  std::mt19937_64 random(7);
  std::vector<MeasuredSmallFriction> measured;
  for (const double mu : friction) {
    MeasuredEnsemble ensemble = ensemble_of(mu, {64, 400}, thrust_layers(400));
    const double c = tan30 - prefactor * mu * mu, alpha = c * c / (tan30 * tan30);
    std::normal_distribution<double> noise(0.0, 0.05 * (1 - alpha));
    add_quantity(ensemble.record.sums, "thrust", 1, [&](int, int, int) { return alpha + noise(random); });
    add_quantity(ensemble.record.sums, "weight_variance", 1, [](int, int, int) { return 0.15; });
    measured.push_back(measure_small_friction(ensemble));
    const SmallFriction& result = measured.back().result;
    CAPTURE(mu);
    CHECK(result.depth_over_saturation == Approx(400 * mu * mu / 0.6));
    CHECK(result.first_layer == 190);
    CHECK(result.last_layer == 379);
    CHECK(std::abs(result.c0_minus_c.value - prefactor * mu * mu) < 4 * result.c0_minus_c.standard_error);
    CHECK(result.c0_minus_c.standard_error < 0.01 * prefactor * mu * mu);
  }
  const ScalingFit fit = fit_small_friction(measured);
  REQUIRE(fit.exponent.known());
  CHECK(fit.points == 4);
  CHECK(fit.window == std::array<double, 2>{0.02, 0.1});
  CHECK(std::abs(fit.exponent.value - 2) < 4 * fit.exponent.standard_error);
  CHECK(fit.exponent.standard_error < 0.01);
}

// To leading order in mu the interval of the tangential forces is symmetric about 0, so that the mean thrust has no
// term linear in mu. The ratios x_p/z of the paper have c0 - c = 0.06 mu.
TEST_CASE("The thrust of saturated piles slows down with the square of friction, without a linear term",
          "[unsanitized]") {
  std::vector<Estimate> over_square;
  const std::vector<double> friction{0.03, 0.1};
  for (const double mu : friction) {
    EnsembleSpec spec =
        MainLine().ensemble_at(mu, {32, static_cast<int>(4 * saturation_layers(mu)) + bottom_margin}, 256);
    spec.load = Load::uniform;
    spec.layers = thrust_layers(spec.lattice.layers);
    spec.record_profiles = false;
    const Estimate slowing = measure_small_friction({spec, run_ensemble(spec, 0, nullptr)}).result.c0_minus_c;
    over_square.push_back({slowing.value / mu / mu, slowing.standard_error / mu / mu, ""});
    INFO(mu << ": " << over_square.back().value << " +- " << over_square.back().standard_error);
    CHECK(std::abs(over_square.back().value - 0.258) < 5 * over_square.back().standard_error);
  }
  // (c0 - c)/mu^2 = quadratic + linear/mu.
  const double lever = 1 / friction[0] - 1 / friction[1];
  const double linear = (over_square[0].value - over_square[1].value) / lever;
  const double error = std::hypot(over_square[0].standard_error, over_square[1].standard_error) / lever;
  CHECK(std::abs(linear) < 5 * error);
  CHECK(error < 0.06 / 100);
}

TEST_CASE("The peaks at small friction are measured where they are wide enough, with their exponents",
          "[unsanitized]") {
  const auto study = small_friction_study();
  for (const Key& key : study->keys()) {
    if (key.name == "peaks_mu") key.set(std::vector<double>{0.1, 0.15, 0.2});
  }
  const MainLine main;
  const auto ensembles = study->ensembles(main);
  REQUIRE(ensembles.size() == 3);
  for (const StudyEnsemble& one : ensembles) {
    CHECK(one.spec.response.estimator == EstimatorName::multiplexed);
    CHECK(one.spec.response.blocks == 8);
    CHECK(one.spec.lattice.columns > 2 * tan30 * Lattice::depth(one.spec.layers.back()));
  }
  study->begin(main, 0);
  for (const StudyEnsemble& one : ensembles) study->add(one, {one.spec, run_ensemble(one.spec, 0, nullptr)});
  study->finish();
  const auto json = study->json();
  REQUIRE(json["peaks"].size() == 3);
  const double D = json["peaks"][0]["D"]["value"], error = json["peaks"][0]["D"]["stderr"];
  CHECK(std::abs(D - 0.0061) < 5 * error);
  CHECK(error < 0.001);
  const OtherReading reading = study->readings().at(0);
  CHECK(reading.id == "small_friction");
  const Estimate& gamma = reading.fits.gamma.exponent;
  REQUIRE(gamma.known());
  CHECK(std::abs(gamma.value - 1.9) < 5 * gamma.standard_error);
}

TEST_CASE("Small friction shows saturation and the law that the deep piles follow") {
  const TemporaryFolder run;
  const Analysis analysis = synthetic::analysis();
  std::vector<SmallFriction> measured;
  for (const double mu : {0.03, 0.05, 0.1}) measured.push_back(small_friction(mu));
  ScalingFit scaling = synthetic::power_law(2.0, 0.01, std::log(0.25 * tan30), {0.03, 0.1});
  const Figure figure = plot_small_friction(analysis, measured, scaling, run.path());
  check_at_widths_of_journals(run / "figures", figure.id);
  CHECK(figure.redraw == "cd figures && gnuplot -d small-friction.gp");
  CHECK(contains(figure.details, "exponent 2.000(10) fitted over μ = 0.03 to 0.1"));
  CHECK(contains(figure.details, "32 columns, at least 4 times"));
  CHECK_FALSE(contains(figure.details, " ."));
  const std::string svg = read_file(run.path() / figure.screen);
  for (const char* label : {"layer  in units of 0.6/μ²", "narrow deep piles: 2.000(10)", "the main piles"}) {
    INFO(label);
    CHECK(contains(svg, label));
  }
  CHECK(std::filesystem::exists(run.path() / "figures/small-friction-mu-0.03.csv"));
  CHECK(std::filesystem::exists(run.path() / "figures/small-friction-slowing-narrow-piles-over-law.csv"));
  scaling = {};
  scaling.exponent = synthetic::unknown("only two points");
  CHECK(contains(plot_small_friction(analysis, measured, scaling, run.path()).details, "unknown: only two points"));
  CHECK_THROWS_AS(plot_small_friction(synthetic::analysis(), {}, {}, run.path()), InputError);
}
