// Source of the expected numbers: synthetic ensembles whose c and D are known in advance and depend on the load.
#include "studies/nonlinearity.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/synthetic_ensemble.h"
#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "model/lattice.h"
#include "plot/figure_texts.h"
#include "plot/synthetic_analysis.h"
#include "studies/study_page.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using synthetic::known;
using synthetic::unknown;
using test::contains;
using test::count;
using test::TemporaryFolder;

namespace {

constexpr int load_columns = 200;

FitSpec load_window() {
  return {.first_layer = 60, .last_layer = 120, .layer_step = 5, .shallow_layer = 60, .other_scaling_windows = {}};
}

/// D = 0.9 mu^2 (1 - drop), c = tan30 - 0.3 mu^2 + c_shift.
MeasuredEnsemble ensemble(double mu, EstimatorName estimator, double load, double drop, double c_shift,
                          double width_offset, std::uint64_t seed) {
  KnownTransport known;
  known.c = tan30 - 0.3 * mu * mu + c_shift;
  known.D = 0.9 * mu * mu * (1 - drop);
  known.width_offset = width_offset;
  SyntheticNoise noise;
  noise.per_sample = 0.05;
  noise.seed = seed;
  MeasuredEnsemble made = synthetic_ensemble(known, noise, load_columns, layers_to_record(load_window(), {}), 16, 64);
  made.spec.sampler.mu = mu;
  made.spec.response.estimator = estimator;
  made.spec.lattice = {load_columns, 141};
  const bool multiplexed = estimator == EstimatorName::multiplexed;
  made.spec.response.overload = multiplexed ? 1 : load;
  made.spec.response.epsilon = multiplexed ? load : 0;
  // The sums are those of a unit overload: w - 1 grows with the load.
  QuantitySums& weight = made.record.sums.quantities.at("weight");
  for (double& sum : weight.sum) sum = 64 + made.spec.response.overload * (sum - 64);
  return made;
}

LoadResponse response(double mu, const ResponseSpec& load_spec, bool reference) {
  const double load = load_size(load_spec);
  LoadResponse made;
  made.spec.sampler.mu = mu;
  made.spec.response = load_spec;
  made.reference = reference;
  made.samples = 4096;
  made.c = known(0.5748 - 0.001 * load, 0.00021);
  made.D = known(0.0061 - 0.001 * load, 0.00017);
  made.c_shift = reference ? known(0, 0) : known(-0.00012 * load, 0.00008);
  made.D_shift = reference ? known(0, 0) : known(-0.25 * load, 0.033);
  made.c_thrust = known(0.5748, 0.00001);
  made.c_thrust_shift = known(0.000012, 0.000011);
  return made;
}

LoadExponents exponents(const ResponseSpec& load_spec, bool reference) {
  const double load = load_size(load_spec);
  LoadExponents made;
  made.response = load_spec;
  made.reference = reference;
  made.window = {0.1, 0.3};
  made.points = 4;
  made.beta = known(2.3 + 0.2 * load, 0.06);
  made.gamma = known(1.8, 0.04);
  made.beta_shift = reference ? known(0, 0) : known(0.2 * load, 0.07);
  made.gamma_shift = reference ? known(0, 0) : known(-0.02 * load, 0.05);
  return made;
}

}  // namespace

