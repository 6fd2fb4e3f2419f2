// Source: the moves as polytope.h describes them, made once more on whole piles: every cone of every contact
// bounds a move, and the density is the product over all beads.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>
#include <vector>

#include "model/equilibrium.h"
#include "model/lattice.h"
#include "model/pile.h"
#include "sampling/polytope.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

class PlainChain {
 public:
  PlainChain(const Pile& pile, double lambda) : cone_(pile.mu), pile_(pile), lambda_(lambda) {}

  void null_move(int layer, int bead, UniformPair u) {
    const Lattice& lattice = pile_.lattice;
    Pile change(lattice);
    const auto add = [&](std::vector<double>& forces, int down, int column, double by) {
      if (layer + down < lattice.layers()) forces[lattice.index(layer + down, column)] += by;
    };
    const double root = std::sqrt(3.0);
    const int l = lattice.lower_left(layer, bead), r = lattice.lower_right(layer, bead);
    const int ll = lattice.lower_left(layer + 1, l), lr = lattice.lower_right(layer + 1, l),
              rr = lattice.lower_right(layer + 1, r);
    const int llr = lattice.lower_right(layer + 2, ll), lrr = lattice.lower_right(layer + 2, lr);
    for (const auto& [down, column, by] : {std::tuple{0, bead, 1.0}, {1, l, -1.0}, {2, lr, -1.0}, {3, llr, 1.0}}) {
      add(change.H_R, down, column, by);
    }
    for (const auto& [down, column, by] : {std::tuple{0, bead, -1.0}, {1, r, 1.0}, {2, lr, 1.0}, {3, lrr, -1.0}}) {
      add(change.H_L, down, column, by);
    }
    for (const auto& [down, column, by] : {std::tuple{1, r, root}, {1, l, -root}, {2, lr, -root}, {2, ll, root}}) {
      add(change.V_R, down, column, by);
    }
    for (const auto& [down, column, by] : {std::tuple{1, r, -root}, {1, l, root}, {2, rr, root}, {2, lr, -root}}) {
      add(change.V_L, down, column, by);
    }
    move(change, u, lambda_);
  }

  void ring_move(int layer, double u) {
    Pile change(pile_.lattice);
    for (int i = 0; i < pile_.lattice.columns(); ++i) {
      change.H_R[pile_.lattice.index(layer, i)] = 1;
      change.H_L[pile_.lattice.index(layer, i)] = -1;
    }
    move(change, {u, 0}, 0);
  }

  const Pile& pile() const { return pile_; }
  std::uint64_t accepted() const { return accepted_; }

 private:
  void move(const Pile& change, UniformPair u, double lambda) {
    double low = -std::numeric_limits<double>::infinity(), high = -low;
    // a + b t >= 0
    const auto bound = [&](double a, double b) {
      if (b > 1e-12) low = std::max(low, -a / b);
      if (b < -1e-12) high = std::min(high, -a / b);
    };
    const auto keep_in_cone = [&](double V, double h, double dV, double dh) {
      bound(h - cone_.t_minus() * V, dh - cone_.t_minus() * dV);
      bound(cone_.t_plus() * V - h, cone_.t_plus() * dV - dh);
    };
    for (std::size_t k = 0; k < pile_.V_R.size(); ++k) {
      keep_in_cone(pile_.V_R[k], pile_.H_R[k], change.V_R[k], change.H_R[k]);
      keep_in_cone(pile_.V_L[k], -pile_.H_L[k], change.V_L[k], -change.H_L[k]);
    }
    if (!(low < high)) return;
    const double t = low + u.first * (high - low);
    Pile moved = pile_;
    for (auto forces : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L}) {
      for (std::size_t k = 0; k < pile_.V_R.size(); ++k) (moved.*forces)[k] += t * (change.*forces)[k];
    }
    double ratio = 1;
    for (std::size_t k = 0; k < pile_.V_R.size(); ++k) ratio *= length(pile_, k) / length(moved, k);
    if (u.second >= std::pow(ratio, lambda)) return;
    ++accepted_;
    pile_ = moved;
  }

  double length(const Pile& pile, std::size_t k) const {
    const Interval interval = split_interval(cone_, {pile.V_R[k], pile.V_L[k]}, pile.H_R[k] + pile.H_L[k]);
    return interval.high - interval.low;
  }

  FrictionCone cone_;
  Pile pile_;
  double lambda_;
  std::uint64_t accepted_ = 0;
};

double largest_difference(const Pile& a, const Pile& b) {
  double largest = 0;
  for (auto forces : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L}) {
    for (std::size_t k = 0; k < a.V_R.size(); ++k) {
      largest = std::max(largest, std::abs((a.*forces)[k] - (b.*forces)[k]));
    }
  }
  return largest;
}

TEST_CASE("every move of the chain is the one described, of length, acceptance and pile") {
  const std::vector<double> load = {1, 1.4, 0.7, 1, 1.2};
  for (const LatticeSpec size : {LatticeSpec{5, 6}, {5, 3}, {5, 1}}) {
    for (const double mu : {0.1, 0.3, 0.8, 1.4}) {
      for (const double lambda : {0.0, 0.5, 1.0}) {
        const Lattice lattice(size);
        SamplerSpec spec;
        spec.mu = mu;
        spec.seed = 12;
        Pile start(lattice);
        REQUIRE_FALSE(make_sampler(spec, lattice)->draw(0, load, start));
        PolytopeChain chain(FrictionCone(mu), lattice, lambda);
        chain.set(start);
        PlainChain plain(start, lambda);
        const RandomKey key(12, 3);
        for (std::uint32_t sweep = 1; sweep <= 30; ++sweep) {
          const auto uniforms = [&](int layer, int bead) { return key.chain_move(layer, bead, sweep); };
          chain.sweep(uniforms);
          for (int n = 0; n < size.layers; ++n) {
            for (int i = 0; i < size.columns; ++i) plain.null_move(n, i, uniforms(n, i));
            plain.ring_move(n, uniforms(n, size.columns).first);
          }
          CAPTURE(size.layers, mu, lambda, sweep);
          REQUIRE(chain.accepted_moves() == plain.accepted());
          REQUIRE(largest_difference(chain.pile(), plain.pile()) < 1e-10);
        }
        // The density decides where it is not flat, and does not where it is.
        const bool all_accepted = chain.accepted_moves() == chain.moves();
        CHECK(all_accepted == (lambda == 0 || size.layers == 1));
      }
    }
  }
}

}  // namespace
}  // namespace granuscope
