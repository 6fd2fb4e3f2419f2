#include "analysis/effective_samples.h"

#include <cmath>
#include <limits>
#include <numeric>

#include "analysis/jackknife.h"
#include "ensemble/ensemble_runner.h"

namespace granuscope {
namespace {

/// Scatter below this share of the mean square is rounding.
constexpr double rounding = 1e-20;

/// Infinite if nothing scatters.
double effective_by(const BlockSums& sums, const QuantitySums& quantity, double count) {
  const std::size_t blocks = sums.count.size(), layers = sums.layers.size();
  double of_one = 0, of_mean = 0;
  for (std::size_t layer = 0; layer < layers; ++layer) {
    double sum = 0, squares = 0;
    for (std::size_t b = 0; b < blocks; ++b) {
      sum += quantity.sum[b * layers + layer];
      squares += quantity.sum_of_squares[b * layers + layer];
    }
    const double mean = sum / count, variance = squares / count - mean * mean;
    if (!(variance > rounding * squares / count)) continue;
    Replicated replicated{mean, {}};
    for (std::size_t b = 0; b < blocks; ++b) {
      replicated.without_block.push_back((sum - quantity.sum[b * layers + layer]) /
                                         (count - static_cast<double>(sums.count[b])));
    }
    of_one += variance;
    of_mean += std::pow(estimate(replicated).standard_error, 2);
  }
  return of_one > 0 ? of_one / of_mean : std::numeric_limits<double>::infinity();
}

}  // namespace

Estimate effective_samples(const BlockSums& sums) {
  Estimate result;
  if (sums.blocks() < min_blocks) {
    result.reason = "too few blocks tell how far the piles depend on each other";
    return result;
  }
  const auto count = static_cast<double>(std::accumulate(sums.count.begin(), sums.count.end(), std::uint64_t{0}));
  double least = std::numeric_limits<double>::infinity();
  for (const char* name : {"thrust", "weight_variance"}) {
    least = std::min(least, effective_by(sums, sums.quantities.at(name), count));
  }
  if (!std::isfinite(least)) {
    result.reason = "no pile was completed, or all are the same";
    return result;
  }
  result.value = least;
  result.standard_error = least * std::sqrt(2.0 / (sums.blocks() - 1));
  return result;
}

}  // namespace granuscope
