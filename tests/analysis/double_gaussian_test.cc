#include "analysis/double_gaussian.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "model/lattice.h"

using namespace granuscope;

namespace {

std::vector<double> bead_positions(int columns, int layer) {
  const Lattice lattice({columns, layer + 1});
  std::vector<double> x;
  for (int i = 0; i < columns; ++i) x.push_back(lattice.x(layer, i));
  return x;
}

}  // namespace

TEST_CASE("the double Gaussian has area 1 on every ring") {
  for (const DoubleGaussian shape : {DoubleGaussian{20, 0.3}, {20, 3}, {0, 5}, {20, 40}}) {
    double area = 0;
    for (double value : evaluate(shape, bead_positions(101, 1), 101)) area += value;
    CHECK(area == Approx(1).epsilon(1e-13));
  }
}

TEST_CASE("a wide double Gaussian integrated over beads equals the paper's G(x) to second order in the bead width") {
  // The mean of G over [x - 1/2, x + 1/2] is G(x) + G''(x)/24 + O(W^-5): calculus.
  const double W = 8, x_p = 30;
  const auto G = [&](double x) {
    return (std::exp(-std::pow((x + x_p) / W, 2) / 2) + std::exp(-std::pow((x - x_p) / W, 2) / 2)) /
           (2 * std::sqrt(2 * std::numbers::pi) * W);
  };
  const std::vector<double> x{-40, -30, 0, 12.5, 31};
  const std::vector<double> values = evaluate({x_p, W}, x, 1000);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double second = G(x[i] + 0.5) - 2 * G(x[i]) + G(x[i] - 0.5);  // G''/4
    CHECK(values[i] == Approx(G(x[i]) + second / 6).margin(1e-7));
  }
}

TEST_CASE("Fourier modes of the shape equal the cosine sums of its values") {
  // Two independent roads: differences of erfc summed over beads, and the aliased closed form.
  for (int columns : {500, 501, 60}) {
    for (int layer : {0, 1}) {
      const std::vector<double> x = bead_positions(columns, layer);
      for (const DoubleGaussian shape : {DoubleGaussian{13.3, 0.4}, {13.3, 0.7}, {13.3, 1.5}, {20.25, 6}}) {
        const std::vector<double> values = evaluate(shape, x, columns);
        for (int mode : {1, 2, 7, columns / 4, (columns - 1) / 2}) {
          double sum = 0;
          for (std::size_t i = 0; i < x.size(); ++i) {
            sum += values[i] * std::cos(2 * std::numbers::pi * mode * x[i] / columns);
          }
          INFO("columns " << columns << " layer " << layer << " W " << shape.width << " mode " << mode);
          CHECK(fourier_mode(shape, mode, columns, layer % 2 == 1).value == Approx(sum).margin(2e-13));
        }
      }
    }
  }
}

TEST_CASE("sines are those of the Gaussian that moves towards +x, and their derivatives agree with differences") {
  const int columns = 61;
  const double h = 1e-5;
  for (const bool half_shifted : {false, true}) {
    const std::vector<double> x = bead_positions(columns, half_shifted ? 1 : 0);
    for (const DoubleGaussian shape : {DoubleGaussian{13.3, 0.4}, {13.3, 1.5}, {40.2, 3}}) {
      const auto sines_of = [&](const DoubleGaussian& of) {
        std::vector<ModeValue> cosines(30), sines(30);
        fourier_modes(of, columns, half_shifted, cosines, sines);
        return sines;
      };
      const std::vector<ModeValue> sines = sines_of(shape);
      const std::vector<ModeValue> farther = sines_of({shape.peak + h, shape.width}),
                                   nearer = sines_of({shape.peak - h, shape.width}),
                                   wider = sines_of({shape.peak, shape.width + h}),
                                   narrower = sines_of({shape.peak, shape.width - h});
      for (std::size_t m = 0; m < sines.size(); ++m) {
        double sum = 0;
        for (const double at : x) {
          for (const double image : {-61.0, 0.0, 61.0}) {
            const double from = (at + image - shape.peak - 0.5) / (shape.width * std::numbers::sqrt2),
                         to = (at + image - shape.peak + 0.5) / (shape.width * std::numbers::sqrt2);
            sum += (std::erf(to) - std::erf(from)) / 2 *
                   std::sin(2 * std::numbers::pi * static_cast<double>(m + 1) * at / columns);
          }
        }
        CAPTURE(half_shifted, shape.peak, shape.width, m + 1);
        CHECK(sines[m].value == Approx(sum).margin(1e-12));
        CHECK(sines[m].by_peak == Approx((farther[m].value - nearer[m].value) / (2 * h)).margin(1e-7));
        CHECK(sines[m].by_width == Approx((wider[m].value - narrower[m].value) / (2 * h)).margin(1e-7));
      }
    }
  }
}

