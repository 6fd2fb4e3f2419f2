// Dispersion of modes, of made-up and of real piles.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "analysis/dispersion.h"
#include "analysis/linear_model.h"
#include "analysis/mean_response.h"
#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"

using namespace granuscope;
using test::LinearModel;

// c(k) and D(k) from the correlations of layers: against a linear model whose modes have one c and one D, and against
// waves whose c and D change with k in a known way.

namespace {

const std::vector<double> edges{0.05, 0.1, 0.2, 0.4};

/// Sums without noise, in two blocks that are alike: fields of amplitudes 1 and s, of which mode k travels at c(k),
/// decays by D(k), and starts with an amplitude and an offset of its own.
template <typename Speed, typename Diffusion>
BlockSums exact_waves(int columns, const std::vector<int>& lags, double s, Speed c, Diffusion D) {
  BlockSums sums;
  sums.layers = lags;
  sums.count = {8, 8};
  const auto width = static_cast<std::size_t>(2 * columns);
  std::vector<double> sum(2 * lags.size() * width);
  for (std::size_t block = 0; block < 2; ++block) {
    for (std::size_t row = 0; row < lags.size(); ++row) {
      const double z = Lattice::depth(lags[row]) - Lattice::depth(0);
      for (int m = 1; 4 * m <= columns; ++m) {
        const double k = 2 * std::numbers::pi * m / columns;
        const double size = 8 * (1 + 0.1 * k) * std::exp(-k * k * (0.7 + D(k) * z) / 2), phase = k * (0.3 + c(k) * z);
        double* const part = &sum[(block * lags.size() + row) * width + 4 * (static_cast<std::size_t>(m) - 1)];
        part[0] = size * std::cos(phase);
        part[1] = size * s * s * std::cos(phase);
        part[2] = part[3] = -size * s * std::sin(phase);
      }
    }
  }
  sums.quantities["propagation"] = {2 * columns, sum, std::vector<double>(sum.size())};
  return sums;
}

}  // namespace

TEST_CASE("a band of modes between edges gives the c and D with which it travels, free of amplitude and offset") {
  const BlockSums sums = exact_waves(
      400, {0, 30, 70}, 0.53, [](double) { return 0.55; }, [](double) { return 0.2; });
  for (const double c_start : {0.53, 0.57}) {
    const auto bands = measure_dispersion(sums, 1, 2, edges, {c_start, 0.1});
    REQUIRE(bands.size() == 3);
    int modes = 0;
    for (const BandOfModes& band : bands) {
      CHECK(band.c.value == Approx(0.55).epsilon(1e-9));
      CHECK(band.D.value == Approx(0.2).epsilon(1e-8));
      CHECK(band.k > band.k_from);
      CHECK(band.k < band.k_to);
      CHECK(band.z_to - band.z_from == Approx(40 * std::sqrt(3) / 2));
      modes += band.modes;
    }
    // Of the modes 0.0157 m, those from 0.05 to 0.4: 4 to 25.
    CHECK(modes == 22);
  }
}

TEST_CASE("c and D that change with k are found band by band") {
  const auto c = [](double k) { return 0.55 - 0.05 * k * k; };
  const auto D = [](double k) { return 0.05 / std::sqrt(k); };
  const BlockSums sums = exact_waves(4000, {0, 60, 120}, 0.5, c, D);
  std::vector<double> narrow;
  for (double k = 0.1; k < 0.4; k += 0.02) narrow.push_back(k);
  for (const BandOfModes& band : measure_dispersion(sums, 1, 2, narrow, {0.55, 0.1})) {
    CHECK(band.c.value == Approx(c(band.k)).epsilon(1e-4));
    CHECK(band.D.value == Approx(D(band.k)).epsilon(1e-2));
  }
}

