#include "kit/naive_granusolve.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace granuscope::test {
namespace {

constexpr std::int64_t most_work = 3'000'000;  // single draws in one pile
constexpr int blind_tries = 2000;              // from the whole interval, before the proposals are narrowed

}  // namespace

NaiveGranusolve::NaiveGranusolve(Lattice lattice, double mu, std::uint64_t seed, double bead_weight)
    : lattice_(lattice),
      columns_(lattice.columns()),
      mu_(mu),
      bead_weight_(bead_weight),
      flat_(std::tan(std::atan(1 / std::sqrt(3.0)) - std::atan(mu))),
      steep_(std::tan(std::atan(1 / std::sqrt(3.0)) + std::atan(mu))),
      engine_(seed) {}

double NaiveGranusolve::uniform(Range range) {
  return std::uniform_real_distribution<double>(0, 1)(engine_) * (range.high - range.low) + range.low;
}

void NaiveGranusolve::count_work() {
  if (++work_ > most_work) throw GivenUp{};
}

bool NaiveGranusolve::draw(std::span<const double> load, Pile& pile) {
  const auto layers = static_cast<std::size_t>(lattice_.layers());
  load_.assign(load.begin(), load.end());
  beads_.assign(layers, std::vector<Bead>(static_cast<std::size_t>(columns_)));
  first_.resize(layers);
  direction_.resize(layers);
  for (std::size_t n = 0; n < layers; ++n) {
    first_[n] = std::uniform_int_distribution<int>(0, columns_ - 1)(engine_);
    direction_[n] = std::uniform_int_distribution<int>(0, 1)(engine_) == 0 ? -1 : 1;
  }
  pending_.clear();
  backtracks_.clear();
  work_ = 0;
  later_numbers_ = 0;
  try {
    for (int n = 0; n < lattice_.layers(); ++n) {
      front_ = n;
      for (int k = 0; k < columns_; ++k) {
        const int bead = wrapped(first_[static_cast<std::size_t>(n)] + k * direction_[static_cast<std::size_t>(n)]);
        while (!place(n, bead)) solve_pending();
      }
    }
  } catch (const GivenUp&) {
    return false;
  }
  pile.load = load_;
  pile.mu = mu_;
  pile.bead_weight = bead_weight_;
  pile.law = "naive granusolve";
  for (int n = 0; n < lattice_.layers(); ++n) {
    for (int i = 0; i < columns_; ++i) {
      const Bead& bead = at(n, i);
      const std::size_t here = lattice_.index(n, i);
      pile.V_R[here] = bead.V_R, pile.V_L[here] = bead.V_L;
      pile.H_R[here] = bead.H_R, pile.H_L[here] = bead.H - bead.H_R;
    }
  }
  return true;
}

std::tuple<double, double, double> NaiveGranusolve::received(int layer, int bead) {
  if (layer == 0) {
    const double half = (load_[static_cast<std::size_t>(bead)] + bead_weight_) / 2;
    return {half, half, 0};
  }
  const Bead& a = at(layer - 1, lattice_.upper_left(layer, bead));
  const Bead& b = at(layer - 1, lattice_.upper_right(layer, bead));
  return {a.V_R + bead_weight_ / 2, b.V_L + bead_weight_ / 2, a.H_R + (b.H - b.H_R)};
}

NaiveGranusolve::Range NaiveGranusolve::cone_range(double V_R, double V_L, double H) const {
  return {std::max(flat_ * V_R, H + flat_ * V_L), std::min(steep_ * V_R, H + steep_ * V_L)};
}

bool NaiveGranusolve::solvable(int layer, int bead) {
  const auto [V_UL, V_UR, H] = received(layer, bead);
  const Range range = cone_range(V_UR + std::sqrt(3.0) * H, V_UL - std::sqrt(3.0) * H, H);
  return range.low <= range.high;
}

NaiveGranusolve::Range NaiveGranusolve::solvable_H(double V_UL, double V_UR) const {
  const auto works = [&](double H) {
    const Range range = cone_range(V_UR + std::sqrt(3.0) * H, V_UL - std::sqrt(3.0) * H, H);
    return range.low <= range.high;
  };
  // Forces along both contacts always work; |H| beyond the sum of the vertical forces never does.
  const auto edge = [&](double outside) {
    double inside = (V_UL - V_UR) / std::sqrt(3.0);
    for (int k = 0; k < 54; ++k) {
      const double middle = (inside + outside) / 2;
      (works(middle) ? inside : outside) = middle;
    }
    return inside;
  };
  return {edge(-(V_UL + V_UR)), edge(V_UL + V_UR)};
}

/// Draws the bead; if that is impossible changes its parents; false if only a backtrack was left.
bool NaiveGranusolve::place(int layer, int bead) {
  count_work();
  if (!solvable(layer, bead)) {
    if (!repair(layer, bead)) {
      backtrack(layer, bead);
      return false;
    }
  }
  redraw(layer, bead);
  return true;
}

