// Source: Coulomb's cone and the balances, written again here, and difference constraints decided by shortest paths.
// Once the top layer's splits are drawn, everything that the splits a_j of the next layer must fulfil so that the layer
// below is solvable has the form a_j - a_k <= b: the shortest paths between all pairs tell whether there is a solution,
// and between which numbers each a_j may lie.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <random>

#include "model/audit.h"
#include "model/lattice.h"
#include "sampling/sampler.h"
#include "sampling/simple_laws.h"
#include "support/error.h"

namespace granuscope {
namespace {

constexpr std::size_t columns = 6;
constexpr std::array<double, columns> half_loaded = {0, 0, 0, 1, 1, 1};
/// Sums of a few forces of order one round by less; what is left of a range of that width is one value.
constexpr double rounding = 1e-12;

struct Range {
  double low, high;
};

struct Received {
  double V_UL, V_UR, H;
};

class Cone {
 public:
  explicit Cone(double mu)
      : flat_((1 / std::sqrt(3.0) - mu) / (1 + mu / std::sqrt(3.0))),
        steep_((1 / std::sqrt(3.0) + mu) / (1 - mu / std::sqrt(3.0))) {}

  Range split(const Received& in) const {
    const double V_R = right(in), V_L = left(in);
    return {std::max(flat_ * V_R, flat_ * V_L + in.H), std::min(steep_ * V_R, steep_ * V_L + in.H)};
  }
  /// H with which a bead is solvable.
  Range band(double V_UL, double V_UR) const {
    const double k = std::sqrt(3.0) * (flat_ + steep_) - 1;
    return {std::max(-V_UR / std::sqrt(3.0), (flat_ * V_UL - steep_ * V_UR) / k),
            std::min(V_UL / std::sqrt(3.0), (steep_ * V_UL - flat_ * V_UR) / k)};
  }
  static double right(const Received& in) { return in.V_UR + std::sqrt(3.0) * in.H; }
  static double left(const Received& in) { return in.V_UL - std::sqrt(3.0) * in.H; }

 private:
  double flat_, steep_;
};

using Layer = std::array<Received, columns>;

/// What the beads between the splits a_j and a_{j+1} receive.
Layer below(const Layer& layer, const std::array<double, columns>& a) {
  Layer next;
  for (std::size_t j = 0; j < columns; ++j) {
    const std::size_t k = (j + 1) % columns;
    next[j] = {Cone::right(layer[j]), Cone::left(layer[k]), a[j] + layer[k].H - a[k]};
  }
  return next;
}

Layer top_layer() {
  Layer top;
  for (std::size_t j = 0; j < columns; ++j) top[j] = {half_loaded[j] / 2, half_loaded[j] / 2, 0};
  return top;
}

/// Between which numbers each split of a layer may lie if the layer below is to be solvable, or nothing.
std::optional<std::array<Range, columns>> ranges_of(const Cone& cone, const Layer& layer) {
  constexpr std::size_t zero = columns, nodes = columns + 1;
  std::array<std::array<double, nodes>, nodes> most{};  // most[i][j]: the least known bound of x_j - x_i
  for (auto& row : most) row.fill(INFINITY);
  for (std::size_t i = 0; i < nodes; ++i) most[i][i] = 0;
  const auto bound = [&](std::size_t from, std::size_t to, double by) {
    most[from][to] = std::min(most[from][to], by);
  };
  for (std::size_t j = 0; j < columns; ++j) {
    const std::size_t k = (j + 1) % columns;
    const Range own = cone.split(layer[j]), H = cone.band(Cone::right(layer[j]), Cone::left(layer[k]));
    bound(zero, j, own.high);
    bound(j, zero, -own.low);
    bound(k, j, H.high - layer[k].H);
    bound(j, k, layer[k].H - H.low);
  }
  for (std::size_t via = 0; via < nodes; ++via) {
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t j = 0; j < nodes; ++j) bound(i, j, most[i][via] + most[via][j]);
    }
  }
  std::array<Range, columns> ranges{};
  for (std::size_t i = 0; i < nodes; ++i) {
    if (most[i][i] < -rounding) return std::nullopt;
    if (i < columns) ranges[i] = {-most[i][zero], most[zero][i]};
  }
  return ranges;
}

/// A top layer drawn until the layer below it is solvable.
Layer random_second_layer(const Cone& cone, std::mt19937_64& engine) {
  const Layer top = top_layer();
  const auto allowed = ranges_of(cone, top);
  REQUIRE(allowed.has_value());
  for (;;) {
    std::array<double, columns> a{};
    for (std::size_t j = 0; j < columns; ++j) {
      a[j] = std::uniform_real_distribution<double>(0, 1)(engine);
      a[j] = (*allowed)[j].low + a[j] * ((*allowed)[j].high - (*allowed)[j].low);
    }
    const Layer second = below(top, a);
    if (std::all_of(second.begin(), second.end(), [&](const Received& in) {
          const Range band = cone.band(in.V_UL, in.V_UR);
          return in.H >= band.low - rounding && in.H <= band.high + rounding;
        }))
      return second;
  }
}

TEST_CASE("beside unloaded beads: no solution below 1/sqrt 3, single values at it, ranges above it") {
  constexpr unsigned seed = 17;
  constexpr int top_layers = 200;
  CAPTURE(seed);
  for (const double mu : {0.3, 0.57, 1 / std::sqrt(3.0), 0.6, 1.0}) {
    const Cone cone(mu);
    std::mt19937_64 engine(seed);
    int solvable = 0, with_single_value = 0;
    for (int k = 0; k < top_layers; ++k) {
      const Layer second = random_second_layer(cone, engine);
      const auto ranges = ranges_of(cone, second);
      if (!ranges) continue;
      ++solvable;
      // A bead that receives something, and yet has no choice although its own interval leaves it one.
      for (std::size_t j = 0; j < columns; ++j) {
        const Range own = cone.split(second[j]);
        if (own.high - own.low > 1e-3 && (*ranges)[j].high - (*ranges)[j].low < rounding) {
          ++with_single_value;
          break;
        }
      }
    }
    CAPTURE(mu, solvable, with_single_value);
    if (mu < 0.571) CHECK(solvable == 0);
    if (mu > 0.571) CHECK(solvable > top_layers / 2);
    CHECK(with_single_value == (mu > 0.571 && mu < 0.59 ? solvable : 0));
  }
}

TEST_CASE("the frictionless pile solves a half-loaded top at any friction, but a law needs more than single piles") {
  const Lattice lattice({.columns = columns, .layers = 30});
  const std::vector<double> load(half_loaded.begin(), half_loaded.end());
  for (const double mu : {0.3, std::nextafter(tan30, 0.0), tan30, std::nextafter(tan30, 1.0), 1.0}) {
    Pile pile(lattice);
    pile.load = load;
    fill_frictionless(load, pile);
    pile.mu = mu;
    CAPTURE(mu);
    CHECK(audit(pile).max_balance_residual <= rounding);
    CHECK(audit(pile).max_cone_violation <= rounding);
    SamplerSpec spec;
    spec.mu = mu;
    const auto sampler = make_sampler(spec, lattice);
    if (mu < tan30) {
      CHECK_THROWS_AS(sampler->draw(0, load, pile), InputError);
    } else if (!sampler->draw(0, load, pile)) {
      CHECK(audit(pile).max_balance_residual <= 1e-10);
      CHECK(audit(pile).max_cone_violation <= 1e-10);
    } else {
      CHECK(mu == tan30);  // stuck, by name
    }
  }
}

}  // namespace
}  // namespace granuscope
