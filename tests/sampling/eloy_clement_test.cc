// Source of the expected numbers: the law written a second time from its description, with another random engine. How
// often layers are drawn again is what tells how many of them each failure throws away.
#include "sampling/simple_laws.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "kit/sampling_statistics.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

using test::RunningMean;

struct Setting {
  int columns, layers;
  double mu;
};

/// Layers of beads (V_R, V_L, H_R, H_L), drawn until the last one is complete.
class NaiveEloyClement {
 public:
  NaiveEloyClement(Setting setting, unsigned seed)
      : setting_(setting), engine_(seed), pile_(static_cast<std::size_t>(setting.layers)) {
    const double phi = std::atan(setting.mu), thirty = std::acos(-1.0) / 6;
    low_ = std::tan(thirty - phi), high_ = std::tan(thirty + phi);
  }

  /// Draws a pile under an even load; how many attempts at a layer it took beyond the first of each.
  int draw() {
    std::vector<int> failures(pile_.size());
    std::size_t layer = 0;
    int attempts = 0;
    while (layer < pile_.size()) {
      ++attempts;
      if (complete(layer)) {
        failures[layer++] = 0;
        continue;
      }
      // One layer above for the first eight failures, two for the next eight, and so on.
      const int above = 1 + failures[layer]++ / EloyClementSampler::failures_per_layer;
      layer -= std::min<std::size_t>(layer, static_cast<std::size_t>(above));
    }
    return attempts - setting_.layers;
  }

  double thrust(std::size_t layer) const {
    double sum = 0;
    for (const Bead& bead : pile_[layer]) sum += bead.H_R - bead.H_L;
    return sum;
  }
  double weight_squares(std::size_t layer) const {
    double sum = 0;
    for (const Bead& bead : pile_[layer]) sum += std::pow(bead.V_R + bead.V_L, 2);
    return sum;
  }

 private:
  struct Bead {
    double V_R, V_L, H_R, H_L;
  };

  bool complete(std::size_t layer) {
    const auto columns = static_cast<std::size_t>(setting_.columns);
    std::vector<Bead> beads;
    for (std::size_t i = 0; i < columns; ++i) {
      double V_left = 0.5, V_right = 0.5, H = 0;
      if (layer > 0) {
        const std::vector<Bead>& above = pile_[layer - 1];
        // An odd layer lies half a bead to the right of an even one.
        const Bead& a = above[layer % 2 == 1 ? i : (i + columns - 1) % columns];
        const Bead& b = above[layer % 2 == 1 ? (i + 1) % columns : i];
        V_left = a.V_R, V_right = b.V_L, H = a.H_R + b.H_L;
      }
      const double V_R = V_right + std::sqrt(3.0) * H, V_L = V_left - std::sqrt(3.0) * H;
      const double from = std::max(low_ * V_R, H + low_ * V_L), to = std::min(high_ * V_R, H + high_ * V_L);
      if (V_R < 0 || V_L < 0 || from > to) return false;
      const double H_R = from + (to - from) * uniform_(engine_);
      beads.push_back({V_R, V_L, H_R, H - H_R});
    }
    pile_[layer] = beads;
    return true;
  }

  Setting setting_;
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> uniform_{0, 1};
  std::vector<std::vector<Bead>> pile_;
  double low_ = 0, high_ = 0;
};

TEST_CASE("eloy-clement throws away as many layers as its description says, and draws its law") {
  const std::vector<Setting> settings = {{6, 6, 0.3}, {5, 4, 0.45}, {4, 4, 0.6}};
  const int piles = 16'000 / (test::sanitized ? 8 : 1);
  for (const Setting& setting : settings) {
    const Lattice lattice({.columns = setting.columns, .layers = setting.layers});
    SamplerSpec spec;
    spec.law = Law::eloy_clement;
    spec.mu = setting.mu;
    spec.seed = 12;
    spec.effort = 1e6;
    const auto sampler = make_sampler(spec, lattice);
    NaiveEloyClement naive(setting, 13);
    const auto layers = static_cast<std::size_t>(setting.layers);
    std::vector<RunningMean> found(1 + 2 * layers), expected(1 + 2 * layers);
    Pile pile(lattice);
    std::uint64_t redrawn_before = 0;
    for (int k = 0; k < piles; ++k) {
      if (sampler->draw(static_cast<std::uint64_t>(k),
                        std::vector<double>(static_cast<std::size_t>(setting.columns), 1.0), pile)) {
        throw std::runtime_error("stuck");
      }
      found[0].add(static_cast<double>(sampler->counts().redrawn_layers - redrawn_before));
      redrawn_before = sampler->counts().redrawn_layers;
      expected[0].add(naive.draw());
      for (std::size_t n = 0; n < layers; ++n) {
        double thrust = 0, squares = 0;
        for (int i = 0; i < setting.columns; ++i) {
          const std::size_t at = lattice.index(static_cast<int>(n), i);
          thrust += pile.H_R[at] - pile.H_L[at];
          squares += std::pow(pile.V_R[at] + pile.V_L[at], 2);
        }
        found[1 + 2 * n].add(thrust);
        found[2 + 2 * n].add(squares);
        expected[1 + 2 * n].add(naive.thrust(n));
        expected[2 + 2 * n].add(naive.weight_squares(n));
      }
    }
    const double bound = test::sigma_bound(settings.size() * found.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      if (!(expected[k].variance() > 1e-20)) continue;  // fixed by the load
      const auto one = found[k].estimate(), other = expected[k].estimate();
      CAPTURE(setting.columns, setting.layers, setting.mu, k, one.value, one.error, other.value, other.error);
      CHECK(std::abs(test::sigmas(one, other)) < bound);
      // Enough piles to see a twentieth of the spread, or an eighth of the redrawn layers.
      CHECK(bound * std::hypot(one.error, other.error) <
            (k == 0 ? other.value / 8 : std::sqrt(expected[k].variance()) / 10) * (test::sanitized ? 3 : 1));
    }
  }
}

}  // namespace
}  // namespace granuscope