TEST_CASE("bands without modes are left out, and a band that nothing describes is unknown") {
  BlockSums sums = exact_waves(
      40, {0, 30, 70}, 0.5, [](double) { return 0.55; }, [](double) { return 0.1; });
  const auto bands = measure_dispersion(sums, 1, 2, edges, {0.55, 0.1});
  REQUIRE(bands.size() == 2);  // the first mode is 0.157
  for (double& part : sums.quantities.at("propagation").sum) part = 0;
  CHECK(measure_dispersion(sums, 1, 2, edges, {0.55, 0.1}).empty());
  BlockSums turned = exact_waves(
      40, {0, 30, 70}, 0.5, [](double) { return 0.55; }, [](double) { return 0.1; });
  std::vector<double>& sum = turned.quantities.at("propagation").sum;
  for (std::size_t at = 0; at < sum.size(); at += 4) sum[at + 2] = -sum[at + 2];
  for (const BandOfModes& band : measure_dispersion(turned, 1, 2, edges, {0.55, 0.1})) {
    CHECK_FALSE(band.c.known());
    CHECK(band.c.reason.find("two modes of sound") != std::string::npos);
  }
  const auto widest = half_octave_bands(1536);
  CHECK(widest.back() == Approx(1));
  CHECK(widest.front() <= 2 * std::numbers::pi / 1536);
  CHECK(widest[1] > 2 * std::numbers::pi / 1536);
}

TEST_CASE("the dispersion of a linear model covers its c and D", "[long]") {
  constexpr int ensembles = 100;
  int inside = 0, numbers = 0;
  double pulls = 0;
  for (std::uint64_t r = 0; r < ensembles; ++r) {
    const MeasuredEnsemble ensemble = test::linear_ensemble({}, 5000 + r, 24, {30, 60}, 32, 2);
    for (const BandOfModes& band : measure_dispersion(ensemble.record.sums, 1, 2, edges, {0.55, 0.1})) {
      REQUIRE(band.c.known());
      for (const double pull : {(band.c.value - LinearModel::c) / band.c.standard_error,
                                (band.D.value - LinearModel::D) / band.D.standard_error}) {
        inside += std::abs(pull) <= 1 ? 1 : 0;
        ++numbers;
        pulls += pull;
      }
    }
  }
  CHECK(numbers >= 4 * ensembles);
  CHECK(static_cast<double>(inside) / numbers == Approx(0.683).margin(0.05));
  CHECK(std::abs(pulls / numbers) < 0.15);
}

// c(k) of real piles: against the speed that follows from their thrust, which long waves should have, and in bases that
// lie where long waves still build up.

namespace {

struct WavesOfPiles {
  Estimate c_thrust;
  std::vector<BandOfModes> bands;
};

/// Over the way from the reference lag to `lag` layers below it.
WavesOfPiles waves(double mu, LatticeSpec lattice, std::uint64_t piles, int first_base, int lag,
                   const std::vector<double>& band_edges, double D) {
  EnsembleSpec spec;
  spec.response.estimator = EstimatorName::fluctuation;
  spec.response.samples = piles;
  spec.response.first_base = first_base;
  spec.sampler.mu = mu;
  spec.sampler.seed = 41;
  spec.lattice = lattice;
  spec.layers = {lag};
  const BlockSums sums = run_ensemble(spec, 0, nullptr).sums;
  const Estimate c_thrust = estimate(thrust_speed(sums, 0));
  return {c_thrust, measure_dispersion(sums, 0, 1, band_edges, {c_thrust.value, D})};
}

/// c(k) less c_thrust, whose error is far smaller.
Estimate above_thrust(const WavesOfPiles& piles, std::size_t band) {
  const Estimate& c = piles.bands.at(band).c;
  return {.value = c.value - piles.c_thrust.value,
          .standard_error = std::hypot(c.standard_error, piles.c_thrust.standard_error),
          .reason = c.reason};
}

}  // namespace

TEST_CASE("long waves have the speed of the thrust at small friction, shorter ones less", "[unsanitized]") {
  // 1024 piles of 1500 layers once: -1.2(5)e-4, -2.4(4)e-4, -3.3(2)e-4 and -5.9(2)e-4 at k = 0.125 to 0.25, to 0.37, to
  // 0.74 and to 1.1, nearly in proportion to k.
  const WavesOfPiles piles = waves(0.1, {300, 900}, 512, 0, 60, {0.06, 0.125, 0.25, 0.37, 0.74, 1.1}, 0.005);
  for (const std::size_t longest : {0U, 1U}) {
    const Estimate off = above_thrust(piles, longest);
    CAPTURE(longest, off.value, off.standard_error);
    CHECK(std::abs(off.value) < 4 * off.standard_error);
  }
  CHECK(above_thrust(piles, 1).standard_error < 2e-4);
  const Estimate shorter = above_thrust(piles, 3), shortest = above_thrust(piles, 4);
  CAPTURE(shorter.value, shorter.standard_error, shortest.value, shortest.standard_error);
  CHECK(shorter.value < -4 * shorter.standard_error);
  CHECK(shortest.value < shorter.value);
  CHECK(shortest.value > -1e-3);
}

