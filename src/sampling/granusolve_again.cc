// What the sampler does differently when it solves a pile again: a bead keeps the number of its first solution.
#include "sampling/granusolve.h"
#include "sampling/split_numbers.h"

namespace granuscope {

std::optional<SamplingFailure> GranusolveSampler::draw_again(std::uint64_t sample, std::span<const double> load,
                                                             const Pile& first, Pile& pile) {
  first_ = &first;
  read_split_numbers(first, first_numbers_);
  return solve_pile(sample, load, pile);
}

/// What kept_split adds to the numbers that the layer was drawn in bulk with.
void GranusolveSampler::keep_splits(int layer) {
  for (int bead = 0; bead < lattice_.columns(); ++bead) {
    const std::size_t here = at(layer, bead);
    if (state_.V_R[here] == first_->V_R[here] && state_.V_L[here] == first_->V_L[here]) {
      set_split(layer, bead, first_->H_R[here]);
    }
  }
}

double GranusolveSampler::choose_split(int layer, int bead, Outgoing out, Interval interval) {
  const std::size_t here = at(layer, bead);
  if (first_ != nullptr && state_.unsolved[here] != top_of_climb) {
    return kept_split(*first_, here, first_numbers_[here], out, interval);
  }
  // At the front nobody has seen what came of the bead's first number.
  if (first_ == nullptr && layer == front_) return point_at(interval, state_.first_uniform[at(bead)]);
  return point_at(interval, next_uniforms(layer, bead, 1).first);
}

}  // namespace granuscope