TEST_CASE("derivatives of the modes agree with differences") {
  const double h = 1e-5;
  for (const DoubleGaussian shape : {DoubleGaussian{13.3, 0.5}, {30, 2.5}}) {
    for (int mode : {1, 30, 120, 249}) {
      const auto at = [&](double peak, double width) { return fourier_mode({peak, width}, mode, 500, true).value; };
      const ModeValue value = fourier_mode(shape, mode, 500, true);
      CHECK(value.by_peak ==
            Approx((at(shape.peak + h, shape.width) - at(shape.peak - h, shape.width)) / (2 * h)).margin(1e-8));
      CHECK(value.by_width ==
            Approx((at(shape.peak, shape.width + h) - at(shape.peak, shape.width - h)) / (2 * h)).margin(1e-8));
    }
  }
}

TEST_CASE("the modes by rotation equal those one by one") {
  for (const DoubleGaussian shape : {DoubleGaussian{13.3, 0.2}, {88.7, 0.5}, {30, 2.5}, {400.1, 60}}) {
    for (bool half_shifted : {false, true}) {
      for (int columns : {4, 61, 500, 2000}) {
        std::vector<ModeValue> modes(static_cast<std::size_t>((columns - 1) / 2));
        fourier_modes(shape, columns, half_shifted, modes);
        for (std::size_t m = 0; m < modes.size(); ++m) {
          const ModeValue one = fourier_mode(shape, static_cast<int>(m) + 1, columns, half_shifted);
          const double scale = 1 + shape.peak;  // derivatives carry the size of the position
          REQUIRE(modes[m].value == Approx(one.value).margin(1e-12));
          REQUIRE(modes[m].by_peak == Approx(one.by_peak).margin(1e-11));
          REQUIRE(modes[m].by_width == Approx(one.by_width).margin(1e-11 * scale));
        }
      }
    }
  }
}

TEST_CASE("shapes that a fit may try and no response has: next to no width, none, and wider than any ring") {
  std::vector<ModeValue> modes(59);
  for (const double W : {0.0, 1e-9, 1e-160, 1e-300}) {
    INFO("W " << W);
    fourier_modes({0.5, W}, 120, false, modes);
    for (std::size_t m = 0; m < modes.size(); ++m) {
      // All of the load within two beads that share it evenly: cos(k 0) + cos(k 1), each half a half from both sides.
      const double k = 2 * std::numbers::pi * static_cast<double>(m + 1) / 120;
      CHECK(modes[m].value == Approx(fourier_mode({0.5, W}, static_cast<int>(m) + 1, 120, false).value).margin(1e-12));
      CHECK(modes[m].value == Approx((1 + std::cos(k)) / 2).margin(0.01));
    }
  }
  for (const double W : {250.0, 1e9, 1e300}) {
    for (const double value : evaluate({3, W}, bead_positions(120, 0), 120)) CHECK(value == Approx(1 / 120.0));
  }
}
