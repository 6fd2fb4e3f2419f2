#pragma once
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "analysis/estimate.h"

namespace granuscope {

/// A number computed from the whole ensemble, and again from the ensemble without each of its blocks. Whatever is
/// computed from such numbers goes through `transform`, so that its error knows all correlations.
struct Replicated {
  double value = 0;
  std::vector<double> without_block;  ///< one entry per block
};

/// Delete-one jackknife: se^2 = (B-1)/B sum_b (theta_b - mean)^2. Unknown, with the reason, if any entry is not finite.
Estimate estimate(const Replicated& number, const std::string& reason_if_unknown = "a replicate could not be computed");

/// f applied to the whole-ensemble values and to each set of replicates. All arguments have the same blocks.
template <typename F, typename... Numbers>
Replicated transform(F f, const Replicated& first, const Numbers&... others) {
  Replicated result;
  result.value = f(first.value, others.value...);
  result.without_block.reserve(first.without_block.size());
  for (std::size_t b = 0; b < first.without_block.size(); ++b) {
    result.without_block.push_back(f(first.without_block[b], others.without_block[b]...));
  }
  return result;
}

/// The same for a function of one set of numbers (one per depth, per friction coefficient, ...).
Replicated transform_all(const std::vector<Replicated>& numbers,
                         const std::function<double(const std::vector<double>&)>& f);

/// The mean over at least one number.
Replicated mean_of(const std::vector<Replicated>& numbers);

}  // namespace granuscope
