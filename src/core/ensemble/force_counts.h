#pragma once
#include <cstddef>

namespace granuscope {
/// How the forces of one layer are distributed, as numbers that add up: "force_counts" counts beads and contacts in
/// bins, one histogram behind the other, and "force_moments" sums powers. Weights w and normal forces N are in units of
/// the mean weight that leaves a bead of the layer. A mobilisation is T/(mu N) of a contact, above 0 where its force is
/// nearer to the horizontal than the contact; without friction it is 0.
namespace force_bins {
inline constexpr std::size_t per_unit = 32;           ///< bins of w and of N in one mean weight
inline constexpr std::size_t values = 10 * per_unit;  ///< of either; the last one also has all that is larger
inline constexpr std::size_t mobilisations = 64;  ///< even over [-1, 1], between the sliding contacts of either sign
inline constexpr std::size_t map_normals = 24, map_per_unit = 8,
                             map_mobilisations = 20;  ///< of the map, N before T/(mu N)
/// A contact within this share of Coulomb's limit slides: what a law puts there is off by rounding only.
inline constexpr double sliding = 1e-9;

// Where the histograms begin.
inline constexpr std::size_t weight = 0, normal = values, mobilisation = 2 * values,
                             map = mobilisation + mobilisations + 2;
inline constexpr std::size_t width = map + map_normals * map_mobilisations;
}  // namespace force_bins

/// Places in "force_moments": sums over the beads of (w - 1)^n, and over the contacts of (N - 1/sqrt 3)^n, 1/sqrt 3
/// being N without friction, of |T| in mean weights, of |T|/(mu N), and of 1 for each that slides.
enum class ForceMoment { w, w_2, w_3, N, N_2, N_3, tangential, mobilisation, sliding, count };

}  // namespace granuscope
