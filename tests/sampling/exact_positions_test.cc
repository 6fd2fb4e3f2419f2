// Source of the expected numbers: the densities themselves. Along a shift of one layer's horizontal forces no length
// changes, so that under every density prod length^-lambda a pile lies uniformly between the two ends that the cones
// set to the shift. Under the flat measure the same holds along every null move. Ends are found here contact by
// contact.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include "kit/sampling_statistics.h"
#include "model/lattice.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

using test::RunningMean;

/// A direction in the space of piles: what a unit step adds to every force.
struct Direction {
  explicit Direction(std::size_t beads) : V_R(beads), V_L(beads), H_R(beads), H_L(beads) {}
  std::vector<double> V_R, V_L, H_R, H_L;
};

Direction layer_shift(const Lattice& lattice, int layer) {
  Direction to(lattice.beads());
  for (int i = 0; i < lattice.columns(); ++i) {
    to.H_R[lattice.index(layer, i)] = 1;
    to.H_L[lattice.index(layer, i)] = -1;
  }
  return to;
}

/// One bead's split, and below it what keeps every other split's share of the balances: solved layer by layer.
Direction null_direction(const Lattice& lattice, int layer, int bead) {
  Direction to(lattice.beads());
  const std::size_t o = lattice.index(layer, bead);
  to.H_R[o] = 1, to.H_L[o] = -1;
  const double root = std::sqrt(3.0);
  const int below = lattice.layers() - 1 - layer;
  const int l = lattice.lower_left(layer, bead), r = lattice.lower_right(layer, bead);
  if (below >= 1) {
    const std::size_t L = lattice.index(layer + 1, l), R = lattice.index(layer + 1, r);
    to.H_R[L] = -1, to.V_R[L] = -root, to.V_L[L] = root;
    to.H_L[R] = 1, to.V_R[R] = root, to.V_L[R] = -root;
  }
  if (below >= 2) {
    const std::size_t ll = lattice.index(layer + 2, lattice.lower_left(layer + 1, l));
    const std::size_t lr = lattice.index(layer + 2, lattice.lower_right(layer + 1, l));
    const std::size_t rr = lattice.index(layer + 2, lattice.lower_right(layer + 1, r));
    to.V_R[ll] = root;
    to.H_R[lr] = -1, to.H_L[lr] = 1, to.V_R[lr] = -root, to.V_L[lr] = -root;
    to.V_L[rr] = root;
  }
  if (below >= 3) {
    const int lr = lattice.lower_right(layer + 1, l);
    to.H_R[lattice.index(layer + 3, lattice.lower_left(layer + 2, lr))] = 1;
    to.H_L[lattice.index(layer + 3, lattice.lower_right(layer + 2, lr))] = -1;
  }
  return to;
}

/// Where between the ends of that direction the pile lies, in [0, 1].
double position_along(const Pile& pile, const Direction& to) {
  const FrictionCone cone(pile.mu);
  double low = -std::numeric_limits<double>::infinity(), high = -low;
  // slack + t * growth >= 0
  const auto keep = [&](double slack, double growth) {
    if (growth > 0) low = std::max(low, -slack / growth);
    if (growth < 0) high = std::min(high, -slack / growth);
  };
  for (std::size_t k = 0; k < pile.lattice.beads(); ++k) {
    keep(pile.H_R[k] - cone.t_minus() * pile.V_R[k], to.H_R[k] - cone.t_minus() * to.V_R[k]);
    keep(cone.t_plus() * pile.V_R[k] - pile.H_R[k], cone.t_plus() * to.V_R[k] - to.H_R[k]);
    keep(-pile.H_L[k] - cone.t_minus() * pile.V_L[k], -to.H_L[k] - cone.t_minus() * to.V_L[k]);
    keep(cone.t_plus() * pile.V_L[k] + pile.H_L[k], cone.t_plus() * to.V_L[k] + to.H_L[k]);
  }
  return -low / (high - low);
}

/// Mean, square and first harmonic of a position less their values if it is uniform, over groups of eight piles and
/// over the directions of each set.
void check_uniform(Law law, double lambda, const Lattice& lattice, const std::vector<std::vector<Direction>>& sets,
                   std::uint64_t groups, double resolution) {
  SamplerSpec spec;
  spec.law = law;
  spec.lambda = lambda;
  spec.mu = 0.3;
  spec.seed = 17;
  const auto sampler = make_sampler(spec, lattice);
  const std::vector<double> load(static_cast<std::size_t>(lattice.columns()), 1.0);
  Pile pile(lattice);
  std::vector<RunningMean> means(3 * sets.size());
  for (std::uint64_t g = 0; g < groups; ++g) {
    std::vector<double> sums(means.size());
    for (std::uint64_t k = 0; k < 8; ++k) {
      if (sampler->draw(8 * g + k, load, pile)) throw std::runtime_error("stuck");
      for (std::size_t d = 0; d < sets.size(); ++d) {
        const double share = 1 / (8.0 * static_cast<double>(sets[d].size()));
        for (const Direction& direction : sets[d]) {
          const double u = position_along(pile, direction);
          sums[3 * d] += (u - 0.5) * share;
          sums[3 * d + 1] += (u * u - 1.0 / 3) * share;
          sums[3 * d + 2] += std::cos(2 * std::numbers::pi * u) * share;
        }
      }
    }
    for (std::size_t j = 0; j < sums.size(); ++j) means[j].add(sums[j]);
  }
  for (std::size_t j = 0; j < means.size(); ++j) {
    const auto found = means[j].estimate();
    CAPTURE(name_of(law), lambda, j, found.value, found.error);
    CHECK(std::abs(found.value) < test::sigma_bound(means.size()) * found.error);
    CHECK(found.error < resolution * (test::sanitized ? 4 : 1));
  }
}

TEST_CASE("a pile lies uniformly along the shift of a layer, under the exact law and every chain", "[unsanitized]") {
  const Lattice lattice({.columns = 5, .layers = 5});
  std::vector<std::vector<Direction>> shifts;
  for (int n = 0; n < lattice.layers(); ++n) shifts.push_back({layer_shift(lattice, n)});
  check_uniform(Law::rejection, 1, lattice, shifts, 4000 / test::share_of_samples, 0.005);
  for (const double lambda : {0.0, 0.5, 1.0}) {
    check_uniform(Law::polytope, lambda, lattice, shifts, 1600 / test::share_of_samples, 0.01);
  }
}

TEST_CASE("under the flat measure a pile lies uniformly along every null move") {
  const Lattice lattice({.columns = 5, .layers = 5});
  std::vector<std::vector<Direction>> moves(static_cast<std::size_t>(lattice.layers()));
  for (int n = 0; n < lattice.layers(); ++n) {
    for (int i = 0; i < lattice.columns(); ++i) {
      moves[static_cast<std::size_t>(n)].push_back(null_direction(lattice, n, i));
    }
  }
  check_uniform(Law::polytope, 0, lattice, moves, 4000 / test::share_of_samples, 0.003);
}

}  // namespace
}  // namespace granuscope
