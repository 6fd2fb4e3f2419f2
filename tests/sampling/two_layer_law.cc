#include "two_layer_law.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace granuscope::test {
namespace {

int wrapped(int k) { return ((k % 4) + 4) % 4; }
std::size_t index(int k) { return static_cast<std::size_t>(wrapped(k)); }

/// Area of { x - y <= d } in the rectangle x0..x1 by y0..y1.
double area_below(double d, double x0, double x1, double y0, double y1) {
  const auto half_square = [](double z) { return z > 0 ? z * z / 2 : 0; };
  return half_square(d - x0 + y1) - half_square(d - x1 + y1) - half_square(d - x0 + y0) + half_square(d - x1 + y0);
}

RingForces top_layer(const std::array<double, 4>& load) {
  RingForces forces;  // nothing enters sideways
  for (std::size_t i = 0; i < 4; ++i) forces.V_UL[i] = forces.V_UR[i] = load[i] / 2;
  return forces;
}

}  // namespace

TwoLayerLaw::TwoLayerLaw(double mu, const std::array<double, 4>& load, int cells, double angle)
    : TwoLayerLaw(mu, top_layer(load), cells, angle) {}

TwoLayerLaw::TwoLayerLaw(double mu, const RingForces& received, int cells, double angle)
    : n_(static_cast<std::size_t>(cells)),
      cells_(cells),
      tan_(std::tan(angle * std::numbers::pi / 180)),
      received_(received) {
  const double flat = std::tan(std::atan(tan_) - std::atan(mu)), steep = std::tan(std::atan(tan_) + std::atan(mu));
  const double k = (flat + steep) / tan_ - 1;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t next = (i + 1) % 4;
    const double V_R = right_of(received, i), V_L = left_of(received, i), H = received.H[i];
    own_[i] = {std::max(flat * V_R, flat * V_L + H), std::min(steep * V_R, steep * V_L + H)};
    // The bead between i and its neighbour receives H = a_i + H_next - a_next.
    const double V_UL = V_R, V_UR = left_of(received, next), H_next = received.H[next];
    band_[i] = {std::max(-V_UR * tan_, -(steep * V_UR - flat * V_UL) / k) - H_next,
                std::min(V_UL * tan_, (steep * V_UL - flat * V_UR) / k) - H_next};
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const Range X = own_[i], Y = own_[(i + 1) % 4];
    const double dx = (X.high - X.low) / cells, dy = (Y.high - Y.low) / cells;
    share_[i].resize(n_ * n_);
    for (int x = 0; x < cells; ++x) {
      for (int y = 0; y < cells; ++y) {
        const double x0 = X.low + x * dx, y0 = Y.low + y * dy;
        const double inside =
            area_below(band_[i].high, x0, x0 + dx, y0, y0 + dy) - area_below(band_[i].low, x0, x0 + dx, y0, y0 + dy);
        // Differences of squares round: a share that small is none.
        const double part = inside / (dx * dy);
        share_[i][static_cast<std::size_t>(x) * n_ + static_cast<std::size_t>(y)] =
            part < 1e-9 ? 0 : std::min(part, 1.0);
      }
    }
  }
}

bool TwoLayerLaw::solvable() const {
  return std::all_of(own_.begin(), own_.end(), [](Range own) { return own.low < own.high; });
}

RingForces TwoLayerLaw::below(const std::array<double, 4>& splits) const {
  RingForces forces;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t next = (i + 1) % 4;
    forces.V_UL[i] = right_of(received_, i);
    forces.V_UR[i] = left_of(received_, next);
    forces.H[i] = splits[i] + received_.H[next] - splits[next];
  }
  return forces;
}

bool TwoLayerLaw::admits(const std::array<double, 4>& splits) const {
  for (std::size_t i = 0; i < 4; ++i) {
    const double difference = splits[i] - splits[(i + 1) % 4];
    if (!(difference > band_[i].low && difference < band_[i].high)) return false;
  }
  return true;
}

