// The bumps of the chains at lambda = 0: what they move, that they leave the flat measure as it is, what they save.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <vector>

#include "kit/sampling_statistics.h"
#include "model/audit.h"
#include "model/equilibrium.h"
#include "model/lattice.h"
#include "model/pile.h"
#include "sampling/polytope.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

Pile start_of_bumps(const Lattice& lattice, double mu, std::uint64_t sample = 0) {
  SamplerSpec spec;
  spec.mu = mu;
  spec.seed = 31;
  std::vector<double> load(static_cast<std::size_t>(lattice.columns()), 1.0);
  load[1] = 1.3;
  Pile pile(lattice);
  REQUIRE_FALSE(make_sampler(spec, lattice)->draw(sample, load, pile));
  return pile;
}

constexpr auto all_forces = {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L};

// Source: bumps as polytope.h describes them, made once more on whole piles. Distances are counted step by step from
// neighbour to neighbour, and every cone of every contact bounds a bump.

/// Calls f with the layer, the column and the amount of each bead of a bump; layers may lie below the pile.
template <class F>
void for_each_of_bump(const Lattice& lattice, int layer, int column, int radius, const F& f) {
  const int columns = lattice.columns(), layers = layer + radius;
  std::vector<int> distance(static_cast<std::size_t>(columns * layers), -1);
  const auto at = [&](int n, int i) -> int& { return distance[static_cast<std::size_t>(n * columns + i)]; };
  at(layer, column) = 0;
  for (int d = 0; d < radius; ++d) {
    for (int n = 0; n < layers; ++n) {
      for (int i = 0; i < columns; ++i) {
        if (at(n, i) != d) continue;
        f(n, i, radius - d);
        const auto reach = [&](int down, int beside) {
          const bool there = n + down >= 0 && n + down < layers;
          if (there && at(n + down, beside) < 0) at(n + down, beside) = d + 1;
        };
        reach(0, lattice.next(i)), reach(0, lattice.previous(i));
        reach(1, lattice.lower_left(n, i)), reach(1, lattice.lower_right(n, i));
        reach(-1, lattice.upper_left(n, i)), reach(-1, lattice.upper_right(n, i));
      }
    }
  }
}

/// The change of all forces by the null move of one bead.
void add_plain_null_move(Pile& change, double cotangent, int layer, int bead, double t) {
  const Lattice& lattice = change.lattice;
  const auto add = [&](std::vector<double>& forces, int down, int column, double by) {
    if (layer + down < lattice.layers()) forces[lattice.index(layer + down, column)] += by;
  };
  const double v = cotangent * t;
  const int l = lattice.lower_left(layer, bead), r = lattice.lower_right(layer, bead);
  const int ll = lattice.lower_left(layer + 1, l), lr = lattice.lower_right(layer + 1, l),
            rr = lattice.lower_right(layer + 1, r);
  add(change.H_R, 0, bead, t), add(change.H_R, 1, l, -t), add(change.H_R, 2, lr, -t);
  add(change.H_R, 3, lattice.lower_right(layer + 2, ll), t);
  add(change.H_L, 0, bead, -t), add(change.H_L, 1, r, t), add(change.H_L, 2, lr, t);
  add(change.H_L, 3, lattice.lower_right(layer + 2, lr), -t);
  add(change.V_R, 1, r, v), add(change.V_R, 1, l, -v), add(change.V_R, 2, lr, -v), add(change.V_R, 2, ll, v);
  add(change.V_L, 1, r, -v), add(change.V_L, 1, l, v), add(change.V_L, 2, rr, v), add(change.V_L, 2, lr, -v);
}

void make_plain_bump(Pile& pile, const FrictionCone& cone, int layer, int column, int radius, double u) {
  Pile change(pile.lattice);
  for_each_of_bump(pile.lattice, layer, column, radius, [&](int n, int i, int amount) {
    if (n < pile.lattice.layers()) add_plain_null_move(change, cone.cotangent(), n, i, amount);
  });
  double low = -std::numeric_limits<double>::infinity(), high = -low;
  const auto keep_positive = [&](double slack, double growth) {
    if (growth > 1e-9) low = std::max(low, -slack / growth);
    if (growth < -1e-9) high = std::min(high, -slack / growth);
  };
  const auto keep_in_cone = [&](double V, double h, double dV, double dh) {
    keep_positive(h - cone.t_minus() * V, dh - cone.t_minus() * dV);
    keep_positive(cone.t_plus() * V - h, cone.t_plus() * dV - dh);
  };
  for (std::size_t k = 0; k < pile.V_R.size(); ++k) {
    keep_in_cone(pile.V_R[k], pile.H_R[k], change.V_R[k], change.H_R[k]);
    keep_in_cone(pile.V_L[k], -pile.H_L[k], change.V_L[k], -change.H_L[k]);
  }
  REQUIRE(low < high);
  const double t = low + u * (high - low);
  for (const auto forces : all_forces) {
    for (std::size_t k = 0; k < pile.V_R.size(); ++k) (pile.*forces)[k] += t * (change.*forces)[k];
  }
}

