#include "analysis/mean_response.h"

#include "support/error.h"

namespace granuscope {

ResponseQuantity response_quantity(const BlockSums& sums, double overload) {
  if (sums.quantities.contains("response")) return {"response", 0, 1};
  if (sums.quantities.contains("weight")) return {"weight", 1, overload};
  throw InputError(
      "the ensemble holds numbers per layer only, so that there is no response to fit; draw it with its profiles "
      "recorded");
}

BlockMeans mean_response(const BlockSums& sums, std::size_t row, double overload) {
  const ResponseQuantity response = response_quantity(sums, overload);
  BlockMeans means = block_means(sums, response.name, row);
  const auto take_response = [&](std::vector<double>& profile) {
    for (double& value : profile) value = (value - response.background) / response.scale;
  };
  take_response(means.whole);
  for (auto& without : means.without_block) take_response(without);
  return means;
}

}  // namespace granuscope
