// Source: curves known exactly. The q-model with a uniform share answers a point load with a binomial of W^2 = n/4; an
// isotropic elastic half plane with sigma_zz = 2 z^3/[pi (x^2 + z^2)^2].
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "analysis/double_gaussian.h"
#include "model/lattice.h"
#include "synthetic_ensemble.h"

using namespace granuscope;
using Catch::Matchers::Contains;

namespace {

constexpr int columns = 400;

std::vector<double> profile_of(int layer, const std::function<double(double)>& response) {
  const Lattice lattice({columns, layer + 1});
  std::vector<double> profile(columns);
  for (int i = 0; i < columns; ++i) profile[static_cast<std::size_t>(i)] = response(lattice.x(layer, i));
  return profile;
}

/// The binomial response in layer n to a load on bead 0, by the recursion that defines it.
std::vector<double> q_model(int layer) {
  std::vector<double> row(columns);
  row[columns / 2] = 1;
  for (int n = 0; n < layer; ++n) {
    const Lattice lattice({columns, n + 2});
    std::vector<double> below(columns);
    for (int i = 0; i < columns; ++i) {
      below[static_cast<std::size_t>(lattice.lower_left(n, i))] += row[static_cast<std::size_t>(i)] / 2;
      below[static_cast<std::size_t>(lattice.lower_right(n, i))] += row[static_cast<std::size_t>(i)] / 2;
    }
    row = below;
  }
  return row;
}

Transport measure(const std::function<std::vector<double>(int)>& response_of, double noise) {
  FitSpec fit;
  fit.first_layer = fit.shallow_layer = 60;
  fit.last_layer = 120;
  fit.layer_step = 5;
  return measure_transport(
             synthetic_ensemble(response_of, 0.9, {noise, 5}, columns, layers_to_record(fit, {}), 32, 100), fit, {}, 0)
      .transport;
}

}  // namespace

TEST_CASE("the q-model's binomial is one peak of W^2 = n/4: its two Gaussians are told to have merged") {
  const Transport t = measure(q_model, 0.01);
  REQUIRE(t.depths.size() == 13);
  for (const DepthFit& depth : t.depths) {
    INFO("layer " << depth.layer << " peak " << depth.peak_position.value << " W " << depth.width.value);
    // The binomial's values are areas of beads already: integrating the fit over a bead takes 1/12 off its W^2.
    const double second_moment = std::pow(depth.peak_position.value, 2) + std::pow(depth.width.value, 2);
    CHECK(second_moment == Approx(depth.layer / 4.0 - 1.0 / 12).epsilon(0.01));
    CHECK_FALSE(depth.identifiable);
    CHECK(depth.reason.find("closer to the middle") != std::string::npos);
  }
  CHECK_FALSE(t.c.known());
  CHECK_FALSE(t.c.reason.empty());
}

TEST_CASE("two shifted binomials are two peaks, and their widths those of the q-model") {
  // Half of the load each, carried sideways by half a bead per layer; sampled where the lattice has its beads.
  const auto two_binomials = [](int layer) {
    const std::vector<double> one = q_model(layer);
    std::vector<double> both(columns);
    const int shift = layer / 2 / 2 * 2;
    for (int i = 0; i < columns; ++i) {
      both[static_cast<std::size_t>((i + shift) % columns)] += one[static_cast<std::size_t>(i)] / 2;
      both[static_cast<std::size_t>((i - shift + columns) % columns)] += one[static_cast<std::size_t>(i)] / 2;
    }
    return both;
  };
  const Transport t = measure(two_binomials, 0.01);
  for (const DepthFit& depth : t.depths) {
    INFO("layer " << depth.layer);
    CHECK(depth.identifiable);
    const int shift = depth.layer / 2 / 2 * 2;
    CHECK(depth.peak_position.value == Approx(shift).margin(0.01));
    CHECK(depth.width_squared.value == Approx(depth.layer / 4.0 - 1.0 / 12).epsilon(0.01));
  }
  // z grows by sqrt(3)/2 per layer.
  CHECK(t.D.value == Approx(0.25 * 2 / sqrt3).epsilon(0.02));
}

TEST_CASE("the isotropic elastic response is rejected as a double Gaussian") {
  const auto elastic = [](int layer) {
    const double z = Lattice::depth(layer);
    return profile_of(layer, [z](double x) {
      double sum = 0;
      for (int image = -20; image <= 20; ++image) {
        const double at = x + image * columns;
        sum += 2 * z * z * z / (std::numbers::pi * std::pow(at * at + z * z, 2));
      }
      return sum;
    });
  };
  const Transport t = measure(elastic, 0.01);
  for (const DepthFit& depth : t.depths) {
    INFO("layer " << depth.layer << " " << depth.reason);
    CHECK_FALSE(depth.identifiable);
    // It misses by more than piles do and prefers one peak to two, each beyond any doubt.
    CHECK_THAT(depth.reason, Contains("another shape"));
    CHECK(depth.misfit == Approx(0.18).margin(0.03));
    CHECK(depth.evidence.for_two_peaks < -1e4);
  }
  CHECK_FALSE(t.c.known());
}

TEST_CASE("two peaks on a plateau are rejected, with the share that two Gaussians miss") {
  const auto with_plateau = [](int layer) {
    const double z = Lattice::depth(layer);
    const auto peaks = [&](double x) {
      return evaluate({0.55 * z, std::sqrt(0.08 * z)}, std::vector<double>{x}, columns)[0];
    };
    const double flat = 0.6 / (1.1 * z);
    return profile_of(layer, [&](double x) { return 0.4 * peaks(x) + (std::abs(x) < 0.55 * z ? flat : 0); });
  };
  const Transport t = measure(with_plateau, 0.01);
  for (const DepthFit& depth : t.depths) {
    INFO("layer " << depth.layer << " " << depth.reason);
    CHECK_FALSE(depth.identifiable);
    CHECK_THAT(depth.reason, Contains("another shape"));
  }
}
