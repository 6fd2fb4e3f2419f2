#include "analysis/counted_work.h"

#include <limits>
#include <numeric>

namespace granuscope {

CountedWork counted_work(const MeasuredEnsemble& ensemble) {
  const SamplerCounts& counts = ensemble.record.counts;
  const auto per_bead = [&](std::uint64_t count) {
    return counts.beads == 0 ? std::numeric_limits<double>::quiet_NaN()
                             : static_cast<double>(count) / static_cast<double>(counts.beads);
  };
  CountedWork work;
  work.spec = ensemble.spec;
  const auto& completed = ensemble.record.sums.count;
  work.samples = std::accumulate(completed.begin(), completed.end(), std::uint64_t{0});
  work.failed = ensemble.record.failed.size();
  work.draws_per_bead = per_bead(counts.uniforms);
  work.mended_per_bead = per_bead(counts.mended_by_pair + counts.mended_by_arc + counts.mended_by_ring);
  work.climbed_per_bead = per_bead(counts.climbed);
  return work;
}

}  // namespace granuscope
