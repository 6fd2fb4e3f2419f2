#include "sampling/granusolve_draws.h"

#include <algorithm>
#include <array>

#include "sampling/layer_kernels.h"
#include "sampling/rounding.h"
#include "sampling/split_uniforms.h"

namespace granuscope {
namespace {

/// The numbers kept from a first solution came partly from its later attempts; those of the second solution start here,
/// so that they are independent of them.
constexpr std::uint32_t attempts_before_solving_again = std::uint32_t{1} << 23;

}  // namespace

GranusolveDraws::GranusolveDraws(std::uint64_t seed, GranusolveState& state, GranusolveWork& work)
    : state_(state),
      work_(work),
      key_(seed, 0),
      philox_keys_(seed),
      slack_(static_cast<std::size_t>(state.lattice().columns())),
      from_left_(slack_.size()),
      from_right_(slack_.size()),
      half_across_(slack_.size()) {}

std::uint32_t GranusolveDraws::begin_pile(std::uint64_t sample, const Pile* first) {
  key_ = RandomKey(key_.seed(), sample);
  first_ = first;
  if (first != nullptr) read_split_uniforms(*first, first_numbers_);
  eight_at_once_ = first == nullptr && !PlainKernels::in_use();
  return first == nullptr ? 0 : attempts_before_solving_again;
}

void GranusolveDraws::begin_layer(int layer) {
  state_.move_cursor(layer, 0, state_.order(layer).first_bead);
  const GranusolveArrays& arrays = state_.arrays();
  const std::size_t here = state_.at(layer, 0), columns = slack_.size();
  std::fill_n(&arrays.attempts[here], columns, state_.attempts_at_first());
  std::fill_n(&arrays.unsolved[here], columns, std::uint8_t{0});
  std::fill_n(&arrays.rule[here], columns, static_cast<std::uint8_t>(GranusolveRule::first_draw));
  std::fill_n(&arrays.backtracks[here], columns, std::uint8_t{0});
  draw_in_bulk(layer);
  find_failing(slack_.data(), slack_.size(), arrays.failing);
  if (first_ != nullptr) keep_splits(layer);
  work_.solutions += columns;
  if (first_ == nullptr) work_.counts.uniforms += columns;
}

void GranusolveDraws::draw_in_bulk(int layer) {
  const GranusolveArrays& arrays = state_.arrays();
  const std::size_t columns = slack_.size();
  if (first_ == nullptr) {
    fill_first_uniforms(key_.seed(), key_.sample(), layer, arrays.first_uniform, columns);
  } else {
    std::copy_n(&first_numbers_[state_.at(layer, 0)], columns, arrays.first_uniform);
  }
  const auto row = [&](std::size_t from) {
    const std::size_t here = state_.at(layer, 0) + from;
    return LowerRow{.V_R = &arrays.V_R[here],
                    .V_L = &arrays.V_L[here],
                    .H = &arrays.H[here],
                    .H_R = &arrays.H_R[here],
                    .H_L = &arrays.H_L[here],
                    .slack = &slack_[from]};
  };
  const FrictionCone& cone = state_.cone();
  const double half_weight = state_.half_weight();
  if (layer == 0) {
    for (std::size_t i = 0; i < columns; ++i) {
      const Incoming load = top_load(state_.load()[i], state_.load_line());
      from_left_[i] = load.V_UL;
      from_right_[i] = load.V_UR;
      half_across_[i] = load.H / 2;
    }
    const double* const across = half_across_.data();
    draw_beads(cone,
               {.V_UL = from_left_.data(),
                .V_UR = from_right_.data(),
                .H_UL = across,
                .H_UR = across,
                .half_weight = half_weight},
               arrays.first_uniform, columns, row(0));
    return;
  }
  const auto above = [&](std::size_t upper_left, std::size_t upper_right) {
    const std::size_t a = state_.at(layer - 1, 0) + upper_left, b = state_.at(layer - 1, 0) + upper_right;
    return UpperRow{.V_UL = &arrays.V_R[a],
                    .V_UR = &arrays.V_L[b],
                    .H_UL = &arrays.H_R[a],
                    .H_UR = &arrays.H_L[b],
                    .half_weight = half_weight};
  };
  // Away from the seam the parents of a bead stand side by side; the seam's bead is a run of its own.
  const std::size_t first = layer % 2 == 0 ? 1 : 0, seam = layer % 2 == 0 ? 0 : columns - 1;
  draw_beads(cone, above(0, 1), &arrays.first_uniform[first], columns - 1, row(first));
  draw_beads(cone, above(columns - 1, 0), &arrays.first_uniform[seam], 1, row(seam));
}

/// What kept_split adds to the numbers that the layer was drawn in bulk with.
void GranusolveDraws::keep_splits(int layer) {
  const GranusolveArrays& arrays = state_.arrays();
  for (int bead = 0; bead < state_.lattice().columns(); ++bead) {
    const std::size_t here = state_.at(layer, bead);
    if (arrays.V_R[here] == first_->V_R[here] && arrays.V_L[here] == first_->V_L[here]) {
      state_.set_split(layer, bead, first_->H_R[here]);
    }
  }
}

inline double GranusolveDraws::choose_split(int layer, int bead, Outgoing out, Interval interval) {
  const std::size_t here = state_.at(layer, bead);
  if (first_ != nullptr && state_.arrays().unsolved[here] != top_of_backtrack) {
    return kept_split(*first_, here, first_numbers_[here], out, interval);
  }
  // At the front nobody has seen what came of the bead's first number.
  if (first_ == nullptr && layer == state_.front()) {
    return point_at(interval, state_.arrays().first_uniform[state_.at(bead)]);
  }
  return point_at(interval, next_uniforms(layer, bead, 1).first);
}

bool GranusolveDraws::try_draw(int layer, int bead) {
  const FrictionCone& cone = state_.cone();
  Incoming in = state_.incoming(layer, bead);
  Outgoing out = balance(in);
  Interval interval = split_interval(cone, out, in.H);
  if (unsolvable(out, interval)) {
    if (!misses_by_rounding(cone, in)) return false;
    in.H = nearest_solvable(cone, in);
    ++work_.counts.rounded;
    out = balance(in);
    interval = closed(split_interval(cone, out, in.H));
  }
  const GranusolveArrays& arrays = state_.arrays();
  const std::size_t here = state_.at(layer, bead);
  arrays.V_R[here] = out.V_R;
  arrays.V_L[here] = out.V_L;
  arrays.H[here] = in.H;
  state_.set_split(layer, bead, choose_split(layer, bead, out, interval));
  arrays.unsolved[here] = 0;
  return true;
}

void GranusolveDraws::renew_child(int layer, int bead) {
  if (!state_.solved(layer, bead)) {
    if (state_.awaits_turn(layer, bead)) state_.forget_draw(bead);
    return;
  }
  ++work_.solutions;
  if (!try_draw(layer, bead)) {
    // Beyond the rounding allowance after all: it waits like a bead that a backtrack has unsolved.
    state_.unsolve(layer, bead, 1);
  } else if (layer < state_.front()) {
    state_.unsolve(layer + 1, state_.lattice().lower_left(layer, bead), 2);
  }
}

void GranusolveDraws::next_numbers(const ParentArc& arc, int from, std::vector<double>& numbers) {
  constexpr int at_once = attempts_at_once;
  for (int begin = from; begin < arc.count; begin += at_once) {
    const int count = std::min(at_once, arc.count - begin);
    std::array<std::uint32_t, attempts_at_once> beads{}, attempts{};
    std::array<double, attempts_at_once> found{};
    for (int k = 0; k < count; ++k) {
      const auto here = static_cast<std::size_t>(k);
      const int bead = parent_of(state_.lattice(), arc, begin + k);
      beads[here] = static_cast<std::uint32_t>(bead);
      attempts[here] = ++state_.arrays().attempts[state_.at(arc.layer - 1, bead)];
      if (!eight_at_once_) found[here] = key_.attempt(arc.layer - 1, bead, attempts[here]).first;
    }
    if (eight_at_once_) later_numbers(philox_keys_, key_.sample(), arc.layer - 1, beads, attempts, found);
    std::copy_n(found.begin(), count, numbers.begin() + begin);
    work_.counts.uniforms += static_cast<std::uint64_t>(count);
  }
}

}  // namespace granuscope