void NaiveGranusolve::redraw(int layer, int bead) {
  const auto [V_UL, V_UR, H] = received(layer, bead);
  Bead& here = at(layer, bead);
  here.V_R = V_UR + std::sqrt(3.0) * H;
  here.V_L = V_UL - std::sqrt(3.0) * H;
  here.H = H;
  const Range range = cone_range(here.V_R, here.V_L, H);
  here.H_R = uniform({range.low, std::max(range.low, range.high)});
  here.solved = true;
  if (layer < front_) ++later_numbers_;
}

void NaiveGranusolve::solve_pending() {
  while (!pending_.empty()) {
    const auto next = *pending_.begin();
    if (place(std::get<0>(next), std::get<2>(next))) pending_.erase(next);
  }
}

bool NaiveGranusolve::repair(int layer, int bead) {
  if (pair(layer, bead)) return true;
  for (int count = 4; count < columns_; count *= 2) {
    const Outcome outcome = arc(layer, bead, count);
    if (outcome == Outcome::repaired) return true;
    if (outcome == Outcome::infeasible) return false;
  }
  return ring(layer, bead);
}

std::vector<NaiveGranusolve::Constraint> NaiveGranusolve::constraints(int layer, int failed,
                                                                      const std::vector<int>& parents,
                                                                      bool free_outside) {
  const std::size_t zero = parents.size();
  std::vector<Constraint> all;
  for (std::size_t k = 0; k < parents.size(); ++k) {
    const Bead& own = at(layer - 1, parents[k]);
    const Range range = cone_range(own.V_R, own.V_L, own.H);
    all.push_back({zero, k, range.high});
    all.push_back({k, zero, -range.low});
  }
  const auto index_of = [&](int parent) {
    return static_cast<std::size_t>(std::find(parents.begin(), parents.end(), parent) - parents.begin());
  };
  for (int child = 0; child < columns_; ++child) {
    if (child != failed && !at(layer, child).solved) continue;
    const int P = lattice_.upper_left(layer, child), Q = lattice_.upper_right(layer, child);
    const std::size_t p = index_of(P), q = index_of(Q);
    if (p == zero && q == zero) continue;
    if (free_outside && (p == zero || q == zero)) continue;
    const Bead &left = at(layer - 1, P), &right = at(layer - 1, Q);
    // H = H_R(P) + H(Q) - H_R(Q) has to lie in the band.
    const Range band = solvable_H(left.V_R, right.V_L);
    const double held_p = p == zero ? left.H_R : 0, held_q = q == zero ? right.H_R : 0;
    all.push_back({q, p, band.high - right.H - held_p + held_q});
    all.push_back({p, q, -(band.low - right.H - held_p + held_q)});
  }
  return all;
}

/// Shortest paths from a node joined to all others: they exist unless a cycle is negative, that is, unless the
/// constraints contradict each other.
bool NaiveGranusolve::feasible(std::size_t variables, const std::vector<Constraint>& constraints) {
  std::vector<double> distance(variables + 1, 0.0);
  for (std::size_t round = 0; round <= variables + 1; ++round) {
    bool changed = false;
    for (const Constraint& c : constraints) {
      if (distance[c.from] + c.bound < distance[c.to] - 1e-14 * (std::abs(distance[c.to]) + std::abs(c.bound))) {
        distance[c.to] = distance[c.from] + c.bound;
        changed = true;
      }
    }
    if (!changed) return true;
  }
  return false;
}

NaiveGranusolve::Range NaiveGranusolve::shadow(std::size_t variable, std::size_t variables,
                                               const std::vector<Constraint>& constraints) {
  // The tightest bound on x - 0 is the shortest path from 0 to x, the one on 0 - x that from x to 0.
  const auto shortest = [&](std::size_t from, std::size_t to) {
    std::vector<double> distance(variables + 1, std::numeric_limits<double>::infinity());
    distance[from] = 0;
    for (std::size_t round = 0; round < variables; ++round) {
      for (const Constraint& c : constraints) distance[c.to] = std::min(distance[c.to], distance[c.from] + c.bound);
    }
    return distance[to];
  };
  return {-shortest(variable, variables), shortest(variables, variable)};
}

bool NaiveGranusolve::pair(int layer, int bead) {
  const int A = lattice_.upper_left(layer, bead), B = lattice_.upper_right(layer, bead);
  const auto all = constraints(layer, bead, {A, B}, false);
  if (!feasible(2, all)) return false;
  Bead &a = at(layer - 1, A), &b = at(layer - 1, B);
  Range range_a = cone_range(a.V_R, a.V_L, a.H), range_b = cone_range(b.V_R, b.V_L, b.H);
  const int left = wrapped(bead - 1), right = wrapped(bead + 1);
  int tries = 0;
  do {
    count_work();
    if (++tries == blind_tries) range_a = shadow(0, 2, all), range_b = shadow(1, 2, all);
    a.H_R = uniform(range_a);
    b.H_R = uniform(range_b);
  } while (!solvable(layer, bead) || (at(layer, left).solved && !solvable(layer, left)) ||
           (at(layer, right).solved && !solvable(layer, right)));
  later_numbers_ += 2;
  renew_children(layer, bead, {A, B});
  return true;
}

