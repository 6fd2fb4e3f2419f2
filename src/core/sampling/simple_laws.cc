#include "sampling/simple_laws.h"

#include <algorithm>

#include "sampling/pile_group.h"
#include "sampling/random_key.h"
#include "support/progress.h"

namespace granuscope {
namespace {

/// Fills the pile with the splits H_R = choose_split(layer, bead, forces, interval); the layer of the first bead
/// without a solution, or -1.
template <typename ChooseSplit>
int try_pile(const FrictionCone& cone, Pile& pile, ChooseSplit choose_split) {
  for (int n = 0; n < pile.lattice.layers(); ++n) {
    const auto choose = [&](int i, Outgoing out, Interval interval) { return choose_split(n, i, out, interval); };
    if (!fill_layer(cone, n, pile, choose)) return n;
  }
  return -1;
}

}  // namespace

RejectionSampler::RejectionSampler(const SamplerSpec& spec, const Lattice& lattice)
    : Sampler(lattice), cone_(spec.mu, lattice.geometry()), spec_(spec) {}

std::optional<SamplingFailure> RejectionSampler::solve(std::uint64_t sample, std::span<const double> load,
                                                       const Pile* first, Pile& pile) {
  begin_pile(spec_, Law::rejection, sample, load, pile);
  const RandomKey key(spec_.seed, sample);
  int failed_layer = 0;
  if (first != nullptr) {
    ++counts_.tries;
    std::vector<double> numbers;
    read_split_uniforms(*first, numbers);
    failed_layer = try_pile(cone_, pile, [&](int n, int i, Outgoing out, Interval interval) {
      const std::size_t at = lattice_.index(n, i);
      return kept_split(*first, at, numbers[at], out, interval);
    });
  }
  for (std::uint64_t attempt = 0; failed_layer >= 0 && attempt < spec_.max_tries; ++attempt) {
    throw_if_interrupted();
    ++counts_.tries;
    // The tries of the first solution count upwards; these count down from the last one, so that they are others.
    const auto number = static_cast<std::uint32_t>(first != nullptr ? most_tries - attempt : attempt + 1);
    failed_layer = try_pile(cone_, pile, [&](int n, int i, Outgoing, Interval interval) {
      ++counts_.uniforms;
      return point_at(interval, key.attempt(n, i, number).first);
    });
  }
  if (failed_layer >= 0) return SamplingFailure{failed_layer};
  counts_.beads += lattice_.beads();
  return std::nullopt;
}

EloyClementSampler::EloyClementSampler(const SamplerSpec& spec, const Lattice& lattice)
    : Sampler(lattice),
      cone_(spec.mu, lattice.geometry()),
      spec_(spec),
      max_solutions_(static_cast<std::uint64_t>(spec.effort * static_cast<double>(lattice.beads()))),
      failures_(static_cast<std::size_t>(lattice.layers())),
      attempts_(static_cast<std::size_t>(lattice.layers())) {}

std::optional<SamplingFailure> EloyClementSampler::draw(std::uint64_t sample, std::span<const double> load,
                                                        Pile& pile) {
  begin_pile(spec_, Law::eloy_clement, sample, load, pile);
  const RandomKey key(spec_.seed, sample);
  std::fill(failures_.begin(), failures_.end(), 0);
  std::fill(attempts_.begin(), attempts_.end(), 0);
  ++counts_.tries;
  std::uint64_t solutions = 0;
  for (int layer = 0; layer < lattice_.layers();) {
    const auto at = static_cast<std::size_t>(layer);
    throw_if_interrupted();
    if (solutions > max_solutions_ || attempts_[at] == most_tries) return SamplingFailure{layer};
    if (++attempts_[at] > 1) ++counts_.redrawn_layers;
    const std::uint64_t drawn_before = counts_.uniforms;
    const bool complete = fill_layer(cone_, layer, pile, [&](int bead, Outgoing, Interval interval) {
      ++counts_.uniforms;
      return point_at(interval, key.attempt(layer, bead, attempts_[at]).first);
    });
    solutions += counts_.uniforms - drawn_before + (complete ? 0 : 1);
    if (complete) {
      failures_[at] = 0;
      ++layer;
    } else {
      const int again = (++failures_[at] + failures_per_layer - 1) / failures_per_layer;
      layer = std::max(0, layer - again);
    }
  }
  counts_.beads += lattice_.beads();
  return std::nullopt;
}

void fill_frictionless(std::span<const double> load, Pile& pile) {
  const Lattice& lattice = pile.lattice;
  const double half_weight = pile.bead_weight / 2;
  pile.load.assign(load.begin(), load.end());
  for (int n = 0; n < lattice.layers(); ++n) {
    for (int i = 0; i < lattice.columns(); ++i) {
      const std::size_t at = lattice.index(n, i);
      // A bead hands the force of its upper-left contact on to its lower right and the other way round.
      pile.V_R[at] = half_weight + (n == 0 ? top_load(load[at], pile.load_line).V_UL
                                           : pile.V_R[lattice.index(n - 1, lattice.upper_left(n, i))]);
      pile.V_L[at] = half_weight + (n == 0 ? top_load(load[at], pile.load_line).V_UR
                                           : pile.V_L[lattice.index(n - 1, lattice.upper_right(n, i))]);
      pile.H_R[at] = pile.V_R[at] * lattice.geometry().tangent;
      pile.H_L[at] = -pile.V_L[at] * lattice.geometry().tangent;
    }
  }
}

}  // namespace granuscope
