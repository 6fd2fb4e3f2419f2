#pragma once
#include <span>
#include <vector>

#include "model/equilibrium.h"
#include "model/lattice.h"
#include "model/pile.h"
#include "sampling/sampler.h"

namespace granuscope {
/// The law "rejection": every bead draws uniformly on its interval; on any failure the whole pile is thrown away. Its
/// density is the product of 1/length over the beads' intervals. The acceptance falls exponentially with the number of
/// beads: tiny piles only, the yardstick for the other laws.
class RejectionSampler final : public Sampler {
 public:
  RejectionSampler(const SamplerSpec& spec, const Lattice& lattice);
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override {
    return solve(sample, load, nullptr, pile);
  }
  std::optional<SamplingFailure> draw_again(std::uint64_t sample, std::span<const double> load, const Pile& first,
                                            Pile& pile) override {
    return solve(sample, load, &first, pile);
  }

 private:
  /// `first`: null unless the pile is drawn again, from the splits of that one.
  std::optional<SamplingFailure> solve(std::uint64_t sample, std::span<const double> load, const Pile* first,
                                       Pile& pile);

  FrictionCone cone_;
  SamplerSpec spec_;
};

/// The law "eloy-clement" (Eloy and Clément, J. Phys. I 7, 1541, 1997, as the paper describes it): layers are drawn
/// from top to bottom, every bead uniformly on its interval; where a layer has a bead without solution, the n layers
/// above it are drawn again completely, n growing in proportion to the number of failures met in this layer since it
/// was last completed. The choices that shape the law:
///
///  1. a failure is an attempt at a layer that does not complete, however many of its beads have no solution;
///  2. n is the number of failures divided by failures_per_layer, rounded up;
///  3. layers on the way down again count their own failures, from zero.
///
/// The number of attempts at one layer grows exponentially with the number of columns.
class EloyClementSampler final : public Sampler {
 public:
  /// Failures of a layer for each further layer above it that is drawn again.
  static constexpr int failures_per_layer = 8;

  EloyClementSampler(const SamplerSpec& spec, const Lattice& lattice);
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override;

 private:
  FrictionCone cone_;
  SamplerSpec spec_;
  std::uint64_t max_solutions_;
  std::vector<int> failures_;            ///< per layer, since it was last completed
  std::vector<std::uint32_t> attempts_;  ///< per layer
};

/// The one pile without friction: every force lies along its contact, H_R = V_R tan, H_L = -V_L tan, and each
/// half of a load, and of the weight of a bead, runs straight down its lattice row; pile.load_line tells how unequal
/// those of a load are, pile.bead_weight what a bead adds. Exact under every law at mu = 0; draws nothing.
void fill_frictionless(std::span<const double> load, Pile& pile);

/// Fills a layer below what stands above it, each bead with the split H_R = choose_split(bead, forces, interval),
/// without any regard to the layers below. False, and the rest of the layer left as it was, at the first bead that has
/// no solution.
template <typename ChooseSplit>
bool fill_layer(const FrictionCone& cone, int layer, Pile& pile, ChooseSplit choose_split) {
  for (int bead = 0; bead < pile.lattice.columns(); ++bead) {
    const Incoming in = incoming(pile, layer, bead);
    const Outgoing out = balance(cone, in);
    const Interval interval = split_interval(cone, out, in.H);
    if (unsolvable(out, interval)) return false;
    const std::size_t at = pile.lattice.index(layer, bead);
    pile.V_R[at] = out.V_R;
    pile.V_L[at] = out.V_L;
    pile.H_R[at] = choose_split(bead, out, interval);
    pile.H_L[at] = in.H - pile.H_R[at];
  }
  return true;
}

}  // namespace granuscope
