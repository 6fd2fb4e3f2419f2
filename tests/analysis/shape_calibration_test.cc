// The limits of the verdict on a shape, calibrated: how often it refuses two true Gaussians, and what it lets pass.
// Noise is correlated along the layer as in piles (neighbours exchange weight) and given in units of the highest point.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>

#include "analysis/shape_fit.h"
#include "analysis/synthetic_ensemble.h"
#include "model/lattice.h"

using namespace granuscope;

namespace {

constexpr int ring_columns = 120;
using Profile = std::function<std::vector<double>(int)>;

/// Integrated over each bead, periodic, area 1.
Profile integrated(const std::function<double(double)>& density) {
  return [=](int layer) {
    constexpr int points = 20, images = 3;
    const Lattice lattice({ring_columns, layer + 1});
    std::vector<double> profile;
    double sum = 0;
    for (int i = 0; i < ring_columns; ++i) {
      double value = 0;
      for (int image = -images; image <= images; ++image) {
        for (int k = 0; k < points; ++k) {
          value += density(lattice.x(layer, i) + image * ring_columns + (k + 0.5) / points - 0.5);
        }
      }
      profile.push_back(value);
      sum += value;
    }
    for (double& value : profile) value /= sum;
    return profile;
  };
}

/// The q-model's response after n layers.
Profile binomial(int n) {
  return [=](int layer) {
    const Lattice lattice({ring_columns, layer + 1});
    std::vector<double> profile;
    for (int i = 0; i < ring_columns; ++i) {
      const double k = lattice.x(layer, i) + n / 2.0;
      const bool reached = k >= 0 && k <= n;
      profile.push_back(
          reached ? std::exp(std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) - n * std::numbers::ln2)
                  : 0.0);
    }
    return profile;
  };
}

double gaussian(double x, double W) { return std::exp(-x * x / (2 * W * W)) / (W * std::sqrt(2 * std::numbers::pi)); }

constexpr double x_p = 20.3;
Profile two_of(const std::function<double(double)>& peak) {
  return integrated([=](double x) { return peak(x - x_p) + peak(x + x_p); });
}
/// A share of the response in a third peak, or spread evenly between the two.
Profile with_third_peak(double W, double share) {
  return integrated([=](double x) {
    return (1 - share) / 2 * (gaussian(x - x_p, W) + gaussian(x + x_p, W)) + share * gaussian(x, W);
  });
}
Profile with_plateau(double W, double share) {
  return integrated([=](double x) {
    return (1 - share) / 2 * (gaussian(x - x_p, W) + gaussian(x + x_p, W)) +
           (std::abs(x) < x_p ? share / (2 * x_p) : 0.0);
  });
}
Profile elastic(double z) {
  return integrated([=](double x) { return 2 * z * z * z / (std::numbers::pi * std::pow(x * x + z * z, 2)); });
}
Profile lorentzians(double half_width) {
  return two_of([=](double x) { return 1 / (x * x + half_width * half_width); });
}
Profile boxes(double half_width) {
  return two_of([=](double x) { return std::abs(x) < half_width ? 1.0 : 0.0; });
}

struct Counts {
  int fits = 0, accepted = 0, other_shape = 0;
  void operator+=(const Counts& more) {
    fits += more.fits;
    accepted += more.accepted;
    other_shape += more.other_shape;
  }
};

/// `response` with `noise` under `times` seeds.
Counts judge(const Profile& response, double noise, int times, int layer = 40) {
  const std::vector<double> values = response(layer);
  const double highest = *std::max_element(values.begin(), values.end());
  constexpr int blocks = 32, per_block = 100;
  Counts counts;
  for (int seed = 1; seed <= times; ++seed) {
    const SyntheticNoise each{noise * highest * std::sqrt(blocks * per_block), static_cast<std::uint64_t>(seed)};
    const MeasuredEnsemble ensemble = synthetic_ensemble(response, 0.9, each, ring_columns, {layer}, blocks, per_block);
    const LayerSpectrum spectrum = layer_spectrum(ensemble.record.sums, 0, 1);
    const auto fit = fit_shape(spectrum, coarse_shape(spectrum, Lattice::depth(layer)));
    ++counts.fits;
    if (!fit) continue;  // not accepted either
    counts.other_shape += reason_against_two_gaussians(*fit).empty() ? 0 : 1;
    counts.accepted += reason_against_identification(*fit, weigh_peaks(spectrum, *fit), FitSpec{}).empty() ? 1 : 0;
  }
  return counts;
}

}  // namespace

