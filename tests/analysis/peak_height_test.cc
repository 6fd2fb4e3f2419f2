#include "analysis/shape_diagnostics.h"

#include <catch2/catch.hpp>

#include "analysis/double_gaussian.h"

using namespace granuscope;

namespace {

constexpr int layer = 2;  // beads at whole x
const Lattice lattice({60, 3});

/// The height that `pressure` has under this fit.
double height_of(const std::vector<double>& pressure, const DoubleGaussian& fit) {
  return peak_height({pressure, {}}, lattice, layer, {fit.peak, {}}, {fit.width, {}}).value;
}

std::vector<double> response_to(const DoubleGaussian& shape) {
  std::vector<double> x;
  for (int i = 0; i < lattice.columns(); ++i) x.push_back(lattice.x(layer, i));
  return evaluate(shape, x, lattice.columns());
}

}  // namespace

TEST_CASE("the height of two Gaussians is their maximum, wherever between the beads they stand") {
  for (const double peak : {10.0, 10.2, 10.5, 10.9}) {
    const DoubleGaussian shape{peak, 0.8};
    CHECK(height_of(response_to(shape), shape) == Approx(largest_value(shape)));
  }
}

TEST_CASE("the height does not jump where an edge of the peak passes a bead") {
  // Fits of one response, whose edge x_p + W + 1/2 lies at 12 less and more a little. The response is no Gaussian, as
  // those of piles are not: at mu = 0.1 its height was stated with 1.28(6) times its error in a layer with such an edge
  // (305 ensembles), since there a bead counted in some of them and not in others.
  std::vector<double> pressure = response_to({10.5, 1});
  pressure[static_cast<std::size_t>(lattice.middle() + 12)] *= 1.3;
  constexpr double little = 1e-7;
  for (const double width : {1.0, 1.5}) {
    const DoubleGaussian at_edge{11.5 - width, width};
    CHECK(height_of(pressure, {at_edge.peak - little, width}) ==
          Approx(height_of(pressure, {at_edge.peak + little, width})).epsilon(1e-5));
    CHECK(height_of(pressure, {at_edge.peak, width - little}) ==
          Approx(height_of(pressure, {at_edge.peak, width + little})).epsilon(1e-5));
  }
  // As far inside it does count.
  CHECK(height_of(pressure, {10.5, 1.5}) > 1.005 * height_of(response_to({10.5, 1}), {10.5, 1.5}));
}
