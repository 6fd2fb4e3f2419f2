#include "sampling/pile_group.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "sampling/identity_kernels.h"
#include "sampling/sampler.h"

namespace granuscope {

namespace {

using Lanes = std::array<double, group_lanes>;

double total(std::span<const double> load) { return std::accumulate(load.begin(), load.end(), 0.0); }

/// Layer `layer` of all piles, entry by entry as they lie; the layer's neighbours above as the kernel wants them.
RowFacts check_layer(const PileGroup& group, int layer) {
  RowFacts facts;
  const auto columns = static_cast<std::size_t>(group.lattice.columns());
  const std::size_t here = group.row(layer);
  if (layer < 2) {
    check_weights(group.V_R + here, group.V_L + here, group.H_R + here, columns * group.stride, facts);
    return facts;
  }
  const std::size_t up = group.row(layer - 1), above = group.row(layer - 2);
  // Away from the seam the parents of a bead stand side by side; the seam's bead is a run of its own.
  const std::size_t first = layer % 2 == 0 ? 1 : 0, seam = layer % 2 == 0 ? 0 : columns - 1;
  const auto run = [&](std::size_t bead, std::size_t left, std::size_t right, std::size_t beads) {
    const std::size_t at = bead * group.stride, l = up + left * group.stride, r = up + right * group.stride;
    check_beads({group.V_R + here + at, group.V_L + here + at, group.H_R + here + at, group.V_R + above + at,
                 group.V_L + above + at, group.H_R + l, group.H_L + l, group.H_R + r, group.H_L + r},
                beads * group.stride, facts);
  };
  run(first, 0, 1, columns - 1);
  run(seam, columns - 1, 0, 1);
  return facts;
}

/// Of a row whose entries all belong to one pile: the eight running values together, in entry 0.
void gather(RowFacts& facts) {
  const auto largest = [](Lanes& lanes) { lanes[0] = *std::max_element(lanes.begin(), lanes.end()); };
  facts.weight_sum[0] = total(facts.weight_sum);
  facts.residual_sum[0] = total(facts.residual_sum);
  largest(facts.largest_weight);
  largest(facts.largest_H);
  largest(facts.largest_residual);
}

}  // namespace

PileGroup group_of(const Pile& pile, const std::span<const double>& load) {
  return {.lattice = pile.lattice,
          .V_R = pile.V_R.data(),
          .V_L = pile.V_L.data(),
          .H_R = pile.H_R.data(),
          .H_L = pile.H_L.data(),
          .loads = {&load, 1},
          .mu = pile.mu,
          .law = pile.law,
          .seed = pile.seed,
          .first_sample = pile.sample};
}

Pile pile_of(const PileGroup& group, std::size_t k) {
  Pile pile(group.lattice);
  const std::size_t beads = group.lattice.beads();
  for (const auto& [from, to] : {std::pair{group.V_R, &pile.V_R}, std::pair{group.V_L, &pile.V_L},
                                 std::pair{group.H_R, &pile.H_R}, std::pair{group.H_L, &pile.H_L}}) {
    for (std::size_t bead = 0; bead < beads; ++bead) (*to)[bead] = from[bead * group.stride + k];
  }
  pile.load.assign(group.loads[k].begin(), group.loads[k].end());
  pile.mu = group.mu;
  pile.law = group.law;
  pile.seed = group.seed;
  pile.sample = group.first_sample + k;
  return pile;
}

std::array<IdentityResiduals, group_lanes> identity_residuals(const PileGroup& group) {
  std::array<IdentityResiduals, group_lanes> worst{};
  Lanes loads{};
  for (std::size_t k = 0; k < group.piles; ++k) loads[k] = total(group.loads[k]);
  // Largest forces of the two layers above the one being checked: weights of both, horizontal forces of the nearer one.
  Lanes above{}, middle{}, H{};
  for (int layer = 0; layer < group.lattice.layers(); ++layer) {
    RowFacts facts = check_layer(group, layer);
    if (group.stride == 1) gather(facts);
    for (std::size_t k = 0; k < group.piles; ++k) {
      const auto worse = [](double so_far, double residual) {
        return std::isfinite(residual) ? std::max(so_far, residual) : std::numeric_limits<double>::infinity();
      };
      IdentityResiduals& pile = worst[k];
      pile.weight_sum = worse(pile.weight_sum, std::abs(facts.weight_sum[k] - loads[k]) / loads[k]);
      if (layer >= 2) {
        const double largest = std::max({above[k], H[k], facts.largest_weight[k]});
        // Vector maxima pass over what is not a number; its sum does not.
        if (!std::isfinite(facts.residual_sum[k])) pile.wave_equation = std::numeric_limits<double>::infinity();
        if (largest > 0) pile.wave_equation = worse(pile.wave_equation, facts.largest_residual[k] / largest);
      }
      above[k] = middle[k];
      middle[k] = facts.largest_weight[k];
      H[k] = facts.largest_H[k];
    }
  }
  return worst;
}

void assert_identities(const PileGroup& group, std::span<const std::optional<SamplingFailure>> failures) {
  const auto residuals = identity_residuals(group);
  for (std::size_t k = 0; k < group.piles; ++k) {
    if (!failures[k]) assert_identities(residuals[k], group.law, group.mu, group.seed, group.first_sample + k);
  }
}

}  // namespace granuscope
