#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "kit/sampling_statistics.h"

namespace granuscope::test {

/// The law "rejection" a second time, of piles under a uniform load of 1, written from Coulomb's cone by angles;
/// nothing of the program is used. Layers lie on a ring without the alternating shift of the lattice: bead j stands
/// below the beads j and j + 1 of the layer above, so that only numbers that do not name a bead can be compared.
class NaiveRejection {
 public:
  /// Forces leaving the beads of one layer through their lower-right and lower-left contacts.
  struct Layer {
    std::vector<double> V_R, V_L, H_R, H_L;
  };

  NaiveRejection(double mu, int columns, std::uint64_t seed, double bead_weight = 0, double angle = 30)
      : columns_(static_cast<std::size_t>(columns)),
        cot_(1 / std::tan(angle * std::numbers::pi / 180)),
        flat_(std::tan(std::atan(1 / cot_) - std::atan(mu))),
        steep_(std::tan(std::atan(1 / cot_) + std::atan(mu))),
        bead_weight_(bead_weight),
        engine_(seed) {}

  Layer empty_layer() const {
    const std::vector<double> none(columns_);
    return {none, none, none, none};
  }
  /// Draws the layer below `above` (nullptr: the top one); false where a bead has no solution.
  bool draw_layer(const Layer* above, Layer& layer) {
    for (std::size_t j = 0; j < columns_; ++j) {
      double V_UL = 0.5, V_UR = 0.5, H = 0;
      if (above != nullptr) {
        const std::size_t right = (j + 1) % columns_;
        V_UL = above->V_R[j], V_UR = above->V_L[right], H = above->H_R[j] + above->H_L[right];
      }
      V_UL += bead_weight_ / 2, V_UR += bead_weight_ / 2;
      const double V_R = V_UR + cot_ * H, V_L = V_UL - cot_ * H;
      const double low = std::max(flat_ * V_R, flat_ * V_L + H), high = std::min(steep_ * V_R, steep_ * V_L + H);
      if (!(low <= high)) return false;
      layer.V_R[j] = V_R, layer.V_L[j] = V_L;
      layer.H_R[j] = low + (high - low) * unit_(engine_);
      layer.H_L[j] = H - layer.H_R[j];
    }
    return true;
  }
  /// Mean of cot (H_R - H_L) over the layer: 1 without friction.
  double thrust_ratio(const Layer& layer) const {
    double sum = 0;
    for (std::size_t j = 0; j < columns_; ++j) sum += layer.H_R[j] - layer.H_L[j];
    return cot_ * sum / static_cast<double>(columns_);
  }
  /// Mean of (w - 1)^2 over the layer.
  double weight_variance(const Layer& layer) const {
    double sum = 0;
    for (std::size_t j = 0; j < columns_; ++j) sum += std::pow(layer.V_R[j] + layer.V_L[j] - 1, 2);
    return sum / static_cast<double>(columns_);
  }
  /// A whole number below `count`, each as likely.
  std::size_t pick(std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(engine_); }

 private:
  std::size_t columns_;
  double cot_, flat_, steep_, bead_weight_;
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> unit_{0, 1};
};

/// Per layer, over accepted piles; and the share of tries that was accepted.
struct NaiveRejectionMoments {
  std::vector<RunningMean> thrust_ratio, weight_variance;
  Estimated acceptance;
};

/// By its definition: a pile in which any bead has no solution is thrown away whole.
inline NaiveRejectionMoments naive_rejection_moments(double mu, int columns, std::size_t layers, int accepted,
                                                     std::uint64_t seed, double angle = 30) {
  NaiveRejection law(mu, columns, seed, 0, angle);
  NaiveRejectionMoments moments{std::vector<RunningMean>(layers), std::vector<RunningMean>(layers), {}};
  std::vector<NaiveRejection::Layer> pile(layers, law.empty_layer());
  double tries = 0;
  for (int k = 0; k < accepted; ++tries) {
    std::size_t n = 0;
    while (n < layers && law.draw_layer(n == 0 ? nullptr : &pile[n - 1], pile[n])) ++n;
    if (n < layers) continue;
    for (n = 0; n < layers; ++n) {
      moments.thrust_ratio[n].add(law.thrust_ratio(pile[n]));
      moments.weight_variance[n].add(law.weight_variance(pile[n]));
    }
    ++k;
  }
  const double share = accepted / tries;
  moments.acceptance = {share, std::sqrt(share * (1 - share) / tries)};
  return moments;
}

/// The thrust ratio, averaged over layers `first` to `last`, of piles too deep to be accepted whole, by sequential
/// Monte Carlo: `particles` piles go down layer by layer, each new one below a survivor of the layer above picked at
/// random. Mean and error over `runs` of them.
inline Estimated naive_rejection_thrust(double mu, int columns, int layers, int first, int last, std::size_t particles,
                                        int runs, std::uint64_t seed) {
  struct Particle {
    NaiveRejection::Layer lowest;
    double thrust;  ///< sum of the thrust ratios of the layers first to last, as far as it has come
  };
  double sum = 0, squares = 0;
  for (int run = 0; run < runs; ++run) {
    NaiveRejection law(mu, columns, seed + static_cast<std::uint64_t>(run));
    std::vector<Particle> above, below(particles, {law.empty_layer(), 0});
    for (int n = 0; n < layers; ++n) {
      for (Particle& particle : below) {
        std::size_t parent = 0;
        do {
          if (n > 0) parent = law.pick(particles);
        } while (!law.draw_layer(n == 0 ? nullptr : &above[parent].lowest, particle.lowest));
        particle.thrust = n == 0 ? 0 : above[parent].thrust;
        if (n >= first && n <= last) particle.thrust += law.thrust_ratio(particle.lowest);
      }
      above.swap(below);
      if (below.empty()) below = above;
    }
    double mean = 0;
    for (const Particle& particle : above) mean += particle.thrust;
    mean /= static_cast<double>(particles) * (last - first + 1);
    sum += mean, squares += mean * mean;
  }
  const double mean = sum / runs;
  return {mean, std::sqrt(std::max(0.0, squares / runs - mean * mean) / (runs - 1))};
}

}  // namespace granuscope::test
