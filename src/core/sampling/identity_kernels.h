#pragma once
#include <array>
#include <cstddef>

#include "model/lattice.h"
#include "sampling/group_lanes.h"

namespace granuscope {

/// What a row of beads adds up to, in eight running values: entry i of the row counts for value i mod 8. For eight
/// piles side by side that is one value for each pile.
struct RowFacts {
  alignas(64) std::array<double, group_lanes> weight_sum{}, largest_weight{}, largest_H{};
  alignas(64) std::array<double, group_lanes> largest_residual{};
  /// Of the sizes of H_R and of the residuals: vector maxima pass over what is not a number, sums do not.
  alignas(64) std::array<double, group_lanes> finite_sum{};
};

/// Adds the weights and the sizes of H_R of a row.
void check_weights(const double* V_R, const double* V_L, const double* H_R, std::size_t entries, RowFacts& facts);

/// A run of beads, what stands straight above them, and the forces leaving the parents between; entry i of each belongs
/// to bead i of the run.
struct CheckedBeads {
  const double *V_R, *V_L, *H_R;        ///< of the beads
  const double *V_R_above, *V_L_above;  ///< two layers up
  const double *H_R_left, *H_L_left;    ///< leaving the upper-left parent
  const double *H_R_right, *H_L_right;  ///< leaving the upper-right parent
  double gain = 0;                      ///< of weight in two layers: what two beads weigh by themselves
  bool totals = false;                  ///< instead of H_L both parents give H_R + H_L, and H_R is not read
  double cotangent = sqrt3;
};

/// The same, and the residuals |w - (w two layers up + gain + cot (H of the left parent - H of the right parent))|.
/// For a run that is a whole number of eights, or the row's last.
void check_beads(const CheckedBeads& beads, std::size_t entries, RowFacts& facts);

}  // namespace granuscope
