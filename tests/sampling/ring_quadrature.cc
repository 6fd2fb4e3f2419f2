#include "ring_quadrature.h"

#include <algorithm>
#include <cmath>

namespace granuscope::test {
namespace {

struct SplitRange {
  double low, high;
  double length() const { return high - low; }
};

/// The cone and one bead, written from Coulomb's law and the balances.
struct Bead {
  double flat, steep;
  explicit Bead(double mu)
      : flat(std::tan(std::atan(1 / std::sqrt(3.0)) - std::atan(mu))),
        steep(std::tan(std::atan(1 / std::sqrt(3.0)) + std::atan(mu))) {}
  SplitRange split(double V_UL, double V_UR, double H) const {
    const double V_R = V_UR + std::sqrt(3.0) * H, V_L = V_UL - std::sqrt(3.0) * H;
    return {std::max(flat * V_R, flat * V_L + H), std::min(steep * V_R, steep * V_L + H)};
  }
};

constexpr int sub = 3;  ///< points per cell and direction over which a kernel is averaged

std::size_t next(std::size_t i) { return (i + 1) % 4; }

/// The splits of one layer on the ring, a_i on cells of its own interval. The bead between a_i and a_{i+1}, with
/// V_UL = V_R of the one and V_UR = V_L of the other, receives H = a_i + H_{i+1} - a_{i+1}; `weight` of its length.
class Ring {
 public:
  Ring(const Bead& bead, const RingForces& in, int cells) : bead_(bead), in_(in), cells_(cells) {
    for (std::size_t i = 0; i < 4; ++i) {
      own_[i] = bead.split(in.V_UL[i], in.V_UR[i], in.H[i]);
      V_R_[i] = in.V_UR[i] + std::sqrt(3.0) * in.H[i];
      V_L_[i] = in.V_UL[i] - std::sqrt(3.0) * in.H[i];
    }
  }
  bool solvable() const {
    return std::all_of(own_.begin(), own_.end(), [](SplitRange own) { return own.length() > 0; });
  }
  double volume() const { return own_[0].length() * own_[1].length() * own_[2].length() * own_[3].length(); }
  double centre(std::size_t i, int cell) const { return own_[i].low + (cell + 0.5) * own_[i].length() / cells_; }

  /// kernel_[i][x][y]: mean over the cells x of a_i and y of a_{i+1} of the weight of the bead between them.
  void fill_kernels(const std::function<double(double)>& weight) {
    const auto n = static_cast<std::size_t>(cells_);
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t j = next(i);
      kernel_[i].assign(n * n, 0);
      const int points = cells_ * sub;
      for (int x = 0; x < points; ++x) {
        for (int y = 0; y < points; ++y) {
          const double a = own_[i].low + (x + 0.5) * own_[i].length() / points;
          const double b = own_[j].low + (y + 0.5) * own_[j].length() / points;
          const double length = bead_.split(V_R_[i], V_L_[j], a + in_.H[j] - b).length();
          if (length > 0)
            kernel_[i][static_cast<std::size_t>(x / sub) * n + static_cast<std::size_t>(y / sub)] += weight(length);
        }
      }
      for (double& one : kernel_[i]) one /= sub * sub;
    }
  }

  /// Sum over all cells of the product of the four kernels (the trace of their product), divided by the cells;
  /// `moments` (if not null) receives the 14 moments times that.
  double sum(std::array<double, SplitMoments::per_layer>* moments) const {
    const auto n = static_cast<std::size_t>(cells_);
    // From a_0 over a_1 to a_2, and from a_2 over a_3 back to a_0.
    std::vector<double> there(n * n), back(n * n);
    multiply(kernel_[0], kernel_[1], there);
    multiply(kernel_[2], kernel_[3], back);
    const double cell = 1.0 / std::pow(cells_, 4);
    double total = 0;
    for (std::size_t x = 0; x < n; ++x) {
      for (std::size_t y = 0; y < n; ++y) total += there[x * n + y] * back[y * n + x];
    }
    if (moments != nullptr) add_moments(there, back, cell, *moments);
    return total * cell;
  }

  /// The k-th of evenly scattered splits of the whole ring (an additive sequence of four irrational steps).
  std::array<double, 4> scattered(int k) const {
    constexpr std::array<double, 4> steps = {0.8566748838545029, 0.7338918566271260, 0.6287067210378087,
                                             0.5385972572236101};
    std::array<double, 4> a{};
    for (std::size_t i = 0; i < 4; ++i) {
      const double along = 0.5 + (k + 1) * steps[i];
      a[i] = own_[i].low + (along - std::floor(along)) * own_[i].length();
    }
    return a;
  }

  /// What the beads between the splits a receive. Bead i of the layer below stands between a_i and a_{i+1}.
  RingForces below(const std::array<double, 4>& a) const {
    RingForces forces;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t j = next(i);
      forces.V_UL[i] = V_R_[i];
      forces.V_UR[i] = V_L_[j];
      forces.H[i] = a[i] + in_.H[j] - a[j];
    }
    return forces;
  }

 private:
  void multiply(const std::vector<double>& a, const std::vector<double>& b, std::vector<double>& product) const {
    const auto n = static_cast<std::size_t>(cells_);
    std::fill(product.begin(), product.end(), 0);
    for (std::size_t x = 0; x < n; ++x) {
      for (std::size_t y = 0; y < n; ++y) {
        const double one = a[x * n + y];
        if (one == 0) continue;
        for (std::size_t z = 0; z < n; ++z) product[x * n + z] += one * b[y * n + z];
      }
    }
  }

