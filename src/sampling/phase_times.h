#pragma once
#include <array>
#include <cstdint>

namespace granuscope {

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