NaiveGranusolve::Outcome NaiveGranusolve::arc(int layer, int bead, int count) {
  // Numbered along the direction of the layer, the failed bead below the two in the middle; drawn from the far end
  // back.
  const int step = direction_[static_cast<std::size_t>(layer)];
  const int near = step > 0 ? lattice_.upper_left(layer, bead) : lattice_.upper_right(layer, bead);
  std::vector<int> parents;
  std::vector<std::size_t> order;
  for (int k = 0; k < count; ++k) {
    parents.emplace_back(wrapped(near + step * (k - (count / 2 - 1))));
    order.insert(order.begin(), static_cast<std::size_t>(k));
  }
  if (!feasible(parents.size(), constraints(layer, bead, parents, true))) return Outcome::infeasible;
  const auto held = constraints(layer, bead, parents, false);
  if (!feasible(parents.size(), held)) return Outcome::too_narrow;
  draw_one_by_one(layer, parents, held, order);
  renew_children(layer, bead, parents);
  return Outcome::repaired;
}

bool NaiveGranusolve::ring(int layer, int bead) {
  // The near parent first, then all others from its far side back.
  const int step = direction_[static_cast<std::size_t>(layer)];
  const int near = step > 0 ? lattice_.upper_left(layer, bead) : lattice_.upper_right(layer, bead);
  std::vector<int> parents;
  std::vector<std::size_t> order;
  for (int k = 0; k < columns_; ++k) {
    parents.emplace_back(wrapped(near + step * k));
    order.insert(order.begin() + (k > 0), static_cast<std::size_t>(k));
  }
  const auto all = constraints(layer, bead, parents, false);
  if (!feasible(parents.size(), all)) return false;
  draw_one_by_one(layer, parents, all, order);
  renew_children(layer, bead, parents);
  return true;
}

void NaiveGranusolve::draw_one_by_one(int layer, const std::vector<int>& parents, std::vector<Constraint> constraints,
                                      const std::vector<std::size_t>& order) {
  const std::size_t zero = parents.size();
  later_numbers_ += static_cast<int>(order.size());
  for (const std::size_t k : order) {
    Bead& bead = at(layer - 1, parents[k]);
    Range range = cone_range(bead.V_R, bead.V_L, bead.H);
    const Range narrow = shadow(k, parents.size(), constraints);
    int tries = 0;
    constraints.push_back({zero, k, 0});
    constraints.push_back({k, zero, 0});
    Constraint &above = constraints[constraints.size() - 2], &below = constraints.back();
    do {
      count_work();
      if (++tries == blind_tries) range = narrow;
      bead.H_R = uniform(range);
      above.bound = bead.H_R;
      below.bound = -bead.H_R;
    } while (!feasible(parents.size(), constraints));
  }
}

void NaiveGranusolve::renew_children(int layer, int failed, const std::vector<int>& parents) {
  for (int child = 0; child < columns_; ++child) {
    const auto shares = [&](int parent) { return std::find(parents.begin(), parents.end(), parent) != parents.end(); };
    if (child == failed || !at(layer, child).solved) continue;
    if (!shares(lattice_.upper_left(layer, child)) && !shares(lattice_.upper_right(layer, child))) continue;
    redraw(layer, child);
    if (layer + 1 < lattice_.layers()) {
      unsolve(layer + 1, lattice_.lower_left(layer, child));
      unsolve(layer + 1, lattice_.lower_right(layer, child));
    }
  }
}

int NaiveGranusolve::backtracks() const {
  int all = 0;
  for (const auto& [bead, backtracks] : backtracks_) all += backtracks;
  return all;
}

void NaiveGranusolve::backtrack(int layer, int bead) {
  const int height = 2 + backtracks_[{layer, bead}]++;
  int leftmost = bead, top = layer, wider = 0;
  for (int k = 0; k < height; ++k) {
    if (top > 0) {
      leftmost = lattice_.upper_left(top, leftmost);
      --top;
    } else {
      ++wider;
    }
  }
  const int count = std::min(columns_, layer - top + 1 + 2 * wider);
  for (int k = 0; k < count; ++k) unsolve(top, wrapped(leftmost - wider + k));
}

void NaiveGranusolve::unsolve(int layer, int bead) {
  if (layer >= lattice_.layers() || !at(layer, bead).solved) return;
  at(layer, bead).solved = false;
  const auto n = static_cast<std::size_t>(layer);
  pending_.insert({layer, wrapped((bead - first_[n]) * direction_[n]), bead});
  unsolve(layer + 1, lattice_.lower_left(layer, bead));
  unsolve(layer + 1, lattice_.lower_right(layer, bead));
}

}  // namespace granuscope::test
