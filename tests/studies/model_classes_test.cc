// Source of the expected numbers: what is known exactly of the models, and made-up responses.
#include "studies/model_classes/results.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <limits>

#include "ensemble/ensemble_runner.h"
#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/figure_texts.h"
#include "plot/synthetic_analysis.h"
#include "studies/spreading.h"
#include "studies/study_page.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using synthetic::known;
using synthetic::unknown;
using test::contains;
using test::TemporaryFolder;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

MeasuredModel measured(const ModelSpec& model, std::uint64_t samples, const FitSpec& fit) {
  EnsembleSpec spec;
  spec.sampler.model = model;
  spec.lattice = {128, fit.last_layer + bottom_margin + 1};
  spec.response = multiplexed_response(0.2);
  spec.response.samples = samples;
  spec.response.blocks = 16;
  spec.layers = layers_to_record(fit, {});
  return measure_model({spec, run_ensemble(spec, 1, nullptr)}, fit, "series", "parameter", 1);
}

FitSpec window(int first, int last, int step) {
  FitSpec fit;
  fit.first_layer = fit.shallow_layer = first;
  fit.last_layer = last;
  fit.layer_step = step;
  return fit;
}

ModelResponse response(const std::string& series, double D, double slowing) {
  ModelResponse made;
  made.series = series;
  made.parameter = "Δ = 0.2";
  made.model = series;
  made.samples = 512;
  made.peaks = 2;
  made.D = known(D, 0.01 * D);
  made.c = known(0.577 - slowing, 0.01 * slowing);
  made.slowing = known(slowing, 0.01 * slowing);
  made.c_thrust = made.c;
  made.width_exponent = known(1.02, 0.03);
  made.c_expected = made.D_expected = nan;
  made.middle = unknown("no leg");
  made.c_of_middle = made.traction = made.share_of_mean = made.middle;
  made.verdict = "hyperbolic with noise";
  ResponseProfile profile;
  profile.z = 50;
  for (int x = -40; x <= 40; ++x) {
    profile.x.push_back(x);
    profile.pressure.push_back(std::exp(-std::pow((std::abs(x) - 28) / 4.0, 2)) / 14);
    profile.standard_error.push_back(0.001);
  }
  made.profile = profile;
  return made;
}

}  // namespace

TEST_CASE("the free three-leg model travels and spreads as its mean share says") {
  ModelSpec model;
  model.name = ModelName::three_leg;
  model.three_leg.middle = 0.3;
  model.three_leg.noise = 0.1;
  const ModelResponse found = measured(model, 2048, window(12, 32, 3)).response;
  REQUIRE(found.c.known());
  CHECK(found.c_expected == Approx(std::sqrt(0.7 / 3)));
  CHECK(found.D_expected == Approx(0.3 / (2 * std::sqrt(3.0))));
  // The peaks are not quite Gaussian: 10^-3 of c, and 2 % of D.
  CHECK(std::abs(found.c.value - found.c_expected) < 5 * found.c.standard_error + 1e-3);
  CHECK(std::abs(found.D.value - found.D_expected) < 5 * found.D.standard_error + 0.02 * found.D_expected);
  CHECK(found.D.standard_error < 0.05 * found.D_expected);
  CHECK(found.c_thrust.value == Approx(found.c_expected).margin(1e-4));
  CHECK(found.middle.value == Approx(0.3).margin(1e-3));
  CHECK(found.share_of_mean.value == Approx(1).margin(0.02));
  CHECK(found.peaks == 2);
  CHECK(found.shape == ResponseShape::two_gaussians);
}

TEST_CASE("the q-model has one peak that spreads by half a bead a row") {
  ModelSpec model;
  model.name = ModelName::q_model;
  model.q_model.split = SplitLaw::beta;
  const ModelResponse found = measured(model, 8192, window(20, 62, 14)).response;
  CHECK(found.peaks == 1);
  CHECK(found.shape == ResponseShape::one_gaussian);
  CHECK_FALSE(found.c.known());
  REQUIRE(found.D.known());
  CHECK(found.D.standard_error < 0.05 * found.D_expected);
  CHECK(std::abs(found.D.value - 0.5 / std::sqrt(3.0)) < 5 * found.D.standard_error);
  CHECK(found.c_thrust.value == 0);
}