std::vector<TwoLayerLaw::State> TwoLayerLaw::states() const {
  // Points scattered evenly over a cell (an additive sequence of four irrational steps); the first that is admissible
  // stands for the cell.
  constexpr std::array<double, 4> steps = {0.8566748838545029, 0.7338918566271260, 0.6287067210378087,
                                           0.5385972572236101};
  constexpr int most_points = 1000;
  constexpr double no_share = 1e-12;
  std::vector<State> found;
  std::array<int, 4> c{};
  int point = 0;
  for (c[0] = 0; c[0] < cells_; ++c[0]) {
    for (c[1] = 0; c[1] < cells_; ++c[1]) {
      for (c[2] = 0; c[2] < cells_; ++c[2]) {
        for (c[3] = 0; c[3] < cells_; ++c[3]) {
          const double share = mean_mass_[at(c)];
          if (share < no_share) continue;
          for (int k = 0; k < most_points; ++k) {
            ++point;
            State state{{}, share};
            for (std::size_t i = 0; i < 4; ++i) {
              const double along = point * steps[i] - std::floor(point * steps[i]);
              state.splits[i] = own_[i].low + (c[i] + along) * (own_[i].high - own_[i].low) / cells_;
            }
            if (!admits(state.splits)) continue;
            found.push_back(state);
            break;
          }
        }
      }
    }
  }
  return found;
}

double TwoLayerLaw::centre(int parent, int cell) const {
  const Range own = own_[index(parent)];
  return own.low + (cell + 0.5) * (own.high - own.low) / cells_;
}

TwoLayerMoments TwoLayerLaw::moments() {
  TwoLayerMoments result;
  mean_mass_.assign(n_ * n_ * n_ * n_, 0);
  for (int first = 0; first < 4; ++first) {
    for (const int direction : {1, -1}) {
      const auto cells = static_cast<double>(n_ * n_ * n_ * n_);
      mass_.assign(n_ * n_ * n_ * n_, 1 / cells);
      std::array<bool, 4> solved{};
      for (int k = 0; k < 4; ++k) {
        const int bead = wrapped(first + k * direction);
        solve_bead(bead, solved);
        solved[index(bead)] = true;
      }
      add_moments(result, 1.0 / 8);
      for (std::size_t k = 0; k < mass_.size(); ++k) mean_mass_[k] += mass_[k] / 8;
    }
  }
  result.lost = lost_ / 8;
  return result;
}

void TwoLayerLaw::solve_bead(int bead, const std::array<bool, 4>& solved) {
  std::array<int, 4> cell{};
  int &x = cell[index(bead)], &y = cell[index(bead + 1)], &left = cell[index(bead - 1)], &right = cell[index(bead + 2)];
  std::vector<double> wanted(n_ * n_);
  for (left = 0; left < cells_; ++left) {
    for (right = 0; right < cells_; ++right) {
      double failed = 0, total = 0;
      std::size_t k = 0;
      for (x = 0; x < cells_; ++x) {
        for (y = 0; y < cells_; ++y, ++k) {
          const double works = share(bead, x, y);
          double& mass = mass_[at(cell)];
          failed += mass * (1 - works);
          mass *= works;
          // Uniform where this bead and the solved siblings are solvable.
          wanted[k] = works * (solved[index(bead - 1)] ? share(wrapped(bead - 1), left, x) : 1) *
                      (solved[index(bead + 1)] ? share(wrapped(bead + 1), y, right) : 1);
          total += wanted[k];
        }
      }
      if (total <= 0) {
        lost_ += failed;
        continue;
      }
      k = 0;
      for (x = 0; x < cells_; ++x) {
        for (y = 0; y < cells_; ++y, ++k) mass_[at(cell)] += failed * wanted[k] / total;
      }
    }
  }
}

void TwoLayerLaw::add_moments(TwoLayerMoments& moments, double weight) const {
  std::array<int, 4> c{};
  for (c[0] = 0; c[0] < cells_; ++c[0]) {
    for (c[1] = 0; c[1] < cells_; ++c[1]) {
      for (c[2] = 0; c[2] < cells_; ++c[2]) {
        for (c[3] = 0; c[3] < cells_; ++c[3]) {
          const double mass = weight * mass_[at(c)];
          for (int i = 0; i < 4; ++i) {
            const std::size_t k = index(i);
            const double a = centre(i, c[k]), next = centre(wrapped(i + 1), c[index(i + 1)]);
            moments.mean[k] += mass * a;
            moments.square[k] += mass * a * a;
            moments.with_next[k] += mass * a * next;
            if (i < 2) moments.across[k] += mass * a * centre(i + 2, c[index(i + 2)]);
          }
        }
      }
    }
  }
}

}  // namespace granuscope::test