TEST_CASE("at mu = 0.3 waves are faster than their thrust has it, unless they are very long", "[long]") {
  // Once with 1024 piles: 0.0016(3), 0.00157(9), 0.00209(6) and 0.00231(8) at k = 0.03 to 0.06, to 0.125, to 0.25 and
  // to 0.37, and 0.001(1) below: the limit is not yet seen, but c(k) comes nearer to it.
  const WavesOfPiles piles = waves(0.3, {600, 1600}, 512, 600, 240, {0.015, 0.03, 0.06, 0.125, 0.25, 0.37}, 0.09);
  const Estimate lowest = above_thrust(piles, 0), low = above_thrust(piles, 2), high = above_thrust(piles, 4);
  CAPTURE(lowest.value, lowest.standard_error, low.value, low.standard_error, high.value, high.standard_error);
  CHECK(std::abs(lowest.value) < 4 * lowest.standard_error);
  CHECK(lowest.standard_error < 2e-3);
  CHECK(low.value > 4 * low.standard_error);
  CHECK(high.value - low.value > 2 * std::hypot(low.standard_error, high.standard_error));
  CHECK(std::abs(high.value) < 0.004);
}

TEST_CASE("bases from layer 60 on give no faster waves than deep ones at mu = 0.5", "[long]") {
  // Waves that are not saturated might seem faster by 0.003. They are not: -0.0011(9) at k = 0.06 to 0.1 and -0.0015(5)
  // at 0.1 to 0.2, with four times the deep piles.
  const std::vector<double> band_edges{0.06, 0.1, 0.2};
  const WavesOfPiles shallow = waves(0.5, {1024, 420}, 2048, 60, 240, band_edges, 0.37),
                     deep = waves(0.5, {1024, 1600}, 256, 800, 240, band_edges, 0.37);
  for (const std::size_t band : {0U, 1U}) {
    const Estimate &top = shallow.bands.at(band).c, &bottom = deep.bands.at(band).c;
    const double faster = top.value - bottom.value, error = std::hypot(top.standard_error, bottom.standard_error);
    CAPTURE(band, faster, error);
    CHECK(0.003 - faster > 3 * error);
    CHECK(faster > -0.003 - 3 * error);
    CHECK(error < 0.0013);
  }
}

// The estimator fluctuation against loads, mode by mode: in bands of wave numbers, and under the same weights, x_p and
// W^2 must grow with depth as those of the response to loads do. Source of the expected numbers: the estimator
// multiplexed, on other piles.

