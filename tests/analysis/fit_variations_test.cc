#include "analysis/transport.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/scaling.h"
#include "kit/estimates.h"
#include "model/lattice.h"
#include "synthetic_ensemble.h"

using namespace granuscope;

namespace {

FitSpec window_with_depths_above() {
  FitSpec spec;
  spec.first_layer = 60;
  spec.last_layer = 120;
  spec.layer_step = 5;
  spec.shallow_layer = 30;
  return spec;
}

Transport measure(const KnownTransport& known, double noise) {
  const FitSpec spec = window_with_depths_above();
  return measure_transport(synthetic_ensemble(known, {noise, 4}, 300, layers_to_record(spec, {}), 32, 100), spec, {}, 0)
      .transport;
}

}  // namespace

TEST_CASE("the windows beside a window are shorter or longer by a quarter of its depths, or have other weights") {
  const Transport t = measure({}, 0.3);
  REQUIRE(t.variations.size() == 4);
  CHECK(t.depths_in_window == 13);
  CHECK(t.variations[0].layers == std::array{75, 120});
  CHECK(t.variations[1].layers == std::array{60, 105});
  CHECK(t.variations[2].layers == std::array{45, 120});
  CHECK(t.variations[3].change == "equal_weights");
  CHECK(t.variations[3].layers == t.window_layers);
  CHECK(t.variations[3].c_shift.value != 0);
  for (const FitVariation& variation : t.variations) {
    INFO(variation.change);
    CHECK(variation.c_shift.value == Approx(variation.c.value - t.c.value).margin(1e-15));
    CHECK(variation.D_shift.value == Approx(variation.D.value - t.D.value).margin(1e-15));
    // Most depths are shared: the shift is known better than from independent numbers.
    CHECK(variation.c_shift.standard_error < std::hypot(variation.c.standard_error, t.c.standard_error));
  }
}

TEST_CASE("straight lines have no systematic error beyond their scatter, bent ones show it") {
  const Transport straight = measure({}, 0.3);
  CHECK(straight.c.systematic < straight.c.standard_error);
  CHECK(straight.D.systematic < straight.D.standard_error);
  KnownTransport bent;
  bent.position_power = 1.05;
  bent.width_power = 1.5;
  const Transport t = measure(bent, 0.05);
  CHECK(t.c.systematic > 5 * t.c.standard_error);
  CHECK(t.D.systematic > 5 * t.D.standard_error);
  // dx_p/dz = 0.55 * 1.05 (z/80)^0.05 changes by 0.05 ln(105/52) = 3.5 % over the window; a quarter of it moves the
  // mean by about a tenth of that.
  CHECK(t.c.systematic > 0.0005);
  CHECK(t.c.systematic < 0.01);
}

TEST_CASE("systematic spread: shifts that their errors explain count nothing") {
  CHECK(systematic_spread({test::known(1, 1), test::known(-1, 1)}) == 0);
  CHECK(systematic_spread({test::known(0.1, 1)}) == 0);
  CHECK(systematic_spread({test::known(5, 3), test::known(-5, 3)}) == Approx(4));
  const Estimate unknown = test::unknown("no depth");
  CHECK(systematic_spread({test::known(2, 0), unknown}) == Approx(2));
  CHECK(std::isnan(systematic_spread({unknown})));
  CHECK(std::isnan(systematic_spread({})));
}

TEST_CASE("without depths above there is no longer window, and the reason is said") {
  FitSpec spec = window_with_depths_above();
  spec.shallow_layer = spec.first_layer;
  const Transport t =
      measure_transport(synthetic_ensemble({}, {0.3, 4}, 300, layers_to_record(spec, {}), 32, 100), spec, {}, 0)
          .transport;
  CHECK_FALSE(t.variations[2].c.known());
  CHECK_FALSE(t.variations[2].c_shift.reason.empty());
  CHECK(std::isfinite(t.c.systematic));
}