TEST_CASE("c, D and the exponents of a load are compared with those of the linear response") {
  LoadComparer measurer(load_window(), 0.25, 2);
  std::uint64_t seed = 1;
  for (const double mu : {0.1, 0.2, 0.3}) {
    measurer.add(ensemble(mu, EstimatorName::multiplexed, 0.25, 0, 0, 0.25, seed++));
    measurer.add(ensemble(mu, EstimatorName::point, 1, 0.5 * (0.4 - mu), 0.01 * mu * mu, 0.25, seed++));
    MeasuredEnsemble uniform = ensemble(mu, EstimatorName::point, 1, 0, 0, 0.25, seed++);
    uniform.spec.load = Load::uniform;
    uniform.record.sums.quantities.erase("weight");
    measurer.add(uniform);
  }
  const LoadComparison measured = measurer.finish();
  REQUIRE(measured.responses.size() == 9);
  for (std::size_t k = 0; k < 3; ++k) {
    const double mu = 0.1 * static_cast<double>(k + 1);
    const LoadResponse &linear = measured.responses[3 * k], &point = measured.responses[3 * k + 1],
                       &uniform = measured.responses[3 * k + 2];
    INFO("mu " << mu);
    CHECK(linear.reference);
    CHECK(linear.load() == 0.25);
    CHECK(linear.D_shift.value == 0);
    CHECK(linear.D_shift.standard_error == 0);
    CHECK_FALSE(point.reference);
    CHECK(std::abs(linear.c.value - (tan30 - 0.3 * mu * mu)) < 5 * linear.c.standard_error);
    CHECK(std::abs(point.D_shift.value + 0.5 * (0.4 - mu)) < 5 * point.D_shift.standard_error);
    CHECK(std::abs(point.c_shift.value - 0.01 * mu * mu) < 5 * point.c_shift.standard_error);
    CHECK(point.D_shift.standard_error < 0.2);
    CHECK(point.samples == 1024);
    CHECK(uniform.uniform());
    CHECK_FALSE(uniform.D.known());
    CHECK_THAT(uniform.D_shift.reason, Catch::Contains("no response"));
    CHECK(uniform.c_thrust.value == Approx(tan30 * std::sqrt(0.93)).epsilon(1e-4));
    CHECK(std::abs(point.c_thrust_shift.value) < 5 * point.c_thrust_shift.standard_error);
  }
  REQUIRE(measured.exponents.size() == 2);
  const LoadExponents &linear = measured.exponents[0], &point = measured.exponents[1];
  CHECK(linear.reference);
  CHECK(linear.points == 3);
  CHECK(std::abs(linear.beta.value - 2) < 5 * linear.beta.standard_error);
  CHECK(std::abs(linear.gamma.value - 2) < 5 * linear.gamma.standard_error);
  CHECK(linear.beta_shift.value == 0);
  CHECK(point.beta_shift.value == Approx(point.beta.value - linear.beta.value));
  // Less of D is lost at large mu: 0.15, 0.1 and 0.05 of it.
  const double truth = std::log(0.95 / 0.85) / std::log(3.0);
  CHECK(std::abs(point.beta_shift.value - truth) < 4 * point.beta_shift.standard_error);
  CHECK(point.beta_shift.value > 3 * point.beta_shift.standard_error);
}