namespace {

/// Two mirror Gaussians, as far as the modes of one band tell.
struct BandPeaks {
  double position = 0, width_squared = 0;
};

/// Least squares of cos(k x_p) exp(-k^2 W^2/2) to the modes of wave numbers from k_from to k_to, each of which counts
/// the same whatever its noise: Gauss and Newton's steps.
BandPeaks fit_band(const std::vector<double>& modes, int columns, std::array<double, 2> band, BandPeaks at) {
  for (int step = 0; step < 30; ++step) {
    double xx = 0, xw = 0, ww = 0, x = 0, w = 0;
    for (std::size_t m = 0; m < modes.size(); ++m) {
      const double k = 2 * std::numbers::pi * static_cast<double>(m + 1) / columns;
      if (k < band[0] || k >= band[1]) continue;
      const double length = std::exp(-k * k * at.width_squared / 2), cosine = std::cos(k * at.position);
      const double by_x = -k * length * std::sin(k * at.position), by_w = -k * k / 2 * length * cosine;
      const double left = modes[m] - length * cosine;
      xx += by_x * by_x, xw += by_x * by_w, ww += by_w * by_w, x += by_x * left, w += by_w * left;
    }
    const double determinant = xx * ww - xw * xw;
    at.position += (ww * x - xw * w) / determinant;
    at.width_squared += (xx * w - xw * x) / determinant;
  }
  return at;
}

struct BandSlopes {
  Estimate c, D;
};

BandSlopes slopes_of(const MeasuredEnsemble& ensemble, std::array<double, 2> band, BandPeaks per_depth) {
  const BlockSums& sums = ensemble.record.sums;
  DepthSeries peaks, widths;
  for (std::size_t row = first_response(sums); row < sums.layers.size(); ++row) {
    const double z = Lattice::depth(sums.layers[row]);
    const LayerSpectrum spectrum = layer_spectrum(sums, row, load_size(ensemble.spec.response));
    const BandPeaks start{per_depth.position * (z - 0.5), per_depth.width_squared * z};
    const BandPeaks whole = fit_band(spectrum.whole, spectrum.columns, band, start);
    Replicated peak{whole.position, {}}, width{whole.width_squared, {}};
    for (const auto& modes : spectrum.without_block) {
      const BandPeaks without = fit_band(modes, spectrum.columns, band, whole);
      peak.without_block.push_back(without.position);
      width.without_block.push_back(without.width_squared);
    }
    peaks.z.push_back(z);
    peaks.y.push_back(peak);
    widths.y.push_back(width);
  }
  widths.z = peaks.z;
  return {estimate(line_through(peaks).slope), estimate(line_through(widths).slope)};
}

MeasuredEnsemble ensemble_of(double mu, EstimatorName estimator, LatticeSpec lattice, std::uint64_t samples,
                             const std::vector<int>& layers) {
  EnsembleSpec spec;
  spec.response.estimator = estimator;
  if (estimator == EstimatorName::multiplexed) spec.response = multiplexed_response(0.15, true);
  spec.response.samples = samples;
  spec.sampler.mu = mu;
  spec.sampler.seed = 20024;
  spec.lattice = lattice;
  spec.layers = layers;
  return {spec, run_ensemble(spec, 0, nullptr)};
}

}  // namespace

TEST_CASE("fluctuations travel as loads do, band by band of wave numbers", "[long]") {
  // Loads start at the top, where fluctuations still build up and peaks are faster: at mu = 0.1 by 1e-4 in layers 100
  // to 220, so that they are followed farther down there.
  struct Case {
    double mu, c, D;
    int first_layer;
  };
  const Case one = GENERATE(Case{0.1, 0.575, 0.006, 300}, Case{0.2, 0.568, 0.03, 100}, Case{0.3, 0.558, 0.08, 100},
                            Case{0.5, 0.535, 0.4, 100});
  std::vector<int> layers;
  for (int layer = one.first_layer; layer <= one.first_layer + 120; layer += 15) layers.push_back(layer);
  const int deepest = layers.back();
  const MeasuredEnsemble by_fluctuations =
      ensemble_of(one.mu, EstimatorName::fluctuation, {500, deepest + 580}, 512, layers);
  const MeasuredEnsemble by_loads =
      ensemble_of(one.mu, EstimatorName::multiplexed, {500, deepest + bottom_margin + 1}, 2048, layers);
  // Down from where a tenth of the amplitude is left in the deepest layer.
  double k = std::min(1.5, std::sqrt(2 * std::log(10) / (one.D * Lattice::depth(deepest))));
  double power_of_c = 0, power_of_D = 0, chi2 = 0;
  for (int half_octave = 0; half_octave < 3; ++half_octave, k /= std::numbers::sqrt2) {
    const std::array band{k / std::numbers::sqrt2, k};
    const BandSlopes fluctuations = slopes_of(by_fluctuations, band, {one.c, one.D}),
                     loads = slopes_of(by_loads, band, {one.c, one.D});
    const double error_of_c = std::hypot(fluctuations.c.standard_error, loads.c.standard_error),
                 error_of_D = std::hypot(fluctuations.D.standard_error, loads.D.standard_error);
    const double of_c = (fluctuations.c.value - loads.c.value) / error_of_c,
                 of_D = (fluctuations.D.value - loads.D.value) / error_of_D;
    CAPTURE(one.mu, k, fluctuations.c.value, of_c, error_of_c, fluctuations.D.value, of_D, error_of_D);
    CHECK(std::abs(of_c) < 4);
    CHECK(std::abs(of_D) < 4);
    chi2 += of_c * of_c + of_D * of_D;
    power_of_c += 1 / (error_of_c * error_of_c);
    power_of_D += 1 / (error_of_D * error_of_D);
  }
  CAPTURE(one.mu);
  CHECK(chi2 < 6 + 5 * std::sqrt(12));
  // What all bands together would see.
  CHECK(1 / std::sqrt(power_of_c) < 1.5e-3);
  CHECK(1 / std::sqrt(power_of_D) < 0.07 * one.D);
}

