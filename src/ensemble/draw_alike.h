#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sampling/sampler.h"

namespace granuscope {

/// Draws samples that all have one load, as many at once as there are `loads` (all the same), and hands each group to
/// `add` with the failures of its piles.
template <typename Add>
void draw_alike(Sampler& sampler, const std::vector<std::span<const double>>& loads,
                std::span<const std::uint64_t> samples, std::span<std::optional<SamplingFailure>> failures, Add add) {
  for (std::size_t done = 0; done < failures.size(); done += loads.size()) {
    const std::size_t count = std::min(loads.size(), failures.size() - done);
    std::size_t next = done;
    for (const PileGroup& group :
         sampler.draw_groups(samples.subspan(done, count), {loads.data(), count}, failures.subspan(done, count))) {
      add(group, failures.subspan(next, group.piles));
      next += group.piles;
    }
  }
}

}  // namespace granuscope
