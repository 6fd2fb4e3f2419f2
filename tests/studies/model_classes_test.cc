// Source of the expected numbers: what is known exactly of the models, and made-up responses.
#include "studies/model_classes/study.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "ensemble/ensemble_runner.h"
#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/figure_texts.h"
#include "plot/synthetic_analysis.h"
#include "studies/study_page.h"
#include "support/atomic_file.h"
#include "support/error.h"

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
  const auto study = models_study(all);
  const std::string page = study_page(*study).html;
  // Page 1: one number of peaks for all, so that they are not told apart; the exponent that is known.
  for (const char* text : {"same number of peaks", ">stochastic OSL</span></em>", "hyperbolic with noise", "0.337",
                           "0.4701", "0.9700(30)"}) {
    INFO(text);
    CHECK(contains(page, text));
  }
  all[1].responses[0].peaks = 1;
  CHECK(contains(study_page(*models_study(all)).html, "apart by its number of peaks"));
  const TemporaryFolder run;
  const Figure figure = plot_models(all, "model_classes", run.path());
  check_at_widths_of_journals(run / "figures", figure.id);
  CHECK(contains(figure.details, "0.970(20) (stochastic OSL)"));
  CHECK(contains(read_file(run.path() / "figures/model-classes-1.csv"), "\n0.01,"));
  CHECK(std::filesystem::exists(run.path() / "figures/model-classes-2-profile.csv"));
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
  set("columns", std::int64_t{128});
  const Problem found = study->find_problem(main);
  REQUIRE(found.has_value());
  CHECK(found->key == "studies.model_classes.columns");
}
