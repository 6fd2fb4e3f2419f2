#include "sampling/autocorrelation.h"

#include <algorithm>
#include <cstddef>

namespace granuscope {
namespace {

constexpr double windows = 6;       ///< beyond it noise exceeds what is left of the correlation, e^-6
constexpr double rounding = 1e-10;  ///< of many sums of rounded numbers, with room

}  // namespace

double autocorrelation_time(const std::vector<double>& series, double scale) {
  const std::size_t count = series.size();
  double mean = 0;
  for (double x : series) mean += x / static_cast<double>(count);
  std::vector<double> centred;
  centred.reserve(count);
  for (double x : series) centred.push_back(x - mean);
  const auto covariance = [&](std::size_t lag) {
    double sum = 0;
    for (std::size_t k = lag; k < count; ++k) sum += centred[k] * centred[k - lag];
    return sum;
  };
  const double variance = covariance(0);
  if (!(variance > rounding * scale * rounding * scale * static_cast<double>(count))) return 1;
  double time = 1;
  for (std::size_t lag = 1; lag < count; ++lag) {
    time += 2 * covariance(lag) / variance;
    if (static_cast<double>(lag) >= windows * time / 2) break;
  }
  return std::max(1.0, time);
}

}  // namespace granuscope