TEST_CASE("loads that can be fitted nearly as far up share a window, one that cannot keeps a shorter one of its own",
          "[unsanitized]") {
  LoadComparer measurer(load_window(), 0.25, 1);
  for (const double mu : {0.1, 0.2, 0.25, 0.3}) {
    const double D = 0.9 * mu * mu;
    const auto reaches_half_a_bead_at = [&](int layer) { return 0.25 - D * Lattice::depth(layer); };
    measurer.add(ensemble(mu, EstimatorName::multiplexed, 0.25, 0, 0, 0.4, 5));
    // W^2 reaches the least identifiable 0.25 a little below the top of the window, or in the middle of it; at mu = 0.1
    // nowhere.
    measurer.add(ensemble(mu, EstimatorName::point, 1, 0, 0, mu == 0.1 ? 0.4 : reaches_half_a_bead_at(68), 6));
    measurer.add(ensemble(mu, EstimatorName::point, 4, mu == 0.1 ? 1 - 1e-6 : 0.1, 0.002 * mu * mu,
                          mu == 0.1 ? 0.02 : reaches_half_a_bead_at(90), 7));
  }
  const LoadComparison measured = measurer.finish();
  REQUIRE(measured.responses.size() == 12);
  const auto at = [&](std::size_t mu, std::size_t load) -> const LoadResponse& {
    return measured.responses[3 * mu + load];
  };
  CHECK_FALSE(at(0, 2).D.known());
  CHECK_FALSE(at(0, 2).D_shift.known());
  CHECK_FALSE(at(0, 2).D_shift.reason.empty());
  CHECK_FALSE(at(0, 2).own_window);
  CHECK(at(0, 0).first_layer == 60);
  for (std::size_t mu = 1; mu < 4; ++mu) {
    INFO("mu " << at(mu, 0).spec.sampler.mu);
    CHECK(at(mu, 0).first_layer > 60);
    CHECK(at(mu, 0).first_layer < 80);
    CHECK(at(mu, 1).first_layer == at(mu, 0).first_layer);
    CHECK_FALSE(at(mu, 0).own_window);
    CHECK_FALSE(at(mu, 1).own_window);
    const LoadResponse& large = at(mu, 2);
    CHECK(large.own_window);
    CHECK(large.first_layer > 80);
    CHECK(large.D_shift.known());
    CHECK(std::abs(large.D_shift.value + 0.1) < 5 * large.D_shift.standard_error);
    CHECK(std::abs(large.c_shift.value - 0.002 * large.spec.sampler.mu * large.spec.sampler.mu) <
          5 * large.c_shift.standard_error);
    // Held against the linear response over the same layers, not over those of the others.
    CHECK(large.D_shift.value != large.D.value / at(mu, 0).D.value - 1);
  }
  REQUIRE(measured.exponents.size() == 3);
  CHECK(measured.exponents[0].points == 4);
  CHECK(measured.exponents[1].points == 4);
  CHECK(measured.exponents[2].points == 3);
  CHECK(measured.exponents[2].window == std::array{0.2, 0.3});
  CHECK(measured.exponents[2].beta_shift.known());
}

TEST_CASE("without a linear response, or without piles, nothing is compared, and the reasons are told") {
  LoadComparer measurer(load_window(), 0.25, 1);
  MeasuredEnsemble empty = ensemble(0.2, EstimatorName::point, 1, 0, 0, 0.4, 1);
  empty.record.sums.count.back() = 0;
  measurer.add(ensemble(0.2, EstimatorName::point, 0.5, 0, 0, 0.4, 1));
  measurer.add(empty);
  const LoadComparison measured = measurer.finish();
  REQUIRE(measured.responses.size() == 2);
  CHECK(measured.responses[0].D.known());
  CHECK_THAT(measured.responses[0].D_shift.reason, Catch::Contains("linear response is unknown"));
  CHECK_THAT(measured.responses[1].D.reason, Catch::Contains("no completed pile"));
  CHECK_THAT(measured.exponents[0].beta.reason, Catch::Contains("an exponent needs 3"));
  CHECK(LoadComparer(load_window(), 0.25, 1).finish().responses.empty());
}

TEST_CASE("The loads are plotted against the linear response, and what cannot be compared is left out") {
  const TemporaryFolder run;
  LoadComparison measured;
  for (const double mu : {0.1, 0.3}) {
    for (const double load : {0.1, 0.25, 0.5, 1.0, 4.0}) {
      LoadResponse one;
      one.spec.sampler.mu = mu;
      one.spec.response = load < 0.6 ? multiplexed_response(load) : ResponseSpec{.overload = load};
      one.reference = load == 0.25;
      one.samples = 256;
      one.D_shift = synthetic::known(-0.25 * load, 0.03);
      one.c_shift = synthetic::known(0.001 * mu * load, 0.0001);
      one.c = synthetic::known(0.57, 0.001);
      one.D = synthetic::known(0.03, 0.001);
      if (load == 4 && mu == 0.1) one.D_shift = one.c_shift = synthetic::unknown("too narrow");
      measured.responses.push_back(one);
    }
    LoadResponse uniform;
    uniform.spec.sampler.mu = mu;
    uniform.spec.load = Load::uniform;
    uniform.D_shift = uniform.c_shift = synthetic::unknown("no response");
    measured.responses.push_back(uniform);
  }
  const Figure figure = plot_load_comparison(measured, "nonlinearity", run.path());
  check_at_widths_of_journals(run / "figures", figure.id);
  CHECK(figure.data.size() == 4);
  CHECK(contains(figure.details, "varied by ±0.25 of"));
  CHECK(contains(figure.details, "−25.0(3.0) % at μ = 0.1 and −25.0(3.0) % at μ = 0.3"));
  CHECK_FALSE(contains(figure.details, " ."));
  const std::string svg = read_file(run.path() / figure.screen);
  for (const char* label : {"size of the load", "all loads ±ε", "μ = 0.3"}) CHECK(contains(svg, label));
  const std::string points = read_file(run.path() / "figures/nonlinearity-point-mu-0.1.csv");
  CHECK(std::count(points.begin(), points.end(), '\n') == 3);  // names, units and the overload 1
  CHECK_THROWS_AS(plot_load_comparison({}, "nonlinearity", run.path()), InputError);
}

