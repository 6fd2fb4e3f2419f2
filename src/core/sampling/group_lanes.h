#pragma once
#include <hwy/aligned_allocator.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>

namespace granuscope {
/// Piles that are solved side by side, one to a vector lane: bead i of pile k is entry 8 i + k of a row.
inline constexpr std::size_t group_lanes = 8;

/// Memory that vectors of any width may be read from and written to.
template <typename T>
using AlignedArray = hwy::AlignedFreeUniquePtr<T[]>;

/// Throws std::bad_alloc where there is not so much memory.
template <typename T>
AlignedArray<T> aligned_array(std::size_t size) {
  AlignedArray<T> array = hwy::AllocateAligned<T>(size);
  if (array == nullptr) throw std::bad_alloc();
  return array;
}

/// What piles drawn side by side spend their time on.
enum class Phase : std::uint8_t {
  first_draws,  ///< of whole layers
  search,       ///< for beads without solution, and beads that are solved as they are after all
  pairs,        ///< repairs by the pair rule, all piles at once
  one_by_one,   ///< arcs, rings, backtracks, the ends of a layer's order
  finishing     ///< identities, counts, what is kept of layers
};
inline constexpr std::size_t phases = 5;

/// While one lives, piles drawn side by side in this thread note how long each phase takes. Reading the clock twice a
/// repair slows them down, so that only the shares mean something.
class PhaseTimes {
 public:
  PhaseTimes();
  ~PhaseTimes();
  PhaseTimes(const PhaseTimes&) = delete;
  PhaseTimes& operator=(const PhaseTimes&) = delete;

  /// Of the time noted so far; all 0 if there is none.
  std::array<double, phases> shares() const;

  /// That of this thread, if one lives.
  static PhaseTimes* current();
  void begin();
  /// What has passed since begin() or the last end() belongs to `phase`.
  void end(Phase phase);

 private:
  PhaseTimes* outer_;
  std::uint64_t last_ = 0;
  std::array<std::uint64_t, phases> ticks_{};
};

}  // namespace granuscope
