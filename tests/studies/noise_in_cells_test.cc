// Noise that is alike in cells, followed down to where peaks are wider than those: what theory to second order says
// (studies/model_classes/results.h).
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>

#include "ensemble/ensemble_runner.h"
#include "studies/model_classes/results.h"
#include "studies/spreading.h"

using namespace granuscope;

namespace {

/// D of a wave e^(ikx) in stochastic OSL, from the integral that noise_theory() has the limits of.
double D_of_wave(const StochasticOslSpec& spec, double k, double c0, double spacing) {
  const double width = spec.cell_columns, reach = c0 * spec.cell_rows * spacing, end = std::min(width, reach);
  constexpr int steps = 2000;
  std::complex<double> twice_Q = 0;
  for (int i = 0; i < steps; ++i) {
    const double u = (i + 0.5) * end / steps, g_z = 1 - u / reach, g_x = 1 - u / width, slope = -1 / width;
    const std::complex<double> ik(0, k);
    twice_Q += g_z * ((slope + ik * g_x) * std::exp(2.0 * ik * u) + slope - ik * g_x) * end / double{steps};
  }
  const std::complex<double> c = c0 * std::sqrt(1.0 + spec.disorder * spec.disorder * twice_Q / 2.0);
  return -2 * c.imag() / k;
}

/// 2048 piles of a model, over three octaves of depth from the first lag on.
DeepResponse followed(const ModelSpec& model, LatticeSpec size, int first_lag) {
  EnsembleSpec spec;
  spec.sampler.model = model;
  spec.lattice = size;
  spec.response.estimator = EstimatorName::fluctuation;
  spec.response.reference_lag = spec.response.base_step = first_lag;
  spec.response.samples = 2048;
  spec.layers = {first_lag, 2 * first_lag, 4 * first_lag, 8 * first_lag};
  return measure_spreading({spec, run_ensemble(spec, 0, nullptr)}, DeepMeasurement::fluctuations, 0);
}

}  // namespace

// Loads show it only where peaks are still narrow; fluctuations follow them until they are wide against the cells.
TEST_CASE("at depth, noise in cells spreads the peaks of free legs as its theory says, and as z", "[long]") {
  ModelSpec model;
  model.name = ModelName::three_leg;
  model.three_leg = {.middle = 0.3, .noise = 0.26, .cell_columns = 4, .cell_rows = 4};
  const DeepResponse found = followed(model, {1024, 800}, 32);
  const NoiseTheory theory = noise_theory(model);
  const double squared = theory.disorder * theory.disorder, gain = theory.wide.spreading * squared;
  for (const OctaveOfDepth& octave : found.octaves) {
    REQUIRE(octave.D.known());
    CAPTURE(octave.from, octave.D.value, octave.D.standard_error, theory.D0 + gain, octave.exponent.value);
    CHECK(octave.D.standard_error < 0.1 * gain);
    // To the next order: Delta^2 of what is measured.
    CHECK(std::abs(octave.D.value - theory.D0 - gain) < 5 * octave.D.standard_error + 2 * squared * gain);
    CHECK(std::abs(octave.exponent.value - 1) < 5 * octave.exponent.standard_error + 0.01);
    CHECK(std::abs(octave.c.value - theory.c0 * std::sqrt(1 - theory.wide.kappa * squared)) <
          5 * octave.c.standard_error + theory.c0 * squared * squared);
  }
}

TEST_CASE("the integral of the theory has both of its limits") {
  ModelSpec model;
  model.name = ModelName::stochastic_osl;
  model.stochastic_osl = {.disorder = 0.01, .cell_columns = 4, .cell_rows = 4};
  const NoiseTheory theory = noise_theory(model);
  const auto gain = [&](double k) {
    return D_of_wave(model.stochastic_osl, k, theory.c0, rows_of(model).spacing) / std::pow(theory.disorder, 2);
  };
  CHECK(gain(1e-3) == Approx(theory.wide.spreading).epsilon(1e-3));
  CHECK(gain(40) == Approx(theory.narrow->spreading).epsilon(0.02));
}

TEST_CASE("at depth, peaks of stochastic OSL become wider than its cells and spread less, wave by wave as theory says",
          "[long]") {
  ModelSpec model;
  model.name = ModelName::stochastic_osl;
  model.stochastic_osl = {.disorder = 0.3, .cell_columns = 4, .cell_rows = 4};
  const DeepResponse found = followed(model, {512, 400}, 16);
  const NoiseTheory theory = noise_theory(model);
  const double squared = theory.disorder * theory.disorder;
  int known = 0;
  for (const BandOfModes& band : found.bands) {
    // Longer waves have hardly decayed over these lags.
    if (!band.D.known() || band.D.standard_error > 0.04 * band.D.value) continue;
    ++known;
    const double D = D_of_wave(model.stochastic_osl, band.k, theory.c0, rows_of(model).spacing);
    CAPTURE(band.k, band.D.value, band.D.standard_error, D);
    // To the next order: Delta^2 of what is measured.
    CHECK(std::abs(band.D.value - D) < 4 * band.D.standard_error + squared * D);
    // Neither limit would do.
    CHECK(theory.D(0) - band.D.value > 5 * band.D.standard_error);
    CHECK(band.D.value - theory.D(2 * theory.cell) > 5 * band.D.standard_error);
  }
  CHECK(known >= 2);
  CHECK(found.octaves.back().exponent.value + 5 * found.octaves.back().exponent.standard_error < 1);
}
