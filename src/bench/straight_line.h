#pragma once
#include <vector>

#include "model/friction_cone.h"
#include "model/pile.h"

namespace granuscope {

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
