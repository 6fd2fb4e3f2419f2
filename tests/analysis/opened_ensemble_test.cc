// The analysis does not know whether profiles are in memory or in a file.
#include <catch2/catch.hpp>
#include <random>

#include "analysis/mean_response.h"
#include "kit/same_bytes.h"
#include "kit/temporary_folder.h"
#include "storage/ensemble_file.h"

using namespace granuscope;
using test::same_bytes;
using test::TemporaryFolder;

TEST_CASE("an opened ensemble is measured as one in memory is") {
  const TemporaryFolder folder;
  const auto [quantity, width] = GENERATE(table<const char*, int>(
      {{"weight", 16}, {"response", 16}, {"correlation", 16}, {"propagation", 32}}));  // one for each kind of estimator
  CAPTURE(quantity);
  EnsembleRecord record;
  record.sums.layers = {0, 2, 5};
  record.sums.count = {8, 16, 8, 24, 8};
  QuantitySums& sums = record.sums.quantities[quantity];
  sums.width = width;
  sums.sum.resize(record.sums.count.size() * record.sums.layers.size() * static_cast<std::size_t>(width));
  std::mt19937_64 random(7);
  for (double& number : sums.sum) number = std::uniform_real_distribution<double>(1, 2)(random);
  write_ensemble(folder / "ensemble.h5", record);
  const BlockSums opened = open_ensemble(folder / "ensemble.h5").sums;
  REQUIRE(opened.quantities.at(quantity).sum.empty());
  for (std::size_t row = first_response(record.sums); row < record.sums.layers.size(); ++row) {
    const LayerSpectrum one = layer_spectrum(record.sums, row, 0.5), other = layer_spectrum(opened, row, 0.5);
    CHECK(same_bytes(one.whole, other.whole));
    CHECK(same_bytes(one.noise, other.noise));
    const BlockMeans response = mean_response(record.sums, row, 0.5), of_opened = mean_response(opened, row, 0.5);
    CHECK(same_bytes(response.whole, of_opened.whole));
    for (std::size_t b = 0; b < record.sums.count.size(); ++b) {
      CHECK(same_bytes(one.without_block.at(b), other.without_block.at(b)));
      CHECK(same_bytes(response.without_block.at(b), of_opened.without_block.at(b)));
    }
  }
}