TEST_CASE("every bump is the one described, at every place of its grid") {
  for (const LatticeSpec size : {LatticeSpec{12, 9}, {13, 5}, {24, 14, 45}, {12, 4}}) {
    for (const double mu : {0.1, 0.5, 0.9}) {
      const Lattice lattice(size);
      const FrictionCone cone(mu, lattice.geometry());
      const BumpMoves bumps(cone, lattice);
      Pile pile = start_of_bumps(lattice, mu), plain = pile;
      const RandomKey key(12, 3);
      std::uint64_t moves = 0, expected = 0;
      for (std::uint32_t sweep = 1; sweep <= 6; ++sweep) {
        const auto uniforms = [&](int radius, int number) { return key.chain_move(radius, number, sweep); };
        moves += bumps.sweep(pile, uniforms).accepted;
        int scale = 0;
        for (int r = std::min((size.columns - 4) / 2, size.layers); r >= 4; r /= 2, ++scale) {
          const int step = static_cast<int>(std::sqrt(r)), across = size.columns / step;
          const UniformPair shift = uniforms(scale, 0);
          int number = 0;
          for (int layer = r - 1 + static_cast<int>(shift.first * step); layer < size.layers + r - 1; layer += step) {
            for (int k = 0; k < across; ++k) {
              const int column = static_cast<int>(shift.second * size.columns) + k * size.columns / across;
              make_plain_bump(plain, cone, layer, column % size.columns, r, uniforms(scale, ++number).first);
              ++expected;
            }
          }
        }
        double largest = 0;
        for (const auto forces : all_forces) {
          for (std::size_t k = 0; k < pile.V_R.size(); ++k) {
            largest = std::max(largest, std::abs((pile.*forces)[k] - (plain.*forces)[k]));
          }
        }
        CAPTURE(size.columns, size.layers, size.angle, mu, sweep, moves);
        REQUIRE(largest < 1e-10);
        REQUIRE(moves == expected);
      }
      CHECK(moves > 0);
    }
  }
  CHECK_FALSE(BumpMoves::fit(Lattice({.columns = 11, .layers = 20})));
  CHECK_FALSE(BumpMoves::fit(Lattice({.columns = 20, .layers = 3})));
}

TEST_CASE("bumps keep every balance, cone and identity without any repair") {
  constexpr std::uint32_t sweeps = test::sanitized ? 100 : 500;
  for (const LatticeSpec size : {LatticeSpec{24, 20}, {27, 12, 45}, {12, 30}}) {
    for (const double mu : {0.1, 0.5773502691896258, 0.9}) {
      const Lattice lattice(size);
      Pile pile = start_of_bumps(lattice, mu);
      PolytopeChain chain(FrictionCone(mu, lattice.geometry()), lattice, 0);
      chain.set(pile);
      const RandomKey key(4, 2);
      for (std::uint32_t sweep = 1; sweep <= sweeps; ++sweep) {
        chain.sweep([&](int layer, int bead) { return key.chain_move(layer, bead, sweep); });
      }
      CAPTURE(size.columns, size.layers, size.angle, mu, chain.moves(), chain.accepted_moves());
      CHECK(chain.moves() > sweeps * lattice.beads());
      CHECK(static_cast<double>(chain.accepted_moves()) > 0.99 * static_cast<double>(chain.moves()));
      for (const bool stored : {false, true}) {
        if (stored) chain.store(pile);
        const AuditResult result = audit(stored ? pile : chain.pile());
        CHECK(result.max_balance_residual <= 1e-12);
        CHECK(result.max_cone_violation <= 1e-12);
        assert_identities(stored ? pile : chain.pile());
      }
    }
  }
}

/// Of each layer the thrust, the mean square and cube of the weights, the products of neighbours, and the square of the
/// weight on one half of the ring beyond that on the other.
std::vector<double> moments_of_layers(const Pile& pile) {
  std::vector<double> all;
  const Lattice& lattice = pile.lattice;
  for (int n = 0; n < lattice.layers(); ++n) {
    double thrust = 0, squares = 0, cubes = 0, neighbours = 0, half = 0;
    for (int i = 0; i < lattice.columns(); ++i) {
      const std::size_t at = lattice.index(n, i), beside = lattice.index(n, lattice.next(i));
      const double w = pile.V_R[at] + pile.V_L[at], v = pile.V_R[beside] + pile.V_L[beside];
      thrust += pile.H_R[at] - pile.H_L[at];
      squares += w * w, cubes += w * w * w, neighbours += w * v;
      half += 2 * i < lattice.columns() ? w : -w;
    }
    all.insert(all.end(), {thrust, squares, cubes, neighbours, half * half});
  }
  return all;
}

