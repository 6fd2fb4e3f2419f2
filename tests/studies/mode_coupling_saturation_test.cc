#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "studies/mode_coupling/measure.h"

using namespace granuscope;

TEST_CASE("Fluctuations that saturate by the law have in each band the share that it states") {
  const auto band = [](double k, double D, double error) {
    BandOfModes one;
    one.k = k;
    one.D = {D, error, {}};
    return one;
  };
  // D = 0.2/sqrt(k), and a band that tells nothing.
  const DiffusionOfWaves law({band(0.01, 50, 40), band(0.04, 1, 0.02), band(0.64, 0.25, 0.005)});
  CHECK(law.D(0.16) == Approx(0.5));
  CHECK(law.D(0.01) == Approx(1));
  CHECK(law.D(0.9) == Approx(0.25));
  CHECK(law.relative_error(0.16) == Approx(0.02));
  CHECK(law.saturation(0.16, 100) == Approx(1 - std::exp(-0.5 * 0.16 * 0.16 * 100)));
  CHECK_FALSE(DiffusionOfWaves({band(0.01, 50, 40)}).known());

  constexpr int columns = 256, layer = 200;
  const double z = layer * std::sqrt(3) / 2;
  LayerFluctuations made{.layer = layer, .k = {}, .of_w = {}, .of_H = {}, .of_torque = {}};
  for (int m = 1; m <= (columns - 1) / 2; ++m) {
    const double k = 2 * std::numbers::pi * m / columns, share = law.saturation(k, z);
    made.k.push_back(k);
    made.of_w.push_back({0.3 * share, {0.31 * share, 0.29 * share}});
    made.of_H.push_back({0.1 * share, {0.1 * share, 0.1 * share}});
  }
  const std::vector<SaturatingSpectrum> spectra = saturating_spectra({made}, law);
  REQUIRE(spectra.size() == 1);
  CHECK(spectra[0].z == Approx(z));
  REQUIRE(spectra[0].bands.size() > 8);
  int modes = 0;
  for (const BandOfFluctuations& one : spectra[0].bands) {
    CAPTURE(one.k);
    CHECK(one.k_from <= one.k);
    CHECK(one.k < one.k_to);
    CHECK(one.of_w.value == Approx(0.3 * one.saturation.value));
    CHECK(one.of_w.without_block[0] == Approx(0.31 * one.saturation.value));
    CHECK(one.of_H.value == Approx(0.1 * one.saturation.value));
    // 2 % of D, where little has built up.
    if (one.saturation.value < 0.1)
      CHECK(one.saturation.standard_error == Approx(0.02 * one.saturation.value).epsilon(0.1));
    if (one.saturation.value < 0.1) CHECK(one.doubled == Approx(2 * one.saturation.value).epsilon(0.1));
    modes += one.modes;
  }
  CHECK(spectra[0].bands.front().saturation.value < 0.1);
  CHECK(modes == 40);  // k < 1
}