TEST_CASE("calibration: two true Gaussians are not refused", "[long]") {
  Counts all;
  for (const double W : {0.55, 0.7, 0.95, 1.2, 2.5}) {
    for (const double noise : {0.003, 0.02, 0.1, 0.3}) {
      const Counts counts = judge(two_of([=](double x) { return gaussian(x, W); }), noise, 100);
      all += counts;
      INFO("W " << W << ", noise " << noise << ": accepted " << counts.accepted);
      // Beside the limit of 0.5 the noise decides on which side a width falls.
      if (W >= 0.7 && noise <= 0.1) CHECK(counts.accepted == counts.fits);
    }
  }
  CHECK(all.fits == 2000);
  CHECK(all.other_shape <= 2);  // less than one in a thousand
}

TEST_CASE("calibration: other shapes with peaks wider than a bead do not pass where the noise is small", "[long]") {
  for (const double noise : {0.003, 0.02}) {
    Counts wide;
    for (const Profile& shape : {lorentzians(0.7), lorentzians(2), boxes(1.6), boxes(3), elastic(12), elastic(35),
                                 with_third_peak(2, 0.1), with_third_peak(0.7, 0.2), with_third_peak(2, 0.33),
                                 with_plateau(2, 0.1), with_plateau(0.7, 0.2), with_plateau(2, 0.3)}) {
      const Counts counts = judge(shape, noise, 40);
      wide += counts;
      CHECK(counts.accepted <= 1);
    }
    INFO("noise " << noise << ": " << wide.accepted << " of " << wide.fits << " pass");
    CHECK(wide.accepted <= 2);
  }
}

TEST_CASE("calibration: where the noise is a tenth of the peak, only large misfits show", "[long]") {
  for (const Profile& shape : {lorentzians(2), boxes(3), with_third_peak(2, 0.2), with_plateau(2, 0.2)}) {
    CHECK(judge(shape, 0.1, 40).accepted <= 2);
  }
  // Less than a quarter of the response missed is hidden by as much noise.
  CHECK(judge(boxes(1.6), 0.1, 40).accepted >= 30);
}

TEST_CASE("calibration: one peak is not taken for two", "[long]") {
  Counts all;
  for (const double noise : {0.003, 0.02, 0.1, 0.3}) {
    for (const double W : {0.6, 0.9, 3.0}) {
      all += judge(integrated([=](double x) { return gaussian(x, W); }), noise, 40);
    }
    for (const int n : {4, 40}) all += judge(binomial(n), noise, 40);
    all += judge(binomial(41), noise, 40, 41);
    for (const double z : {1.0, 1.5, 3.0, 12.0, 35.0}) all += judge(elastic(z), noise, 40);
  }
  INFO(all.accepted << " of " << all.fits << " count as two peaks");
  // A difference of 4 in chi^2 is exceeded by chance in one case in forty, and not all of these lie on the edge.
  CHECK(all.accepted <= all.fits / 40);
}

TEST_CASE("calibration: peaks narrower than a bead are not told from others of their width", "[long]") {
  // Not a merit, a limit: what is known about the limit for W < 1.
  for (const Profile& shape : {lorentzians(0.4), boxes(1.2), with_third_peak(0.7, 0.1), with_plateau(0.7, 0.1)}) {
    CHECK(judge(shape, 0.02, 20).accepted >= 18);
  }
}