TEST_CASE("Loads are compared with the linear response, and what cannot be is named once") {
  LoadComparison measured;
  for (const double mu : {0.1, 0.3}) {
    measured.responses.push_back(response(mu, multiplexed_response(0.25), true));
    measured.responses.push_back(response(mu, ResponseSpec{.overload = 1}, false));
    measured.responses.push_back(response(mu, ResponseSpec{.overload = 4}, false));
    LoadResponse& strong = measured.responses.back();
    strong.c = strong.D = strong.c_shift = strong.D_shift = unknown("the peaks are too narrow");
    measured.responses.push_back(response(mu, ResponseSpec{.overload = 0}, false));
    measured.responses.back().spec.load = Load::uniform;
  }
  measured.exponents = {exponents(multiplexed_response(0.25), true), exponents(ResponseSpec{.overload = 1}, false),
                        exponents(ResponseSpec{.overload = 4}, false)};
  LoadExponents& few = measured.exponents.back();
  few.beta = few.gamma = few.beta_shift = few.gamma_shift = unknown("two friction coefficients are too few");
  const Page page = study_page(*nonlinearity_study(measured));
  const std::string table = table_of(page.html, "loads");
  CHECK(count(table, "<tr class=\"first\"") == 3);  // each friction coefficient, and the exponents
  CHECK(count(table, "one bead ") == 6);
  CHECK(count(table, "<tbody>") == 3);
  CHECK(count(table, ", linear") == 3);
  CHECK(page.texts.at("/studies/nonlinearity/responses/1/D_over_linear_minus_1") == "−0.250(33)");
  CHECK(page.texts.at("/studies/nonlinearity/responses/1/c_minus_linear") == "−0.000120(80)");
  CHECK(page.texts.at("/studies/nonlinearity/responses/1/c_thrust_minus_uniform") == "0.000012(11)");
  CHECK(page.texts.at("/studies/nonlinearity/exponents/1/beta_minus_linear") == "0.200(70)");
  CHECK_FALSE(page.texts.contains("/studies/nonlinearity/responses/0/c_minus_linear"));
  CHECK_FALSE(page.texts.contains("/studies/nonlinearity/responses/0/D_over_linear_minus_1"));   // the reference itself
  CHECK_FALSE(page.texts.contains("/studies/nonlinearity/responses/3/c_thrust_minus_uniform"));  // nor the uniform load
  CHECK(contains(page.html, "What the finite overload of the paper’s procedure does"));
  CHECK(count(page.html, "the peaks are too narrow") == 1);
  CHECK(contains(page.html, "No comparison for overload 4 at μ = 0.1 and 0.3: "));
  CHECK(contains(page.html, "No comparison for the exponents with overload 4: "));

  // Without the paper's overload there is no sentence about it.
  for (LoadResponse& one : measured.responses) {
    if (one.load() == 1) one.spec.response.overload = 2;
  }
  measured.exponents.resize(1);
  CHECK_FALSE(contains(study_page(*nonlinearity_study(measured)).html, "What the finite overload"));
  CHECK(table_of(study_page(*nonlinearity_study()).html, "loads").empty());
}
