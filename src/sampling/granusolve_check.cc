// The invariants of a pile that is being solved (granusolve_state.h), verified.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sampling/granusolve_state.h"
#include "sampling/rounding.h"

namespace granuscope {
namespace {

constexpr double ulps = rounding_ulps * std::numeric_limits<double>::epsilon();

[[noreturn, gnu::cold]] void fail(const char* what, int layer, int bead) {
  throw std::logic_error(fmt::format("granusolve, layer {}, bead {}: {}", layer, bead, what));
}

/// Inline: each bead of each layer is looked at ten times, a third of the time of the tests under the sanitizers.
inline void require(bool holds, const char* what, int layer, int bead) {
  if (!holds) fail(what, layer, bead);
}

}  // namespace

void GranusolveState::check() const {
  const int columns = lattice_.columns();
  require(cursor_ >= 0 && cursor_ <= columns, "the cursor has left the layer", front_, cursor_bead_);
  if (cursor_ < columns) {
    require(position(front_, cursor_bead_) == cursor_, "the bead at the cursor is another one", front_, cursor_bead_);
  }
  require(topmost_pending_ == lattice_.layers(), "some layer is pending", topmost_pending_, 0);
  for (int layer = 0; layer < lattice_.layers(); ++layer) {
    require(pending(layer).count == 0, "a run of beads is pending", layer, pending(layer).first);
  }
  if (front_ > 0) check_row(front_ - 1);
  check_row(front_);
}

/// Splits are held to their intervals within the rounding of the largest force in the row: the arcs add and subtract
/// forces of neighbours, near mu = sqrt 3 of any order of magnitude.
void GranusolveState::check_row(int layer) const {
  double largest = 0;
  for (int bead = 0; bead < lattice_.columns(); ++bead) {
    const std::size_t here = at(layer, bead);
    largest = std::max({largest, arrays_.V_R[here], arrays_.V_L[here], std::abs(arrays_.H[here])});
  }
  for (int bead = 0; bead < lattice_.columns(); ++bead) {
    const std::size_t here = at(layer, bead);
    require(arrays_.unsolved[here] == 0, "it is unsolved, and not pending", layer, bead);
    require(arrays_.rule[here] < static_cast<std::uint8_t>(GranusolveRule::backtrack), "it has no rule", layer, bead);
    require(arrays_.attempts[here] >= attempts_at_first_, "its attempts have begun anew", layer, bead);
    if (awaits_turn(layer, bead)) {
      const bool failing = bit_of(arrays_.failing, bead);
      require(arrays_.attempts[here] == attempts_at_first_ && arrays_.backtracks[here] == 0 &&
                  arrays_.rule[here] == static_cast<std::uint8_t>(GranusolveRule::first_draw),
              "something was done for it before its turn", layer, bead);
      require(failing || arrays_.changed == nullptr || !bit_of(arrays_.changed, bead),
              "it has changed, and does not fail", layer, bead);
      if (failing) continue;
    }
    check_balance(layer, bead);
    const Interval interval = interval_of(layer, bead);
    require(arrays_.V_R[here] >= -ulps * largest && arrays_.V_L[here] >= -ulps * largest, "a contact is pulled", layer,
            bead);
    require(arrays_.H_R[here] >= interval.low - ulps * largest && arrays_.H_R[here] <= interval.high + ulps * largest,
            "its split has left its interval", layer, bead);
    require(arrays_.H_L == nullptr || arrays_.H_L[here] == arrays_.H[here] - arrays_.H_R[here],
            "its two horizontal forces do not add up", layer, bead);
  }
}

void GranusolveState::check_run(int layer, const BeadRun& run) const {
  for (int k = 0, bead = run.first; k < run.count; ++k, bead = lattice_.next(bead)) {
    if (awaits_turn(layer, bead)) continue;
    require(arrays_.unsolved[at(layer, bead)] == 0, "it was to be solved again, and was not", layer, bead);
    check_balance(layer, bead);
  }
}

/// A solved bead takes what its parents hand down, or by rounding the nearest force that it can take.
void GranusolveState::check_balance(int layer, int bead) const {
  const std::size_t here = at(layer, bead);
  const Incoming handed = incoming(layer, bead);
  const double allowance = ulps * (handed.V_UL + handed.V_UR + std::abs(handed.H));
  require(std::abs(arrays_.H[here] - handed.H) <= allowance, "its parents hand down another force", layer, bead);
  const Outgoing out = balance({handed.V_UL, handed.V_UR, arrays_.H[here]});
  require(out.V_R == arrays_.V_R[here] && out.V_L == arrays_.V_L[here], "its vertical forces do not balance", layer,
          bead);
}

}  // namespace granuscope
