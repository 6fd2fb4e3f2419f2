#pragma once
#include <cstddef>
#include <vector>

#include "model/equilibrium.h"
#include "model/pile.h"

namespace granuscope {

/// The number in [0, 1] that each bead's split stands for, shape [layers, columns]:
///   u = (H_R - lo)/(hi - lo),   [lo, hi] being the interval of its final state; 1/2 where that is a single point.
void read_split_uniforms(const Pile& pile, std::vector<double>& numbers);

/// The split of bead `at` that keeps its number of the pile `first`, in a state with these forces and this interval
/// (not empty). The very split of `first` where the forces are the same: forces as a function of the numbers are
/// chaotic, and rounding alone would make two piles differ from some depth on.
inline double kept_split(const Pile& first, std::size_t at, double number, Outgoing out, Interval interval) {
  return out.V_R == first.V_R[at] && out.V_L == first.V_L[at] ? first.H_R[at] : point_at(interval, number);
}

/// Which beads of a pile solved again do not stand where their numbers of the pile `first` put them, up to rounding,
/// that is which had to draw another number: 1, otherwise 0. Shape [layers, columns].
void find_redrawn(const Pile& first, const Pile& again, std::vector<unsigned char>& redrawn);

}  // namespace granuscope
