#pragma once
#include <cstdint>

namespace granuscope {

/// What an ensemble of piles of 500 x 200 beads holds in memory while it is drawn and summed.
struct EnsembleMemory {
  std::uint64_t samples = 0;
  int threads = 0;
  double peak_bytes = 0;  ///< resident, with the program and its libraries
};

/// Draws the ensemble of the paper's Fig. 2 (3461 piles under an overload, profiles of every layer that a fit may use)
/// in a process of its own. Call it while this process has one thread. Throws EnvironmentError if that process fails.
EnsembleMemory measure_ensemble_memory(int threads);

}  // namespace granuscope
