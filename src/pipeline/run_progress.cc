#include "pipeline/run_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ensemble/estimator.h"
#include "pipeline/shards.h"

namespace granuscope {

double seconds_to_draw(const PlannedEnsemble& planned, int threads) {
  if (planned.reusable) return 0;
  constexpr double seconds_per_bead = 1e-8;  // of granusolve at small friction
  const double blocks = planned.spec.response.blocks;
  const double left = 1 - static_cast<double>(samples_there(planned)) /
                              std::max(1.0, static_cast<double>(planned.spec.response.samples));
  return seconds_per_bead * relative_cost(planned.spec) * (left * blocks - planned.blocks_there) / threads;
}

double seconds_for_fits(const EnsembleSpec& spec) {
  constexpr double seconds_per_fitted_bead = 3e-7;  // each bead of a profile, in each block and in all together
  if (!spec.record_profiles) return 0;
  return seconds_per_fitted_bead * static_cast<double>(recorded_layers(spec).size()) * (spec.response.blocks + 1) *
         spec.lattice.columns;
}

std::string RunProgress::line(double done, double total, double seconds) {
  if (!(done > 0) || !(total > done)) return "";
  return fmt::format("whole run: {:.0f} %, about {} left", std::floor(100 * done / total),
                     describe_duration(seconds * (total - done) / done));
}

void RunProgress::finish(double cost) {
  done_ += cost;
  const auto now = Clock::now();
  constexpr auto interval = std::chrono::seconds(10);
  if (now - told_ < interval) return;
  told_ = now;
  const std::string told = line(done_, total_, std::chrono::duration<double>(now - started_).count());
  if (!told.empty()) log_line(style_, told);
}

}  // namespace granuscope
