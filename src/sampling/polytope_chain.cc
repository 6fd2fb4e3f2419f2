#include "sampling/polytope_chain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "model/incoming.h"
#include "sampling/portable_power.h"

namespace granuscope {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

PolytopeChain::PolytopeChain(const FrictionCone& cone, const Lattice& lattice, double lambda)
    : cone_(cone),
      lattice_(lattice),
      lambda_(lambda),
      pile_(lattice),
      H_(lattice.beads()),
      length_(lattice.beads()),
      per_V_low_(1 / (sqrt3 * cone.t_minus())),
      per_V_high_(1 / (sqrt3 * cone.t_plus())),
      per_both_low_(1 / (1 - sqrt3 * cone.t_minus())),
      per_both_high_(1 / (sqrt3 * cone.t_plus() - 1)) {}

double PolytopeChain::length(double V_R, double V_L, double H) const {
  const Interval interval = split_interval(cone_, {V_R, V_L}, H);
  return interval.high - interval.low;
}

void PolytopeChain::set(const Pile& pile) {
  pile_ = pile;
  for (std::size_t k = 0; k < lattice_.beads(); ++k) {
    H_[k] = pile_.H_R[k] + pile_.H_L[k];
    length_[k] = length(pile_.V_R[k], pile_.V_L[k], H_[k]);
  }
}

void PolytopeChain::store(Pile& pile) {
  for (int n = 0; n < lattice_.layers(); ++n) {
    for (int i = 0; i < lattice_.columns(); ++i) {
      const std::size_t here = lattice_.index(n, i);
      const Incoming in = incoming(pile_, n, i);
      const Outgoing out = balance(in);
      pile_.V_R[here] = out.V_R;
      pile_.V_L[here] = out.V_L;
      H_[here] = in.H;
      pile_.H_L[here] = in.H - pile_.H_R[here];
      length_[here] = length(out.V_R, out.V_L, in.H);
    }
  }
  pile = pile_;
}

PolytopeChain::Neighbourhood PolytopeChain::around(int layer, int bead) const {
  const int previous = lattice_.previous(bead), next = lattice_.next(bead);
  const int left = layer % 2 == 0 ? previous : bead, right = layer % 2 == 0 ? bead : next;
  const int below = std::min(3, lattice_.layers() - 1 - layer);
  const auto at = [&](int down, int column) { return lattice_.index(layer + (down <= below ? down : 0), column); };
  return {at(0, bead), at(1, left),  at(1, right), at(2, previous), at(2, bead), at(2, next),
          at(3, left), at(3, right), below};
}

// Three kinds of contact bound t. With h the outward horizontal force, t- V <= h <= t+ V:
//   h += t                  (o, llr, lrr)        -(h - t- V) <= t <= t+ V - h
//   V += sqrt3 t            (outer ones of l, r, ll, rr)
//                                    -(t+ V - h)/(sqrt3 t+) <= t, and t <= (h - t- V)/(sqrt3 t-) or, where t- < 0, >=
//   h -= t, V -= sqrt3 t    (inner ones of l, r; lr)  t <= (h - t- V)/(1 - sqrt3 t-), t <= (t+ V - h)/(sqrt3 t+ - 1)
void PolytopeChain::null_move(int layer, int bead, UniformPair u) {
  ++moves_;
  const Neighbourhood at = around(layer, bead);
  struct Slack {
    double low, high;
  };
  const auto slack = [this](Contact contact) {
    return Slack{contact.h - cone_.t_minus() * contact.V, cone_.t_plus() * contact.V - contact.h};
  };
  const auto smaller = [](Slack a, Slack b) { return Slack{std::min(a.low, b.low), std::min(a.high, b.high)}; };
  Slack of_h = smaller(slack(right(at.o)), slack(left(at.o)));
  Slack of_V{infinity, infinity}, of_both{infinity, infinity};
  if (at.layers_below >= 1) {
    of_V = smaller(slack(left(at.l)), slack(right(at.r)));
    of_both = smaller(slack(right(at.l)), slack(left(at.r)));
  }
  if (at.layers_below >= 2) {
    of_V = smaller(of_V, smaller(slack(right(at.ll)), slack(left(at.rr))));
    of_both = smaller(of_both, smaller(slack(right(at.lr)), slack(left(at.lr))));
  }
  if (at.layers_below == 3) of_h = smaller(of_h, smaller(slack(right(at.llr)), slack(left(at.lrr))));
  double low = -of_h.low, high = of_h.high;
  if (at.layers_below >= 1) {
    low = std::max(low, -of_V.high * per_V_high_);
    high = std::min(high, std::min(of_both.low * per_both_low_, of_both.high * per_both_high_));
    if (cone_.t_minus() > 0) high = std::min(high, of_V.low * per_V_low_);
    if (cone_.t_minus() < 0) low = std::max(low, of_V.low * per_V_low_);
  }
  if (!(low < high)) return;  // a corner of the set, or one that rounding has made
  const double t = point_at({low, high}, u.first), shift = sqrt3 * t;

  std::array<double, 7> lengths;
  double ratio = 1;
  int changed = 0;
  const auto change = [&](std::size_t k, double V_R, double V_L, double H) {
    const double now = length(pile_.V_R[k] + V_R, pile_.V_L[k] + V_L, H_[k] + H);
    lengths[static_cast<std::size_t>(changed++)] = now;
    ratio *= length_[k] / now;
  };
  if (at.layers_below >= 1) {
    change(at.l, -shift, shift, -t);
    change(at.r, shift, -shift, t);
  }
  if (at.layers_below >= 2) {
    change(at.ll, shift, 0, 0);
    change(at.lr, -shift, -shift, 0);
    change(at.rr, 0, shift, 0);
  }
  if (at.layers_below == 3) {
    change(at.llr, 0, 0, t);
    change(at.lrr, 0, 0, -t);
  }
  if (lambda_ > 0) {
    if (std::any_of(lengths.begin(), lengths.begin() + changed, [](double one) { return !(one > 0); })) return;
    // A length that rounding has made vanish (ratio 0 or less) is left at once.
    if (ratio > 0 && ratio < 1 && !(u.second < portable_power(ratio, lambda_))) return;
  }

  ++accepted_;
  const std::array<std::size_t, 7> beads = {at.l, at.r, at.ll, at.lr, at.rr, at.llr, at.lrr};
  for (std::size_t k = 0; k < static_cast<std::size_t>(changed); ++k) length_[beads[k]] = lengths[k];
  pile_.H_R[at.o] += t;
  pile_.H_L[at.o] -= t;
  if (at.layers_below == 0) return;
  pile_.H_R[at.l] -= t;
  H_[at.l] -= t;
  pile_.V_R[at.l] -= shift;
  pile_.V_L[at.l] += shift;
  pile_.H_L[at.r] += t;
  H_[at.r] += t;
  pile_.V_L[at.r] -= shift;
  pile_.V_R[at.r] += shift;
  if (at.layers_below == 1) return;
  pile_.H_R[at.lr] -= t;
  pile_.H_L[at.lr] += t;
  pile_.V_R[at.lr] -= shift;
  pile_.V_L[at.lr] -= shift;
  pile_.V_R[at.ll] += shift;
  pile_.V_L[at.rr] += shift;
  if (at.layers_below == 2) return;
  pile_.H_R[at.llr] += t;
  H_[at.llr] += t;
  pile_.H_L[at.lrr] -= t;
  H_[at.lrr] -= t;
}

void PolytopeChain::ring_move(int layer, double u) {
  ++moves_;
  Interval reach{-infinity, infinity};
  for (int i = 0; i < lattice_.columns(); ++i) {
    for (const Contact& contact : {right(lattice_.index(layer, i)), left(lattice_.index(layer, i))}) {
      reach = intersection(reach, {cone_.t_minus() * contact.V - contact.h, cone_.t_plus() * contact.V - contact.h});
    }
  }
  if (!(reach.low < reach.high)) return;
  ++accepted_;
  const double t = point_at(reach, u);
  for (int i = 0; i < lattice_.columns(); ++i) {
    pile_.H_R[lattice_.index(layer, i)] += t;
    pile_.H_L[lattice_.index(layer, i)] -= t;
  }
}

}  // namespace granuscope
