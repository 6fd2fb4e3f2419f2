#include "bench/thrust.h"

#include <algorithm>
#include <cmath>

#include "analysis/jackknife.h"
#include "analysis/layer_spectrum.h"
#include "analysis/speed_from_thrust.h"
#include "model/lattice.h"

namespace granuscope {

MeasuredThrust measure_thrust(const EnsembleRecord& record) {
  const BlockSums& sums = record.sums;
  MeasuredThrust result;
  if (sums.layers.empty() || std::find(sums.count.begin(), sums.count.end(), 0) != sums.count.end()) {
    result.alpha_thrust.reason = result.c_thrust.reason = "a block of the ensemble holds no completed pile";
    return result;
  }
  std::vector<Replicated> ratios;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) ratios.push_back(block_mean(sums, "thrust", row));
  const Replicated alpha = mean_of(ratios);
  result.alpha_thrust = estimate(alpha);
  result.c_thrust = estimate(transform(speed_from_thrust, alpha), "the mean thrust ratio is negative");
  return result;
}

}  // namespace granuscope
