// Source: an ensemble of a model depends on its configuration alone, and its rows lie where the model says.
#include <array>
#include <catch2/catch.hpp>

#include "ensemble/small_ensemble.h"
#include "support/error.h"

namespace granuscope {
namespace {

EnsembleSpec ensemble_of(ModelName name, const ResponseSpec& response) {
  EnsembleSpec spec = test::small_ensemble(response, 24);
  spec.sampler.model.name = name;
  spec.sampler.model.three_leg.law = MiddleLaw::positive;
  return spec;
}

constexpr std::array models = {ModelName::q_model, ModelName::three_leg, ModelName::stochastic_osl};

}  // namespace

TEST_CASE("an ensemble of every model has the same bytes on any number of threads") {
  for (const ModelName name : models) {
    for (const ResponseSpec& response :
         {point_response(1), multiplexed_response(0.2), multiplexed_response(0.2, true)}) {
      const EnsembleSpec spec = ensemble_of(name, response);
      const EnsembleRecord one = run_ensemble(spec, 1, nullptr);
      CHECK(test::same_bytes(one, run_ensemble(spec, 3, nullptr)));
      CHECK(one.sums.rows == rows_of(spec.sampler.model));
      CHECK(one.failed.empty());
      CHECK(one.sums.quantities.contains("middle") == (name == ModelName::three_leg));
    }
  }
}

TEST_CASE("the linear response of a linear model does not depend on how it is loaded") {
  // Both loads of an opposite pair see the same noise, so that their mean is the pile under the uniform load.
  EnsembleSpec spec = ensemble_of(ModelName::q_model, multiplexed_response(0.2, true));
  spec.layers = {0, 29};
  const EnsembleRecord small = run_ensemble(spec, 1, nullptr);
  spec.response.epsilon = 0.8;
  const EnsembleRecord large = run_ensemble(spec, 1, nullptr);
  const auto &a = small.sums.quantities.at("correlation").sum, &b = large.sums.quantities.at("correlation").sum;
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i] == Approx(b[i]).margin(1e-9));
}

TEST_CASE("estimators that make no sense with a model refuse it by name, and beads keep their configuration") {
  for (const auto& [model, estimator] : {std::pair{ModelName::three_leg, EstimatorName::paired},
                                         {ModelName::diluted_beads, EstimatorName::paired},
                                         {ModelName::diluted_beads, EstimatorName::fluctuation}}) {
    EnsembleSpec spec = ensemble_of(model, {.estimator = estimator});
    const Problem found = find_problem(spec);
    REQUIRE(found.has_value());
    CHECK(found->key == "estimator");
    CHECK(found->message.find(name_of(model)) != std::string::npos);
  }
  const std::string again = replay_command(ensemble_of(ModelName::diluted_beads, multiplexed_response(0.2)), 3);
  CHECK(again.find("granuscope sample --model diluted-beads --opened-share 0.05 --least-slack 0.02 --mu 0.3 ") == 0);
  const EnsembleSpec beads = test::small_ensemble(point_response(1), 24);
  CHECK(configuration_text(beads).find("model") == std::string::npos);
  CHECK(configuration_text(ensemble_of(ModelName::q_model, point_response(1))).find("model=q-model\n") !=
        std::string::npos);
  EnsembleSpec cells = ensemble_of(ModelName::stochastic_osl, point_response(1));
  cells.sampler.model.stochastic_osl.cell_columns = 5;
  CHECK_THROWS_AS(run_ensemble(cells, 1, nullptr), InputError);
}

}  // namespace granuscope
