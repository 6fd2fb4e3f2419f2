#include "analysis/jackknife.h"

#include <numeric>

namespace granuscope {

Estimate estimate(const Replicated& number, const std::string& reason_if_unknown) {
  const auto blocks = static_cast<double>(number.without_block.size());
  // Summing distances from one entry keeps the spread of equal entries exactly 0.
  const double origin = number.without_block.empty() ? 0 : number.without_block.front();
  double mean = origin;
  for (double replicate : number.without_block) mean += (replicate - origin) / blocks;
  double spread = 0;
  for (double replicate : number.without_block) spread += (replicate - mean) * (replicate - mean);
  Estimate result;
  if (!std::isfinite(number.value) || !std::isfinite(spread)) {
    result.reason = reason_if_unknown;
    return result;
  }
  result.value = number.value;
  result.standard_error = std::sqrt((blocks - 1) / blocks * spread);
  return result;
}

Replicated transform_all(const std::vector<Replicated>& numbers,
                         const std::function<double(const std::vector<double>&)>& f) {
  std::vector<double> arguments(numbers.size());
  const auto fill = [&](auto&& pick) {
    for (std::size_t i = 0; i < numbers.size(); ++i) arguments[i] = pick(numbers[i]);
    return f(arguments);
  };
  Replicated result;
  result.value = fill([](const Replicated& r) { return r.value; });
  const std::size_t blocks = numbers.empty() ? 0 : numbers.front().without_block.size();
  for (std::size_t b = 0; b < blocks; ++b) {
    result.without_block.push_back(fill([b](const Replicated& r) { return r.without_block[b]; }));
  }
  return result;
}

Replicated mean_of(const std::vector<Replicated>& numbers) {
  return transform_all(numbers, [](const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  });
}

}  // namespace granuscope
