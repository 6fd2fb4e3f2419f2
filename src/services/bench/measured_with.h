#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "model/lattice.h"
#include "model/pile.h"

namespace granuscope {
/// The JSON object of a suite with one member more, "measured": by which program and commit, on which processor and
/// day. The machine's name is not in it.
std::string with_measured_with(const std::string& suite_json);

/// What an ensemble of piles of 500 x 200 beads holds in memory while it is drawn and summed.
struct EnsembleMemory {
  std::uint64_t samples = 0;
  int threads = 0;
  double peak_bytes = 0;  ///< resident, with the program and its libraries
};

/// Draws the ensemble of the paper's Fig. 2 (3461 piles under an overload, profiles of every layer that a fit may use)
/// in a process of its own. Call it while this process has one thread. Throws EnvironmentError if that process fails.
EnsembleMemory measure_ensemble_memory(int threads);

/// What a sampler would cost if every first draw were accepted: the random numbers, the balance and the split of every
/// bead, layer by layer by the kernels of single piles, and nothing else. No engine can be faster in this form.
/// The numbers it leaves are no solution: beads without an interval are left as they are.
class StraightLine {
 public:
  StraightLine(double mu, Lattice lattice);
  /// Fills `pile` from the random numbers of `sample`, under a uniform load.
  void fill(std::uint64_t seed, std::uint64_t sample, Pile& pile);

 private:
  Lattice lattice_;
  FrictionCone cone_;
  std::vector<double> uniforms_, half_load_, no_force_, H_, slack_;
};

}  // namespace granuscope
