// The response of beads that have a weight of their own. Source of the expected numbers: weight is conserved, and
// without friction rays go straight.
#include <catch2/catch.hpp>

#include "ensemble/small_ensemble.h"

namespace granuscope {
namespace {

EnsembleSpec heavy_ensemble(const ResponseSpec& response, double mu, double bead_weight) {
  EnsembleSpec spec = test::small_ensemble(response, 24);
  spec.sampler.mu = mu;
  spec.sampler.bead_weight = bead_weight;
  return spec;
}

}  // namespace

TEST_CASE("the response of heavy beads has the weight of the load, whatever they weigh, on any number of threads") {
  for (const ResponseSpec& response : {point_response(1), multiplexed_response(0.2), multiplexed_response(0.2, true)}) {
    const EnsembleSpec spec = heavy_ensemble(response, 0.3, 0.7);
    const EnsembleRecord record = run_ensemble(spec, 1, nullptr);
    CHECK(test::same_bytes(record, run_ensemble(spec, 2, nullptr)));
    const bool point = response.estimator == EstimatorName::point;
    const std::vector<double>& sum = record.sums.quantities.at(point ? "weight" : "correlation").sum;
    const std::size_t rows = record.sums.layers.size(), columns = 24;
    REQUIRE(sum.size() == 8 * rows * columns);
    for (std::size_t block = 0; block < 8; ++block) {
      const double* const of_block = &sum[block * rows * columns];
      for (std::size_t row = 0; row < rows; ++row) {
        double total = 0;
        for (std::size_t i = 0; i < columns; ++i) total += of_block[row * columns + i];
        // Under the point load the sum of the weights, else mode 0 of every layer, which is that of the loads.
        if (point) CHECK(total / static_cast<double>(record.sums.count[block]) == Approx(25).epsilon(1e-12));
        if (!point) CHECK(of_block[row * columns] == Approx(of_block[0]).epsilon(1e-9));
      }
    }
  }
}

TEST_CASE("without friction the response is that of beads without weight, and forces are as even as they are heavy") {
  const EnsembleRecord heavy = run_ensemble(heavy_ensemble(multiplexed_response(0.2), 0, 3), 1, nullptr);
  const EnsembleRecord light = run_ensemble(heavy_ensemble(multiplexed_response(0.2), 0, 0), 1, nullptr);
  const auto of = [](const EnsembleRecord& record, const char* name) { return record.sums.quantities.at(name).sum; };
  const std::vector<double> a = of(heavy, "correlation"), b = of(light, "correlation");
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i] == Approx(b[i]).margin(1e-9));
  const std::vector<double> thrust = of(heavy, "thrust"), one = of(heavy, "weight_variance"),
                            other = of(light, "weight_variance");
  const std::size_t rows = heavy.sums.layers.size();
  for (std::size_t i = 0; i < thrust.size(); ++i) {
    CHECK(thrust[i] == Approx(8).epsilon(1e-12));  // 8 piles a block, of thrust ratio 1
    const double mean = 1 + 3 * (heavy.sums.layers[i % rows] + 1);
    CHECK(one[i] * mean * mean == Approx(other[i]));
  }
}

TEST_CASE("an ensemble of heavy beads says so, and the estimator fluctuation refuses them by name") {
  const EnsembleSpec heavy = heavy_ensemble(point_response(1), 0.3, 0.25);
  CHECK(configuration_text(heavy).find("\nbead_weight=0.25\n") != std::string::npos);
  CHECK(configuration_text(heavy_ensemble(point_response(1), 0.3, 0)).find("bead_weight") == std::string::npos);
  CHECK(replay_command(heavy, 3).find(" --bead-weight 0.25 ") != std::string::npos);
  const Problem found = find_problem(heavy_ensemble({.estimator = EstimatorName::fluctuation}, 0.3, 0.25));
  REQUIRE(found.has_value());
  CHECK(found->key == "estimator");
  CHECK(found->message.find("weight 0.25") != std::string::npos);
}

}  // namespace granuscope
