#include "analysis/identifiable_depths.h"

#include <algorithm>

namespace granuscope {

std::vector<std::size_t> identifiable_depths(std::span<const DepthUse> depths) {
  std::vector<std::size_t> run;
  for (std::size_t i = depths.size(); i-- > 0;) {
    if (depths[i] == DepthUse::fitted) {
      run.push_back(i);
      continue;
    }
    const bool deeper_was_used = i + 1 == depths.size() || depths[i + 1] == DepthUse::fitted;
    if (depths[i] == DepthUse::unidentified || !deeper_was_used) break;
  }
  std::reverse(run.begin(), run.end());
  return run;
}

}  // namespace granuscope
