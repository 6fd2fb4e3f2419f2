#pragma once
#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "analysis/jackknife.h"
#include "ensemble/force_counts.h"
#include "storage/block_sums.h"

namespace granuscope {
namespace force_bins {
// Of some layers together: "force_counts", "force_moments", and how many beads they are of.
inline constexpr std::size_t moments_at = width, beads_at = moments_at + static_cast<std::size_t>(ForceMoment::count);
}  // namespace force_bins

using ForceSums = std::vector<double>;

/// Of recorded layers number first .. end - 1, of each block.
std::vector<ForceSums> band_sums(const BlockSums& sums, int columns, std::size_t first, std::size_t end);

/// The numbers f(sums), of all blocks and without each.
std::vector<Replicated> replicated(const std::vector<ForceSums>& blocks,
                                   const std::function<std::vector<double>(const ForceSums&)>& f);

/// Which force is counted, where, how many a bead has, and what its powers are taken about.
struct CountedForce {
  const char* symbol;
  std::size_t histogram;
  ForceMoment powers;
  double about, per_bead;
};
inline constexpr CountedForce weights{"w", force_bins::weight, ForceMoment::w, 1, 1},
    normals{"N", force_bins::normal, ForceMoment::N, tan30, 2};

double force_moment(const ForceSums& sums, ForceMoment which, std::size_t further = 0);
double mean_of_force(const ForceSums& sums, const CountedForce& force);

/// Mean, variance over the square of the mean, and skewness.
std::vector<double> moments_of(const ForceSums& sums, const CountedForce& force);

/// Of the contacts: mean of |T|/(mu N), and the share that slides.
std::vector<double> mobilisation_of(const ForceSums& sums);

/// Per bead, of each place of such sums.
std::vector<Estimate> counts_per_bead(const std::vector<ForceSums>& blocks);

/// The middle of a bin, the density there, and its standard error.
using DensityRows = std::vector<std::array<double, 3>>;

/// Of x = force over its mean, where the density is known to better than a half.
DensityRows density_of(const std::vector<ForceSums>& blocks, const CountedForce& force);

/// Of |T|/(mu N) of the contacts that do not slide, per contact of all.
DensityRows density_of_mobilisation(const std::vector<ForceSums>& blocks);

}  // namespace granuscope
