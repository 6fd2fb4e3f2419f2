// Whoever reads an ensemble file without this program finds in it what each of its numbers is.
#include <catch2/catch.hpp>

#include "ensemble/small_ensemble.h"
#include "kit/temporary_folder.h"
#include "storage/hdf5_reader.h"

namespace granuscope {
namespace {

std::vector<EnsembleSpec> an_ensemble_of_every_kind() {
  std::vector<EnsembleSpec> all;
  all.push_back(test::small_ensemble(point_response(1), 24));
  all.push_back(test::small_ensemble({.estimator = EstimatorName::paired}, 24));
  all.push_back(test::small_ensemble(multiplexed_response(0.2), 24));
  all.push_back(all.back());
  all.back().sampler.model.name = ModelName::three_leg;
  all.push_back(test::small_ensemble({.estimator = EstimatorName::fluctuation}, 24));
  all.back().response.first_base = 20;
  all.back().response.reference_lag = 4;
  all.back().response.base_step = 2;
  all.back().lattice.layers = 60;
  all.back().layers = {1, 3, 8};
  return all;
}

}  // namespace

TEST_CASE("every dataset of an ensemble file has its unit and its axes") {
  const test::TemporaryFolder folder;
  for (const EnsembleSpec& spec : an_ensemble_of_every_kind()) {
    INFO(configuration_text(spec));
    const EnsembleRecord record = run_ensemble(spec, 1, nullptr);
    write_ensemble(folder / "e.h5", record);
    const Hdf5Reader file(folder / "e.h5", "an ensemble file");
    std::vector<std::string> datasets = {"/count", "/layers",       "/block_keys",    "/x",
                                         "/z",     "/failed/layer", "/failed/replay", "/failed/sample"};
    for (const auto& [name, sums] : record.sums.quantities) {
      datasets.push_back("/" + name + "/sum");
      datasets.push_back("/" + name + "/sum_of_squares");
    }
    std::size_t found = 0;
    for (const std::string& dataset : datasets) {
      if (!file.has_dataset(dataset)) continue;
      INFO(dataset);
      ++found;
      CHECK_FALSE(file.text(dataset, "units").empty());
      CHECK_FALSE(file.text(dataset, "axes").empty());
    }
    const bool of_lags = spec.response.estimator == EstimatorName::fluctuation;
    CHECK(found + (of_lags ? 2 : 0) + 1 == datasets.size());  // a profile has no squares, and a lag lies nowhere
    if (!of_lags) CHECK(file.shape("/x") == Shape{2, 24});
  }
}

}  // namespace granuscope