TEST_CASE("the theory of noise has the limits of the wave-number dependent one, and nothing for independent rows") {
  ModelSpec model;
  model.name = ModelName::stochastic_osl;
  for (const auto& [columns, rows] : {std::pair{4, 4}, {2, 8}, {6, 1}}) {
    model.stochastic_osl = {.disorder = 0.1, .cell_columns = columns, .cell_rows = rows, .grid = 1};
    const NoiseTheory theory = noise_theory(model);
    // Q(k) of results.h by the midpoint rule.
    const auto Q = [columns = columns, rows = rows](double k) {
      const double width = columns, reach = rows / 2.0, end = std::min(width, reach);  // tan 30 times sqrt(3)/2 = 1/2
      std::complex<double> sum = 0;
      constexpr int steps = 20'000;
      for (int step = 0; step < steps; ++step) {
        const double u = (step + 0.5) * end / steps, g_z = 1 - u / reach, g = 1 - u / width, slope = -1 / width;
        const std::complex<double> ik(0, k);
        sum += g_z * ((slope + ik * g) * std::exp(2.0 * ik * u) + slope - ik * g) * end / double{steps};
      }
      return sum / 2.0;
    };
    CHECK(theory.wide.kappa == Approx(-Q(1e-4).real()).epsilon(1e-5));
    CHECK(theory.wide.spreading == Approx(-theory.c0 * Q(1e-4).imag() / 1e-4).epsilon(1e-4));
    const double k = 400;
    CHECK(theory.narrow->kappa == Approx(-Q(k).real()).margin(0.01));
    CHECK(theory.narrow->spreading == Approx(-theory.c0 * Q(k).imag() / k).margin(0.01));
    CHECK(theory.c(columns - 0.1) == Approx(theory.c0 * std::sqrt(1 - theory.narrow->kappa * 0.01)));
    CHECK(theory.D(columns + 0.1) == Approx(theory.wide.spreading * 0.01));
  }
  model.name = ModelName::three_leg;
  model.three_leg.cell_columns = 4;
  CHECK(noise_theory(model).wide.kappa == 0);
  model.three_leg.cell_rows = 2;
  // One row back: of the share beyond p, p stays in the middle and the outer halves come back by 0; beside it
  // -(1/2)(p + ...) lands where noise is alike with 1 - |x|/4. By hand, for p = 0.1: weight 1 at 0 and -1/2 at +-1.
  const double q = 0.5 * (1 - 2 * 0.5 * 0.75);
  CHECK(noise_theory(model).wide.kappa == Approx(0.9 * q));
  CHECK(noise_theory(model).wide.spreading == Approx(1.5 * q * 0.81 / std::sqrt(3.0)));
  model.name = ModelName::q_model;
  CHECK_THROWS_AS(noise_theory(model), std::logic_error);
}

TEST_CASE("noise in cells slows long waves as its theory says, in both models", "[unsanitized]") {
  ModelSpec model;
  model.name = ModelName::three_leg;
  model.three_leg = {.middle = 0.3, .noise = 0.2, .cell_columns = 4, .cell_rows = 4};
  // To the next order, Delta^4: a tenth of what is measured.
  const auto check = [](const ModelResponse& found) {
    REQUIRE(found.theory);
    const double squared = found.theory->disorder * found.theory->disorder, loss = found.theory->wide.kappa * squared;
    REQUIRE(found.thrust_loss.known());
    CAPTURE(found.thrust_loss.value, found.thrust_loss.standard_error, loss);
    CHECK(std::abs(found.thrust_loss.value - loss) < 5 * found.thrust_loss.standard_error + 0.1 * loss);
    CHECK(found.thrust_loss.standard_error < 0.02 * loss);
  };
  check(measured(model, 16384, window(12, 32, 3)).response);
  model.name = ModelName::stochastic_osl;
  model.stochastic_osl = {.disorder = 0.2, .cell_columns = 4, .cell_rows = 4, .grid = 4};
  const ModelResponse waves = measured(model, 8192, window(24, 60, 3)).response;
  check(waves);
  // The peaks are narrower than a cell: their width grows as theory has it for these, and 2.5 times as fast as for
  // others.
  REQUIRE(waves.spreading_gain.known());
  const double D = waves.theory->narrow->spreading * 0.04;
  CHECK(std::abs(waves.spreading_gain.value - D) < 5 * waves.spreading_gain.standard_error + 0.1 * D);
  CHECK(waves.spreading_gain.standard_error < 0.1 * D);
}