// Responses of piles under leaning loads. Their two peaks move with different speeds, c + s to the one side and c - s
// to the other; averaged over mirror images they stay two peaks of one width as long as s z is small beside W.

namespace {

Transport response_under(double angle, EstimatorName estimator, std::uint64_t samples) {
  FitSpec fit;
  fit.first_layer = fit.shallow_layer = 58;
  fit.last_layer = 148;
  EnsembleSpec spec;
  spec.response.estimator = estimator;
  spec.response.samples = samples;
  if (estimator == EstimatorName::multiplexed) {
    spec.response.opposite = true;
    spec.response.epsilon = 0.15;
  }
  spec.sampler.mu = 0.3;
  spec.sampler.load_angle = angle;
  spec.lattice = {400, estimator == EstimatorName::fluctuation ? 900 : 160};
  spec.layers = layers_to_record(fit, {});
  return measure_transport({spec, run_ensemble(spec, 0, nullptr)}, fit, {}, 0).transport;
}

}  // namespace

TEST_CASE("under loads that lean by two degrees fluctuations, many loads and one find the same response", "[long]") {
  const Transport by_fluctuations = response_under(2, EstimatorName::fluctuation, 1024),
                  by_loads = response_under(2, EstimatorName::multiplexed, 2048),
                  by_one_load = response_under(2, EstimatorName::point, 8192);
  const auto distance = [](const Estimate& one, const Estimate& other) {
    return std::abs(one.value - other.value) / std::hypot(one.standard_error, other.standard_error);
  };
  REQUIRE(by_fluctuations.c.known());
  REQUIRE(by_loads.c.known());
  REQUIRE(by_one_load.c.known());
  CAPTURE(by_fluctuations.c.value, by_loads.c.value, by_one_load.c.value);
  CAPTURE(by_fluctuations.D.value, by_loads.D.value, by_one_load.D.value);
  CHECK(by_loads.c.standard_error < 0.0004);
  CHECK(by_fluctuations.c.standard_error < 0.0002);
  CHECK(by_loads.D.standard_error < 0.03 * by_loads.D.value);
  CHECK(by_fluctuations.D.standard_error < 0.01 * by_loads.D.value);
  CHECK(distance(by_fluctuations.c, by_loads.c) < 4);
  CHECK(distance(by_fluctuations.D, by_loads.D) < 4);
  // An overload of 1 is not small: c is some thousandths larger, as under upright loads.
  CHECK(std::abs(by_one_load.c.value - by_loads.c.value) < 0.005);
  CHECK(std::abs(by_one_load.D.value / by_loads.D.value - 1) < 0.2);
  CHECK(by_one_load.alpha_thrust.value == Approx(by_loads.alpha_thrust.value).margin(3e-4));
  // Leaning loads raise the thrust of saturated layers by kappa_hh h^2/2, kappa_hh = 0.696(26) (the study mode_coupling
  // of examples/spreading.toml).
  const Transport upright = response_under(0, EstimatorName::fluctuation, 1024);
  const double more = by_fluctuations.alpha_thrust.value - upright.alpha_thrust.value;
  const double error = std::hypot(by_fluctuations.alpha_thrust.standard_error, upright.alpha_thrust.standard_error);
  const double h = std::tan(2 * std::numbers::pi / 180);
  CAPTURE(more, error);
  CHECK(error < 1e-4);
  CHECK(std::abs(more - 0.696 * h * h / 2) < 4 * error);
}

TEST_CASE("under loads that lean by eight degrees the mirror images lie apart, and that is said", "[long]") {
  const Transport t = response_under(8, EstimatorName::fluctuation, 256);
  CHECK_FALSE(t.c.known());
  CHECK(t.c.reason.find("another shape") != std::string::npos);
  CHECK(t.alpha_thrust.known());
}