TEST_CASE("area and background are 1 and 0 for two Gaussians, with errors that cover it") {
  const Transport t = measure({}, 0.5);
  REQUIRE(t.fitted_area.known());
  REQUIRE(t.centre_background.known());
  CHECK(std::abs(t.fitted_area.value - 1) < 4 * t.fitted_area.standard_error);
  CHECK(std::abs(t.centre_background.value) < 4 * t.centre_background.standard_error);
  CHECK(t.fitted_area.standard_error < 0.1);
  CHECK(t.fitted_area.standard_error > 0);
  // A third parameter costs precision and moves nothing.
  CHECK(std::abs(t.c_beside.value - t.c.value) < 4 * t.c_beside.standard_error);
  CHECK(std::abs(t.D_beside.value - t.D.value) < 4 * t.D_beside.standard_error);
  CHECK(t.D_beside.standard_error > t.D.standard_error);
}

TEST_CASE("a plateau between the peaks is found with its share") {
  constexpr int columns = 300;
  constexpr double share = 0.05;
  const auto with_plateau = [](int layer) {
    const Lattice lattice({columns, layer + 1});
    const double z = Lattice::depth(layer), peak = 0.55 * z;
    std::vector<double> x;
    for (int i = 0; i < columns; ++i) x.push_back(lattice.x(layer, i));
    std::vector<double> response = evaluate({peak, std::sqrt(0.08 * z)}, x, columns);
    for (std::size_t i = 0; i < response.size(); ++i) {
      const double inside = std::min(x[i] + 0.5, peak) - std::max(x[i] - 0.5, -peak);
      response[i] = (1 - share) * response[i] + share * std::max(0.0, inside) / (2 * peak);
    }
    return response;
  };
  const FitSpec spec = window_with_depths_above();
  const Transport t =
      measure_transport(synthetic_ensemble(with_plateau, 0.9, {0.02, 4}, columns, layers_to_record(spec, {}), 32, 100),
                        spec, {}, 0)
          .transport;
  REQUIRE(t.centre_background.known());
  // Its ends are those of the fit without it, a little inside.
  CHECK(t.centre_background.value == Approx(share).margin(0.005));
  CHECK(1 - t.fitted_area.value > 3 * t.fitted_area.standard_error);
  // Two Gaussians alone take the plateau for wider peaks; beside it they are right. c hardly knows of it.
  CHECK(t.D.value - 0.08 > 0.005);
  CHECK(t.D_beside.value == Approx(0.08).margin(0.2 * (t.D.value - 0.08)));
  CHECK(t.c_beside.value == Approx(0.55).margin(1e-4));
}

TEST_CASE("exponents know the spread over windows of depth and of friction") {
  std::vector<MeasuredTransport> measured;
  const FitSpec spec = window_with_depths_above();
  for (const double mu : {0.1, 0.15, 0.2, 0.3}) {
    KnownTransport known;
    known.c = tan30 - 0.2 * std::pow(mu, 1.5) - 2 * std::pow(mu, 4);  // no power: gamma depends on the window
    known.D = 1.5 * std::pow(mu, 2.5);
    known.width_offset = 0.5;
    MeasuredEnsemble ensemble = synthetic_ensemble(known, {0.05, static_cast<std::uint64_t>(100 * mu)}, 300,
                                                   layers_to_record(spec, {}), 32, 100);
    ensemble.spec.sampler.mu = mu;
    measured.push_back(measure_transport(ensemble, spec, {}, 0));
  }
  const ScalingWithVariations scaling = fit_scaling_with_variations(measured, {0.1, 0.3});
  REQUIRE(scaling.variations.size() == 6);
  const ScalingFits plain = fit_scaling(measured, {0.1, 0.3});
  CHECK(scaling.fits.gamma.exponent.value == plain.gamma.exponent.value);
  CHECK(std::isnan(plain.gamma.exponent.systematic));
  CHECK(scaling.variations[5].change == "without_highest_mu");
  CHECK(scaling.variations[5].gamma_shift.value < 0);
  CHECK(scaling.variations[5].fits.gamma.points == 3);
  CHECK(scaling.fits.gamma.exponent.systematic > 2 * scaling.fits.gamma.exponent.standard_error);
  CHECK(scaling.fits.beta.exponent.systematic < 3 * scaling.fits.beta.exponent.standard_error);
}
