#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "model/lattice.h"
#include "sampling/pile_group.h"
#include "sampling/random_key.h"

namespace granuscope {

/// One row of contact forces above (read) or one row of beads (written); entry i belongs to bead i of the run.
struct UpperRow {
  const double* V_UL;  ///< from the upper-left parent of each bead
  const double* V_UR;
  const double* H_UL;
  const double* H_UR;
  double half_weight = 0;  ///< of each bead by itself, which comes to either vertical force
};
struct LowerRow {
  double* V_R;
  double* V_L;
  double* H;  ///< total horizontal force entering the bead
  double* H_R;
  double* H_L;
  /// Below 0 (or not a number) the bead has no solution and its split means nothing: the length of its interval, or a
  /// vertical force that leaves it if that is less. At tiny friction a contact that is pulled leaves an interval whose
  /// ends rounding makes equal.
  double* slack;
};

/// Beads a buffer of first uniforms must have room for beyond the last one: kernels write whole vectors.
inline constexpr std::size_t uniform_padding = 64;

/// The first uniform of beads 0 .. beads-1 of a layer (RandomKey's first attempts: beads 2k and 2k+1 share one Philox
/// call). `uniforms` has room for beads + uniform_padding. Uses the widest vectors the machine has; the bytes are those
/// of the plain twin on every machine.
void fill_first_uniforms(std::uint64_t seed, std::uint32_t sample, int layer, double* uniforms, std::size_t beads);
void fill_first_uniforms_plain(std::uint64_t seed, std::uint32_t sample, int layer, double* uniforms,
                               std::size_t beads);

/// Balance, interval and draw of a run of beads: model/equilibrium.h, bead by bead. Same bytes as the plain twin.
void draw_beads(const FrictionCone& cone, const UpperRow& above, const double* uniforms, std::size_t beads,
                const LowerRow& out);
void draw_beads_plain(const FrictionCone& cone, const UpperRow& above, const double* uniforms, std::size_t beads,
                      const LowerRow& out);

/// Bit i of `words` (64 to a word) says whether slack[i] is not 0 or more; bits beyond the last bead are 0.
void find_failing(const double* slack, std::size_t beads, std::uint64_t* words);
void find_failing_plain(const double* slack, std::size_t beads, std::uint64_t* words);

/// The first numbers of later attempts (RandomKey::attempt, the same bytes) of eight beads of a layer.
inline constexpr std::size_t attempts_at_once = 8;
void later_numbers(const PhiloxKeys& keys, std::uint32_t sample, int layer,
                   const std::array<std::uint32_t, attempts_at_once>& bead,
                   const std::array<std::uint32_t, attempts_at_once>& attempt,
                   std::array<double, attempts_at_once>& number);

/// While one lives, the kernels above that have a plain twin are that twin in this thread, and who would use the others
/// asks in_use() and goes bead by bead: for measuring what the vectors gain.
class PlainKernels {
 public:
  PlainKernels();
  ~PlainKernels();
  PlainKernels(const PlainKernels&) = delete;
  PlainKernels& operator=(const PlainKernels&) = delete;
  static bool in_use();
};

/// The instruction set that the kernels use on this machine, as Highway names it ("AVX3" is AVX-512).
std::string instruction_set();

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
