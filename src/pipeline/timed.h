#pragma once
#include <chrono>
#include <string>
#include <vector>

#include "report/report_data.h"
#include "support/interruption.h"

namespace granuscope {

/// Does a piece of work and adds its wall time to the line of a stage; a new line if there is none. Throws Interrupted
/// instead if that was asked for.
template <typename Work>
void timed(std::vector<StageTiming>& timings, const std::string& stage, Work work) {
  throw_if_interrupted();
  const auto start = std::chrono::steady_clock::now();
  work();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  for (StageTiming& timing : timings) {
    if (timing.stage == stage) {
      timing.seconds += elapsed.count();
      return;
    }
  }
  timings.push_back({stage, elapsed.count(), false});
}

}  // namespace granuscope
