// Source of the expected numbers: ring_quadrature.h, the densities of the laws integrated over all splits of piles of
// four columns, on two grids; what the grids differ by at most, in
// units of a quantity's spread, is allowed as the error of the finer one.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "kit/sampling_statistics.h"
#include "ring_quadrature.h"
#include "sampling/sampler.h"
#include "sampling/simple_laws.h"

namespace granuscope {
namespace {

struct Setting {
  Law law;
  double lambda;
  double mu;
  int layers;
  std::array<double, 4> load;
};

constexpr std::array<double, 4> even = {1, 1, 1, 1}, uneven = {0.6, 1.5, 0.8, 1.1};

std::vector<Setting> settings() {
  std::vector<Setting> all;
  for (const int layers : {2, 3}) {
    for (const auto& [mu, load] : {std::pair{0.3, even}, std::pair{0.7, uneven}}) {
      all.push_back({Law::rejection, 1, mu, layers, load});
      all.push_back({Law::eloy_clement, 1, mu, layers, load});
      for (const double lambda : {0.0, 0.5, 1.0}) all.push_back({Law::polytope, lambda, mu, layers, load});
    }
  }
  return all;
}

/// The means of what the quadrature gives, over groups of eight piles (one chain each).
std::vector<test::RunningMean> measure(const Setting& setting, std::uint64_t piles) {
  const Lattice lattice({.columns = 4, .layers = setting.layers});
  SamplerSpec spec;
  spec.law = setting.law;
  spec.lambda = setting.lambda;
  spec.mu = setting.mu;
  spec.seed = 5;
  spec.effort = 1e6;
  const auto sampler = make_sampler(spec, lattice);
  const std::vector<double> load(setting.load.begin(), setting.load.end());
  Pile pile(lattice);
  const std::size_t per_layer = test::SplitMoments::per_layer;
  std::vector<test::RunningMean> means(per_layer * static_cast<std::size_t>(setting.layers - 1));
  for (std::uint64_t group = 0; group < piles / 8; ++group) {
    std::vector<double> sums(means.size());
    for (std::uint64_t k = 0; k < 8; ++k) {
      if (sampler->draw(8 * group + k, load, pile)) throw std::runtime_error("stuck");
      for (std::size_t n = 0; n + 1 < static_cast<std::size_t>(setting.layers); ++n) {
        const double* const a = &pile.H_R[4 * n];
        for (std::size_t i = 0; i < 4; ++i) {
          sums[n * per_layer + i] += a[i] / 8;
          sums[n * per_layer + 4 + i] += a[i] * a[i] / 8;
          sums[n * per_layer + 8 + i] += a[i] * a[(i + 1) % 4] / 8;
          if (i < 2) sums[n * per_layer + 12 + i] += a[i] * a[i + 2] / 8;
        }
      }
    }
    for (std::size_t k = 0; k < means.size(); ++k) means[k].add(sums[k]);
  }
  return means;
}

std::vector<double> expected(const Setting& setting, int cells) {
  // The top layer stands while the n above a failure are one: for failures_per_layer failures and the attempt before.
  const int kept =
      setting.law == Law::eloy_clement && setting.layers == 3 ? EloyClementSampler::failures_per_layer + 1 : 0;
  const auto moments = test::small_pile_moments(setting.mu, setting.load, setting.layers, setting.lambda, cells, kept);
  std::vector<double> all(moments.upper.begin(), moments.upper.end());
  if (setting.layers == 3) all.insert(all.end(), moments.lower.begin(), moments.lower.end());
  return all;
}

void compare(int cells, std::uint64_t independent, std::uint64_t chained, double resolution) {
  const auto all = settings();
  for (const Setting& setting : all) {
    const int fine = setting.layers == 2 ? 4 * cells : cells, coarse = fine * 3 / 4;
    const auto on_coarse = expected(setting, coarse), on_fine = expected(setting, fine);
    const auto measured = measure(setting, setting.law == Law::polytope ? chained : independent);
    const double bound = test::sigma_bound(all.size() * measured.size());
    // Of single piles: means of eight scatter at least 1/sqrt 8 as much.
    const auto spread = [&](std::size_t k) { return std::sqrt(8 * measured[k].variance()); };
    double grid_share = 0;
    for (std::size_t k = 0; k < measured.size(); ++k) {
      grid_share = std::max(grid_share, std::abs(on_fine[k] - on_coarse[k]) / spread(k));
    }
    for (std::size_t k = 0; k < measured.size(); ++k) {
      const auto found = measured[k].estimate();
      const double grid_error = grid_share * spread(k);
      CAPTURE(name_of(setting.law), setting.lambda, setting.mu, setting.layers, k, found.value, found.error, on_fine[k],
              grid_error, spread(k));
      CHECK(std::abs(found.value - on_fine[k]) <= bound * found.error + grid_error);
      CHECK(bound * found.error + grid_error < resolution * spread(k));
    }
  }
}

TEST_CASE("two- and three-layer piles of every exact density follow its quadrature", "[unsanitized]") {
  compare(8, test::sanitized ? 4000 : 16'000, test::sanitized ? 1600 : 4000, test::sanitized ? 0.5 : 0.25);
}

TEST_CASE("two- and three-layer piles follow the quadrature, to percents", "[long]") {
  compare(12, 150'000, 40'000, 0.1);
}

}  // namespace
}  // namespace granuscope