TEST_CASE("legs begin to pull where a pile has come to one bead on a pulling leg") {
  MeasuredEnsemble ensemble;
  ensemble.spec.lattice = {100, 40};
  ensemble.spec.sampler.model.name = ModelName::three_leg;
  ensemble.spec.sampler.model.three_leg = {.middle = 0.3, .noise = 0.2};
  BlockSums& sums = ensemble.record.sums;
  sums.rows = rows_of(ensemble.spec.sampler.model);
  sums.count = std::vector<std::uint64_t>(8, 2);
  QuantitySums& traction = sums.quantities["traction"];
  for (int row = 0; row < 40; ++row) sums.layers.push_back(row);
  for (int block = 0; block < 8; ++block) {
    // From row 10 on 0.1 bead a row, and a little more in some blocks.
    for (int row = 0; row < 40; ++row) traction.sum.push_back(row < 10 ? 0 : 2 * (0.001 + 1e-6 * (block - 3.5)));
  }
  const TractionDepth found = measure_traction(ensemble);
  REQUIRE(found.z.known());
  CHECK(found.z.value == Approx(sums.rows.depth(19)).margin(0.01));
  CHECK(found.z.standard_error > 0);
  CHECK(found.z.standard_error < 0.1);
  CHECK(found.samples == 16);
  for (double& share : traction.sum) share /= 10;
  CHECK_FALSE(measure_traction(ensemble).z.known());
}

TEST_CASE("heavy beads keep their stresses over depth, sigma_zz exactly") {
  EnsembleSpec spec;
  spec.sampler.mu = 0.4;
  spec.sampler.bead_weight = 0.5;
  spec.lattice = {128, 60};
  spec.response = multiplexed_response(0.2);
  spec.response.samples = 256;
  spec.response.blocks = 16;
  const FitSpec fit = window(12, 30, 3);
  spec.layers = layers_to_record(fit, {2});
  const ModelResponse found =
      measure_model({spec, run_ensemble(spec, 1, nullptr)}, fit, "beads", "g = 0.5", 1).response;
  CHECK(found.bead_weight == 0.5);
  REQUIRE(found.stress.size() >= 8);
  for (const StressAtDepth& at : found.stress) {
    const double layer = (at.z - 0.5) / (std::sqrt(3.0) / 2);
    CHECK(at.weight == Approx(1 + 0.5 * (layer + 1)));
    // Relative to the mean: neither grows with depth, as both would by tens.
    CHECK(at.thrust_ratio.value == Approx(layer < 1 ? 1.1 : 0.95).margin(0.15));
    CHECK(at.weight_variance.value < 0.3);
  }
}

TEST_CASE("claims about classes of models say what was measured, and turn where it turns") {
  std::vector<ModelSeries> all(4);
  const char* const names[] = {"frictional-beads", "q-model", "stochastic-osl", "three-leg"};
  for (std::size_t k = 0; k < 4; ++k) {
    all[k].name = k == 3 ? "three-leg, positive" : names[k];
    all[k].responses = {response(names[k], 0.05, 0.02)};
    all[k].responses[0].z = {33, 99};
    all[k].alpha = synthetic::power_law(0.97, 0.02, 0, {0, 0});
  }
  all[0].alpha = synthetic::power_law(0.77, 0.02, 0, {0, 0});
  all[1].responses[0].peaks = 1;
  all[1].responses[0].D = known(0.29, 0.002);
  all[3].responses[0].share_of_mean = known(0.97, 0.003);
  const auto verdicts = [&] {
    std::vector<std::string> found;
    for (const Claim& claim : judge_models(all)) found.push_back(claim.id + ": " + claim.verdict);
    return found;
  };
  using Verdicts = std::vector<std::string>;
  CHECK(verdicts() == Verdicts{"models-not-elastic: reproduced", "q-model-too-narrow: reproduced",
                               "models-c-of-D: reproduced", "mean-of-noise: reproduced"});
  CHECK(contains(judge_models(all)[1].explanation, "0.097"));  // sqrt(0.29 z) over sqrt(c^2 z^2 + D z)
  all[0].responses[0].width_exponent = known(1.95, 0.05);
  all[0].alpha = synthetic::power_law(0.98, 0.02, 0, {0, 0});
  all[1].responses[0].peaks = 2;
  all[3].responses[0].share_of_mean = known(0.4, 0.01);
  CHECK(verdicts() == Verdicts{"models-not-elastic: not reproduced", "q-model-too-narrow: not reproduced",
                               "models-c-of-D: not reproduced", "mean-of-noise: not reproduced"});
  all.erase(all.begin());
  CHECK(verdicts() == Verdicts{"mean-of-noise: not reproduced"});
}