  void add_moments(const std::vector<double>& there, const std::vector<double>& back, double cell,
                   std::array<double, SplitMoments::per_layer>& moments) const {
    const auto n = static_cast<std::size_t>(cells_);
    const auto at = [&](std::size_t i, std::size_t k) { return centre(i, static_cast<int>(k)); };
    for (std::size_t x = 0; x < n; ++x) {
      for (std::size_t y = 0; y < n; ++y) {
        // x: a_0, y: a_2, the others summed.
        const double mass = there[x * n + y] * back[y * n + x] * cell;
        moments[0] += mass * at(0, x);
        moments[4] += mass * at(0, x) * at(0, x);
        moments[2] += mass * at(2, y);
        moments[6] += mass * at(2, y) * at(2, y);
        moments[12] += mass * at(0, x) * at(2, y);
        for (std::size_t k = 0; k < n; ++k) {
          const double one = kernel_[0][x * n + k] * kernel_[1][k * n + y] * back[y * n + x] * cell;
          moments[1] += one * at(1, k);
          moments[5] += one * at(1, k) * at(1, k);
          moments[8] += one * at(0, x) * at(1, k);
          moments[9] += one * at(1, k) * at(2, y);
          const double three = there[x * n + y] * kernel_[2][y * n + k] * kernel_[3][k * n + x] * cell;
          moments[3] += three * at(3, k);
          moments[7] += three * at(3, k) * at(3, k);
          moments[10] += three * at(2, y) * at(3, k);
          moments[11] += three * at(3, k) * at(0, x);
        }
      }
    }
    // a_1 and a_3 are independent given a_0 and a_2.
    for (std::size_t x = 0; x < n; ++x) {
      for (std::size_t y = 0; y < n; ++y) {
        double first = 0, third = 0;
        for (std::size_t k = 0; k < n; ++k) {
          first += kernel_[0][x * n + k] * kernel_[1][k * n + y] * at(1, k);
          third += kernel_[2][y * n + k] * kernel_[3][k * n + x] * at(3, k);
        }
        moments[13] += first * third * cell;
      }
    }
  }

  Bead bead_;
  RingForces in_;
  int cells_;
  std::array<SplitRange, 4> own_{};
  std::array<double, 4> V_R_{}, V_L_{};
  std::array<std::vector<double>, 4> kernel_;
};

std::array<double, SplitMoments::per_layer> products(const std::array<double, 4>& a) {
  std::array<double, SplitMoments::per_layer> all{};
  for (std::size_t i = 0; i < 4; ++i) {
    all[i] = a[i];
    all[4 + i] = a[i] * a[i];
    all[8 + i] = a[i] * a[next(i)];
    if (i < 2) all[12 + i] = a[i] * a[i + 2];
  }
  return all;
}

}  // namespace

SplitMoments small_pile_moments(double mu, const std::array<double, 4>& load, int layers, double lambda, int cells,
                                int redraws) {
  const Bead bead(mu);
  RingForces top;
  for (std::size_t i = 0; i < 4; ++i) top.V_UL[i] = top.V_UR[i] = load[i] / 2;
  Ring upper(bead, top, cells);
  SplitMoments result;
  const auto normalise = [](std::array<double, SplitMoments::per_layer>& moments, double total) {
    for (double& one : moments) one /= total;
  };
  const auto last = [&](double length) { return std::pow(length, 1 - lambda); };
  if (layers == 2) {
    upper.fill_kernels(last);
    normalise(result.upper, upper.sum(&result.upper));
    return result;
  }
  struct State {
    std::array<double, 4> a;
    double mass, below;
    std::array<double, SplitMoments::per_layer> lower;
  };
  std::vector<State> states;
  for (int k = 0; k < cells * cells * cells * cells; ++k) {
    const std::array<double, 4> a = upper.scattered(k);
    Ring lower(bead, upper.below(a), cells);
    if (!lower.solvable()) continue;
    lower.fill_kernels(last);
    State state{a, std::pow(lower.volume(), 1 - lambda), 0, {}};
    state.below = lower.sum(&state.lower);
    states.push_back(state);
  }
  double attempts = 0, succeeded = 0, kept_failing = 0;
  for (const State& one : states) {
    attempts += one.mass;
    succeeded += one.mass * one.below;
    kept_failing += one.mass * std::pow(1 - one.below, redraws);
  }
  double total = 0;
  for (const State& one : states) {
    // For a state that keeps its top layer for K attempts, success in one of them; the rest of the probability goes to
    // states drawn anew, which are then distributed like a first success.
    double weight = one.mass * one.below;
    if (redraws > 0) {
      weight = one.mass / attempts * (1 - std::pow(1 - one.below, redraws)) +
               kept_failing / attempts * one.mass * one.below / succeeded;
    }
    total += weight;
    const auto above = products(one.a);
    for (std::size_t k = 0; k < SplitMoments::per_layer; ++k) {
      result.upper[k] += weight * above[k];
      if (one.below > 0) result.lower[k] += weight * one.lower[k] / one.below;
    }
  }
  normalise(result.upper, total);
  normalise(result.lower, total);
  return result;
}

}  // namespace granuscope::test