/// A chain at lambda = 0; one that is made for another law has no bumps.
class FlatChain {
 public:
  FlatChain(const Lattice& lattice, double mu, bool bumps, std::uint64_t number)
      : chain_(FrictionCone(mu), lattice, bumps ? 0 : 1), key_(bumps ? 41 : 42, number) {
    chain_.set_lambda(0);
    chain_.set(start_of_bumps(lattice, mu, 8 * number));
  }
  void run(std::uint32_t sweeps) {
    for (const std::uint32_t end = sweep_ + sweeps; sweep_ < end;) {
      ++sweep_;
      chain_.sweep([&](int layer, int bead) { return key_.chain_move(layer, bead, sweep_); });
    }
  }
  const PolytopeChain& chain() const { return chain_; }

 private:
  PolytopeChain chain_;
  RandomKey key_;
  std::uint32_t sweep_ = 0;
};

void compare_with_null_moves_alone(int chains, double resolution) {
  for (const LatticeSpec size : {LatticeSpec{12, 5}, {13, 8}}) {
    for (const double mu : {0.3, 0.8}) {
      const Lattice lattice(size);
      std::vector<std::vector<test::RunningMean>> means(2);
      for (const bool bumps : {false, true}) {
        std::vector<test::RunningMean>& here = means[bumps ? 1 : 0];
        for (int number = 0; number < chains; ++number) {
          FlatChain flat(lattice, mu, bumps, static_cast<std::uint64_t>(number));
          flat.run(bumps ? 80 : 400);
          constexpr int piles = 8;
          std::vector<double> sums;
          for (int k = 0; k < piles; ++k) {
            flat.run(bumps ? 10 : 40);
            const std::vector<double> moments = moments_of_layers(flat.chain().pile());
            sums.resize(moments.size());
            for (std::size_t j = 0; j < sums.size(); ++j) sums[j] += moments[j] / piles;
          }
          here.resize(sums.size());
          for (std::size_t j = 0; j < sums.size(); ++j) here[j].add(sums[j]);
        }
      }
      for (std::size_t j = 0; j < means[0].size(); ++j) {
        if (!(means[0][j].variance() > 1e-20)) continue;  // fixed by the load
        const auto alone = means[0][j].estimate(), with_bumps = means[1][j].estimate();
        CAPTURE(size.columns, size.layers, mu, j, alone.value, alone.error, with_bumps.value, with_bumps.error);
        CHECK(std::abs(test::sigmas(alone, with_bumps)) < test::sigma_bound(4 * means[0].size()));
        CHECK(std::hypot(alone.error, with_bumps.error) < resolution * std::sqrt(8 * means[0][j].variance()));
      }
    }
  }
}

TEST_CASE("bumps leave the flat measure as null moves alone have it", "[unsanitized]") {
  compare_with_null_moves_alone(test::sanitized ? 100 : 160, test::sanitized ? 0.08 : 0.07);
}

TEST_CASE("bumps leave the flat measure as null moves alone have it, to two percent", "[long]") {
  compare_with_null_moves_alone(2500, 0.02);
}

// Contacts are counted: twelve of a null move, less than 24 r of a bump.
TEST_CASE("with bumps fewer contacts are changed for one independent pile", "[unsanitized]") {
  const Lattice lattice({.columns = 24, .layers = test::sanitized ? 8 : 12});
  constexpr double mu = 0.5;
  const auto contacts_per_pile = [&](bool bumps, std::uint32_t sweeps) {
    FlatChain flat(lattice, mu, bumps, 1);
    flat.run(sweeps / 4);
    std::vector<double> half_weights;
    const std::uint64_t before = flat.chain().moves();
    for (std::uint32_t k = 0; k < sweeps; ++k) {
      flat.run(1);
      double half = 0;
      for (int i = 0; i < lattice.columns(); ++i) {
        const std::size_t at = lattice.index(lattice.layers() - 1, i);
        half += (2 * i < lattice.columns() ? 1 : -1) * (flat.chain().pile().V_R[at] + flat.chain().pile().V_L[at]);
      }
      half_weights.push_back(half);
    }
    const double null_moves = static_cast<double>(lattice.beads());
    const double others = static_cast<double>(flat.chain().moves() - before) / sweeps - null_moves - lattice.layers();
    const double time = autocorrelation_time(half_weights, 24);
    CAPTURE(bumps, time, others);
    CHECK(time < sweeps / 20.0);
    CHECK((others > 0) == bumps);
    return time * (12 * null_moves + 24 * 10 * others);
  };
  CHECK(2 * contacts_per_pile(true, 4000) < contacts_per_pile(false, 40'000));
}

}  // namespace
}  // namespace granuscope