TEST_CASE("noise, mean shares and gravity have figures that hold at every width, and tables", "[long]") {
  std::vector<ModelSeries> all(4);
  const auto with_theory = [](double disorder) {
    ModelSpec model;
    model.name = ModelName::stochastic_osl;
    model.stochastic_osl = {.disorder = disorder, .cell_columns = 4, .cell_rows = 4, .grid = 2};
    ModelResponse one = response("stochastic OSL", 0.24 * disorder * disorder, 0.1 * disorder * disorder);
    one.theory = noise_theory(model);
    one.speed_without_disorder = one.theory->c0;
    one.width = 1;
    one.thrust_loss = known(0.25 * disorder * disorder, 1e-4);
    one.speed_loss = known(0.37 * disorder * disorder, 1e-3);
    one.spreading_gain = one.D;
    one.c_expected = one.theory->c(1);
    one.D_expected = one.theory->D(1);
    return one;
  };
  all[0].name = "stochastic OSL";
  all[0].responses = {with_theory(0.1), with_theory(0.2), with_theory(0.3)};
  all[1].name = "three-leg, positive";
  for (const double p : {0.1, 0.2, 0.3}) {
    all[1].responses.push_back(response("three-leg", p / 3.4, 0.577 - std::sqrt((1 - p) / 3)));
    all[1].responses.back().middle = known(p, 1e-4);
    all[1].responses.back().c_of_middle = known(std::sqrt((1 - p) / 3), 1e-4);
  }
  all[2].name = "beads";
  all[3].name = "beads under gravity";
  all[3].aside = true;
  for (const double g : {0.0, 0.01, 0.1}) {
    ModelResponse one = response("frictional-beads", 0.08, 0.02);
    one.parameter = g == 0 ? "μ = 0.3" : "g";
    one.bead_weight = g;
    for (const double z : {1.0, 20.0, 100.0}) {
      one.stress.push_back({z, 1 + 1.15 * g * z, known(0.93, 0.001), known(0.14, 0.001)});
    }
    all[g == 0 ? 2 : 3].responses.push_back(one);
  }
  const auto traction = [](double middle, double noise, const Estimate& z) {
    TractionDepth one;
    one.middle = middle;
    one.noise = noise;
    one.samples = 256;
    one.columns = 256;
    one.z = z;
    return one;
  };
  const std::vector<TractionDepth> tractions = {traction(0.1, 0.1, known(600, 9)), traction(0.2, 0.2, known(13, 0.3)),
                                                traction(0.2, 0.1, unknown("none does")),
                                                traction(0.3, 0.15, known(130, 7))};
  const TemporaryFolder run;
  const auto study = models_study({all, tractions, {}});
  const auto figures = study->figures({});
  REQUIRE(figures.size() == 7);
  std::vector<std::string> ids;
  for (const FigurePlot& plot : figures) {
    const Figure figure = plot(run.path());
    ids.push_back(figure.id);
    INFO(figure.failure);
    CHECK(figure.is_there());
    if (figure.screen.extension() == ".svg") check_at_widths_of_journals(run / "figures", figure.id);
  }
  CHECK(ids == std::vector<std::string>{"model-classes", "model-noise", "model-middle", "model-gravity",
                                        "pile-of-stochastic-OSL", "pile-of-three-leg-positive", "pile-of-beads"});
  CHECK(std::filesystem::file_size(run.path() / "figures/pile-of-beads.png") > 10'000);
  CHECK(contains(read_file(run.path() / "figures/model-noise-0-thrust-theory.csv"), "\n0.09,0.02"));
  CHECK(contains(read_file(run.path() / "figures/model-gravity-g-0.1-vertical.csv"), "\n100,12.5"));
  CHECK(contains(read_file(run.path() / "figures/model-middle-tractions-50.csv"), "\n0.3,130,7"));
  CHECK_FALSE(contains(read_file(run.path() / "figures/model-middle-tractions-50.csv"), "\n0.2"));
  const std::string page = study_page(*study).html;
  for (const char* text : {"Where legs begin to pull", "13.00(30)", "What noise in cells does", "0.02250"}) {
    INFO(text);
    CHECK(contains(page, text));
  }
}

TEST_CASE("a class of models needs the shape and the growth of the width") {
  using enum ResponseShape;
  CHECK(class_of_model(two_gaussians, known(1.1, 0.05)) == "hyperbolic with noise");
  CHECK(class_of_model(one_gaussian, known(0.97, 0.05)) == "diffusive");
  CHECK(class_of_model(isotropic, known(2.0, 0.05)) == "elastic");
  CHECK(class_of_model(orthotropic, known(1.9, 0.1)) == "elastic");
  CHECK(contains(class_of_model(two_gaussians, known(2.0, 0.1)), "none of these"));
  CHECK(contains(class_of_model(isotropic, known(1.0, 0.1)), "none of these"));
  CHECK(contains(class_of_model(isotropic, known(1.6, 0.1)), "not decided"));
  CHECK(contains(class_of_model(one_gaussian, unknown("few depths")), "not decided"));
}

TEST_CASE("the report has a table of classes, one of the means, and a figure") {
  std::vector<ModelSeries> all(2);
  all[0].name = "stochastic OSL";
  all[0].responses = {response("stochastic OSL", 0.01, 0.004), response("stochastic OSL", 0.02, 0.008)};
  all[0].alpha = synthetic::power_law(0.97, 0.02, 0, {0, 0});
  all[1].name = "three-leg, positive";
  all[1].responses = {response("three-leg, positive", 0.2, 0.1)};
  all[1].responses[0].middle = known(0.337, 0.0002);
  all[1].responses[0].c_of_middle = known(0.4701, 0.0001);
  all[1].responses[0].traction = known(0, 0);
  all[1].responses[0].share_of_mean = known(0.97, 0.003);
  all[1].alpha.exponent = unknown("an exponent needs three parameters with known c and D");
  DeepModel deep{"three-leg, positive", "share of p_max = 1", {}};
  deep.response.spec.response.estimator = EstimatorName::fluctuation;
  deep.response.spec.lattice = {512, 400};
  deep.response.spec.layers = {32, 64};
  deep.response.octaves = {{55, 111, known(1.12, 0.01), known(0.471, 1e-4), known(0.27, 0.002), 0.03}};
  deep.shapes = {{443, 31, 209.6, 45.2, std::nan("")}};
  const auto study = models_study({all, {}, {deep}});
  const std::string page = study_page(*study).html;
  // Page 1: one number of peaks for all, so that they are not told apart; the exponent that is known.
  for (const char* text :
       {"same number of peaks", ">stochastic OSL</span></em>", "hyperbolic with noise", "0.337", "0.4701", "0.9700(30)",
        "spread at depth", "1.120(10)", "shape of the peaks of each model at depth", ">210<", ">45<", ">31<"}) {
    INFO(text);
    CHECK(contains(page, text));
  }
  all[1].responses[0].peaks = 1;
  CHECK(contains(study_page(*models_study({all, {}, {}})).html, "apart by its number of peaks"));
  const TemporaryFolder run;
  const Figure figure = plot_models(all, "model_classes", run.path());
  check_at_widths_of_journals(run / "figures", figure.id);
  CHECK(contains(figure.details, "0.970(20) (stochastic OSL)"));
  CHECK(contains(read_file(run.path() / "figures/model-classes-1.csv"), "\n0.01,"));
  CHECK(std::filesystem::exists(run.path() / "figures/model-classes-2-profile.csv"));
  // What stands aside is no class, and needs no exponent.
  all[1].aside = true;
  CHECK_FALSE(contains(plot_models(all, "model_classes", run.path()).details, "positive"));
  all.clear();
  CHECK_THROWS_AS(plot_models(all, "model_classes", run.path()), InputError);
}

TEST_CASE("the study refuses a ring on which the peaks meet, and asks for an ensemble of each model") {
  const auto study = models_study();
  CHECK_FALSE(study->asked());
  const auto set = [&](const std::string& name, const KeyValue& value) {
    for (const Key& key : study->keys()) {
      if (key.name == name) key.set(value);
    }
  };
  set("q_model", true);
  set("stochastic_osl", std::vector<double>{0.1, 0.2});
  set("three_leg_positive", std::vector<double>{1.0});
  MainLine main;
  CHECK(study->asked());
  CHECK_FALSE(study->find_problem(main).has_value());
  const auto ensembles = study->ensembles(main);
  CHECK(ensembles.size() == 6);
  for (const StudyEnsemble& one : ensembles) {
    INFO(one.label);
    CHECK_FALSE(find_problem(one.spec).has_value());
    const RowGeometry rows = rows_of(one.spec.sampler.model);
    CHECK(rows.depth(one.spec.layers.back()) == Approx(100).margin(rows.spacing));
  }
  set("stochastic_osl", std::vector<double>{});
  set("osl_coarser_grids", std::vector<std::int64_t>{2});
  CHECK(study->find_problem(main)->key == "studies.model_classes.osl_coarser_grids");
  set("osl_coarser_grids", std::vector<std::int64_t>{});
  set("bead_weights", std::vector<double>{0.01});
  CHECK(study->find_problem(main)->key == "studies.model_classes.bead_weights");
  set("mu", std::vector<double>{0.1, 0.3});
  set("traction_noise", std::vector<double>{0.5, 1});
  CHECK(study->find_problem(main)->key == "studies.model_classes.traction_noise");
  set("three_leg_free", std::vector<double>{0.1, 0.7});
  set("three_leg_cells", std::vector<double>{0.1});
  CHECK_FALSE(study->find_problem(main).has_value());
  const auto more = study->ensembles(main);
  // Beads, legs free and pushing, laws of the q-model, heavy beads, cells, tractions.
  REQUIRE(more.size() == 2 + 2 + 1 + 3 + 1 + 1 + 4);
  for (const StudyEnsemble& one : more) {
    INFO(one.label);
    CHECK_FALSE(find_problem(one.spec).has_value());
  }
  CHECK(more[8].spec.sampler.bead_weight == 0.01);
  // Free and pushing legs once more, down to 128 rows.
  set("deep_octaves", std::int64_t{3});
  const auto deep = study->ensembles(main);
  REQUIRE(deep.size() == more.size() + 2);
  for (std::size_t k = more.size(); k < deep.size(); ++k) {
    CHECK_FALSE(find_problem(deep[k].spec).has_value());
    CHECK(deep[k].spec.layers == std::vector{16, 32, 64, 128});
    CHECK(deep[k].spec.response.estimator == EstimatorName::fluctuation);
  }
  CHECK(more[8].spec.sampler.mu == 0.3);
  CHECK(more[9].spec.sampler.model.three_leg.cell_rows == 4);
  CHECK(more[13].spec.load == Load::uniform);
  CHECK(more[13].spec.sampler.model.three_leg.noise == Approx(0.3));  // shares end at 1
  set("columns", std::int64_t{128});
  const Problem found = study->find_problem(main);
  REQUIRE(found.has_value());
  CHECK(found->key == "studies.model_classes.columns");
}

// Noise that is alike in cells, followed down to where peaks are wider than those: what theory to second order says
// (studies/model_classes/results.h).

namespace {

/// D of a wave e^(ikx) in stochastic OSL, from the integral that noise_theory() has the limits of.
double D_of_wave(const StochasticOslSpec& spec, double k, double c0, double spacing) {
  const double width = spec.cell_columns, reach = c0 * spec.cell_rows * spacing, end = std::min(width, reach);
  constexpr int steps = 2000;
  std::complex<double> twice_Q = 0;
  for (int i = 0; i < steps; ++i) {
    const double u = (i + 0.5) * end / steps, g_z = 1 - u / reach, g_x = 1 - u / width, slope = -1 / width;
    const std::complex<double> ik(0, k);
    twice_Q += g_z * ((slope + ik * g_x) * std::exp(2.0 * ik * u) + slope - ik * g_x) * end / double{steps};
  }
  const std::complex<double> c = c0 * std::sqrt(1.0 + spec.disorder * spec.disorder * twice_Q / 2.0);
  return -2 * c.imag() / k;
}

/// 2048 piles of a model, over three octaves of depth from the first lag on.
DeepResponse followed(const ModelSpec& model, LatticeSpec size, int first_lag) {
  EnsembleSpec spec;
  spec.sampler.model = model;
  spec.lattice = size;
  spec.response.estimator = EstimatorName::fluctuation;
  spec.response.reference_lag = spec.response.base_step = first_lag;
  spec.response.samples = 2048;
  spec.layers = {first_lag, 2 * first_lag, 4 * first_lag, 8 * first_lag};
  return measure_spreading({spec, run_ensemble(spec, 0, nullptr)}, DeepMeasurement::fluctuations, 0);
}

}  // namespace

// Loads show it only where peaks are still narrow; fluctuations follow them until they are wide against the cells.
TEST_CASE("at depth, noise in cells spreads the peaks of free legs as its theory says, and as z", "[long]") {
  ModelSpec model;
  model.name = ModelName::three_leg;
  model.three_leg = {.middle = 0.3, .noise = 0.26, .cell_columns = 4, .cell_rows = 4};
  const DeepResponse found = followed(model, {1024, 800}, 32);
  const NoiseTheory theory = noise_theory(model);
  const double squared = theory.disorder * theory.disorder, gain = theory.wide.spreading * squared;
  for (const OctaveOfDepth& octave : found.octaves) {
    REQUIRE(octave.D.known());
    CAPTURE(octave.from, octave.D.value, octave.D.standard_error, theory.D0 + gain, octave.exponent.value);
    CHECK(octave.D.standard_error < 0.1 * gain);
    // To the next order: Delta^2 of what is measured.
    CHECK(std::abs(octave.D.value - theory.D0 - gain) < 5 * octave.D.standard_error + 2 * squared * gain);
    CHECK(std::abs(octave.exponent.value - 1) < 5 * octave.exponent.standard_error + 0.01);
    CHECK(std::abs(octave.c.value - theory.c0 * std::sqrt(1 - theory.wide.kappa * squared)) <
          5 * octave.c.standard_error + theory.c0 * squared * squared);
  }
}

TEST_CASE("the integral of the theory has both of its limits") {
  ModelSpec model;
  model.name = ModelName::stochastic_osl;
  model.stochastic_osl = {.disorder = 0.01, .cell_columns = 4, .cell_rows = 4};
  const NoiseTheory theory = noise_theory(model);
  const auto gain = [&](double k) {
    return D_of_wave(model.stochastic_osl, k, theory.c0, rows_of(model).spacing) / std::pow(theory.disorder, 2);
  };
  CHECK(gain(1e-3) == Approx(theory.wide.spreading).epsilon(1e-3));
  CHECK(gain(40) == Approx(theory.narrow->spreading).epsilon(0.02));
}

TEST_CASE("at depth, peaks of stochastic OSL become wider than its cells and spread less, wave by wave as theory says",
          "[long]") {
  ModelSpec model;
  model.name = ModelName::stochastic_osl;
  model.stochastic_osl = {.disorder = 0.3, .cell_columns = 4, .cell_rows = 4};
  const DeepResponse found = followed(model, {512, 400}, 16);
  const NoiseTheory theory = noise_theory(model);
  const double squared = theory.disorder * theory.disorder;
  int known = 0;
  for (const BandOfModes& band : found.bands) {
    // Longer waves have hardly decayed over these lags.
    if (!band.D.known() || band.D.standard_error > 0.04 * band.D.value) continue;
    ++known;
    const double D = D_of_wave(model.stochastic_osl, band.k, theory.c0, rows_of(model).spacing);
    CAPTURE(band.k, band.D.value, band.D.standard_error, D);
    // To the next order: Delta^2 of what is measured.
    CHECK(std::abs(band.D.value - D) < 4 * band.D.standard_error + squared * D);
    // Neither limit would do.
    CHECK(theory.D(0) - band.D.value > 5 * band.D.standard_error);
    CHECK(band.D.value - theory.D(2 * theory.cell) > 5 * band.D.standard_error);
  }
  CHECK(known >= 2);
  CHECK(found.octaves.back().exponent.value + 5 * found.octaves.back().exponent.standard_error < 1);
}
