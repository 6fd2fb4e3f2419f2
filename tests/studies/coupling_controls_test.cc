// What the study of coupled fields takes from piles, taken from data that are made up and known.
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "model/lattice.h"
#include "studies/mode_coupling/fields.h"

using namespace granuscope;

namespace {

/// `value` and replicates of so many blocks whose means scatter so that its error is `error`.
Replicated replicated_about(double value, double error, int blocks, std::mt19937_64& engine) {
  std::normal_distribution<double> normal(value, error * std::sqrt(blocks));
  std::vector<double> block;
  double sum = 0;
  for (int b = 0; b < blocks; ++b) sum += block.emplace_back(normal(engine));
  Replicated number{sum / blocks, {}};
  for (const double one : block) number.without_block.push_back((sum - one) / (blocks - 1));
  return number;
}

/// Fluctuations at mu = 0.5 over so many octaves, without numbers.
DeepResponse response_of_lags(int octaves) {
  DeepResponse response;
  EnsembleSpec spec;
  spec.sampler.mu = 0.5;
  spec.lattice.columns = 960;
  response.spec = spec_of_lags(spec, usual_first_lag, octaves);
  for (const int lag : response.spec.layers)
    response.lags.push_back({lag, Lattice::depth(lag) - Lattice::depth(0), {}, {}});
  response.c_thrust = {0.527, 1e-4, {}};
  return response;
}

/// As at mu = 0.5.
constexpr SoundForm fed{0.527, 0.148, 0.0445};

/// D(k) and c(k) that the mode of a form has.
std::pair<double, double> wave_of(const SoundForm& form, double k, double z) {
  const std::complex<double> f = form.mode(k, z) * std::polar(1.0, form.c * k * z);  // its phase is small
  return {-2 * std::log(std::abs(f)) / (k * k * z), form.c - std::arg(f) / (k * z)};
}

/// Bands of waves as those of the form, within errors of D and c of this part.
std::vector<BandOfModes> bands_of(const SoundForm& form, double error, std::mt19937_64& engine) {
  std::normal_distribution<double> normal;
  std::vector<BandOfModes> bands;
  for (double k = 0.02; k < 0.8; k *= std::sqrt(2)) {
    BandOfModes& band = bands.emplace_back();
    const auto [D, c] = wave_of(form, k, 10);
    band.k = k;
    band.D = {D * (1 + error * normal(engine)), error * D, {}};
    band.c = {c + error * 0.02 * normal(engine), error * 0.02, {}};
  }
  return bands;
}

/// Whether a number is known by the errors that it states, over many trials.
struct Covered {
  int trials = 0, within = 0;
  double sum = 0, squares = 0;

  void add(const Estimate& number, double truth) {
    const double away = (number.value - truth) / number.standard_error;
    ++trials;
    if (std::abs(away) < 1) ++within;
    sum += away;
    squares += away * away;
  }
  void check() const {
    CAPTURE(within, sum / trials, squares / trials);
    CHECK(within == Approx(0.68 * trials).margin(3 * std::sqrt(trials * 0.68 * 0.32)));
    CHECK(std::abs(sum / trials) < 3.5 / std::sqrt(trials));
    CHECK(squares / trials == Approx(1).margin(3.5 * std::sqrt(2.0 / trials)));
  }
};

}  // namespace

TEST_CASE("Without B a peak is a Gaussian that moves and spreads by diffusion") {
  const SoundForm diffusing{0.5, 0.1, 0};
  for (const double z : {32.0, 64.0, 128.0}) {
    const DoubleGaussian shape = diffusing.shape(z, 512);
    // The fitted Gaussians are integrated over a bead, of variance 1/12.
    CHECK(shape.width * shape.width == Approx(0.1 * z - 1.0 / 12).epsilon(2e-4));
    CHECK(shape.peak == Approx(0.5 * z).epsilon(1e-9));
  }
  CHECK(diffusing.slopes({32, 64, 128}, 512)[1] == Approx(0.1).epsilon(2e-4));
}

TEST_CASE("A peak that goes around the ring is where it would be on a wide one") {
  const double z = 887;
  const DoubleGaussian wide = fed.shape(z, 4096);
  CHECK(wide.peak > 400);
  for (const int columns : {640, 960, 400}) {
    CHECK(fed.shape(z, columns).peak == Approx(wide.peak).margin(0.3));
    CHECK(scaled_peak(fed, z, columns).height[40].value == Approx(0.4).margin(0.03));
  }
}

TEST_CASE("A peak of sound is a Gaussian convolved with the Levy law of index 3/2 behind it") {
  for (const double k : {0.01, 0.1, 0.4}) {
    const auto [D, c] = wave_of(fed, k, 10);
    CHECK(D == Approx(fed.D + 2 * fed.B / std::sqrt(k)));
    CHECK(c - fed.c == Approx((D - fed.D) * k / 2));
  }
  // The stable law with the characteristic function exp(-|s t|^(3/2) (1 + i sign t)) has the density
  // 0.598 s^(3/2) |x|^(-5/2) far out on one side (Nolan, Univariate Stable Distributions, 2020), and next to nothing on
  // the other.
  const double z = 400;
  constexpr int columns = 4096;
  const auto density = [&](double x) {
    double sum = 1;
    for (int m = 1; m < columns / 2; ++m) {
      const double k = 2 * std::numbers::pi * m / columns;
      sum += 2 * (fed.mode(k, z) * std::polar(1.0, k * (fed.c * z + x))).real();
    }
    return sum / columns;
  };
  const double far = 400;
  CHECK(density(-far) / (0.59841 * fed.B * z * std::pow(far, -2.5)) == Approx(1).margin(0.15));
  CHECK(std::abs(density(far)) < 0.02 * density(-far));
  // Its mean is where sound is, so that the fitted peak runs ahead of it, less and less.
  double mean = 0;
  for (int x = -1500; x <= 1500; ++x) mean += x * density(x);
  CHECK(std::abs(mean) < 0.3 * std::sqrt(z));
  CHECK(fed.shape(z, columns).peak > fed.c * z);
  CHECK(fed.shape(4 * z, columns).peak / (4 * z) < fed.shape(z, columns).peak / z);
}

TEST_CASE("The power of depth in W^2 comes to 4/3 far deeper than any pile") {
  const auto power = [](double z) {
    const int columns = static_cast<int>(8 * z);
    return std::log2(std::pow(fed.shape(2 * z, columns).width / fed.shape(z, columns).width, 2));
  };
  CHECK(power(443) == Approx(1.20).margin(0.015));
  CHECK(power(7000) == Approx(1.26).margin(0.01));
  CHECK(power(7e6) == Approx(1.32).margin(0.01));
}

TEST_CASE("D and B are found from waves and from widths where they are known, with errors that cover them") {
  std::mt19937_64 engine(3);
  Covered D_of_waves, B_of_waves, D_of_widths, B_of_widths, speed;
  double chi2_of_waves = 0, chi2_of_widths = 0, predicted = 0;
  DeepResponse response = response_of_lags(4);
  std::vector<double> z;
  for (const LagResponse& lag : response.lags) z.push_back(lag.z);
  response.lags.front().width_squared = {30, 0.1, {}};
  const std::vector<double> slopes = fed.slopes(z, response.spec.lattice.columns);
  REQUIRE(slopes.back() > 1.2 * slopes.front());
  constexpr int trials = 60;
  for (int trial = 0; trial < trials; ++trial) {
    const std::vector<BandOfModes> bands = bands_of(fed, 0.02, engine);
    const FormFit of_waves = fit_waves(bands);
    D_of_waves.add(of_waves.D, fed.D);
    B_of_waves.add(of_waves.B, fed.B);
    chi2_of_waves += of_waves.chi2 / of_waves.degrees_of_freedom / trials;
    response.bands = bands;
    const SpeedTest speeds = test_speeds(of_waves, response);
    speed.add(speeds.ratio, 1);
    CHECK(speeds.chi2_of_none > 3 * speeds.chi2);
    response.slopes_of_width.clear();
    response.octaves.clear();
    for (const double slope : slopes) {
      const Replicated measured = replicated_about(slope, 0.005 * slope, 32, engine);
      response.slopes_of_width.push_back(measured);
      response.octaves.emplace_back().D = estimate(measured);
    }
    const FormFit of_widths = fit_widths(response, 0.9 * fed.D, 2 * fed.B);
    D_of_widths.add(of_widths.D, fed.D);
    B_of_widths.add(of_widths.B, fed.B);
    CHECK(of_widths.degrees_of_freedom == 2);
    chi2_of_widths += of_widths.chi2 / of_widths.degrees_of_freedom / trials;
    SoundForm form;
    const FormTest test = test_coupling({fed.B, 0.02 * fed.B, {}}, response, form);
    CHECK(test.octaves == 3);
    predicted += test.chi2 / 3 / trials;
  }
  for (const Covered* one : {&D_of_waves, &B_of_waves, &D_of_widths, &B_of_widths, &speed}) one->check();
  CAPTURE(chi2_of_waves, chi2_of_widths, predicted);
  CHECK(chi2_of_waves == Approx(1).margin(0.25));
  CHECK(chi2_of_widths == Approx(1).margin(0.5));
  CHECK(predicted < 1.5);
  // A form that is not the one: half of B, of waves and of widths.
  SoundForm form;
  CHECK(test_coupling({fed.B / 2, 0.02 * fed.B, {}}, response, form).chi2 > 60);
  const FormFit wrong{{fed.D, 0.001, {}}, {fed.B / 2, 0.0005, {}}, 0, 0, 0};
  CHECK(test_waves(wrong, response).chi2 > 60);
  CHECK(test_speeds(wrong, response).ratio.value == Approx(2).margin(0.4));
  // Few bands say nothing.
  CHECK_FALSE(fit_waves({response.bands[0], response.bands[1]}).B.known());
}

TEST_CASE("Each of the three shapes of a peak is told from the others where it is the one") {
  const DeepResponse response = response_of_lags(4);
  const double z = response.lags.back().z;
  constexpr int columns = 960;
  const DoubleGaussian shape = fed.shape(z, columns);
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  enum { gaussian, kpz, levy };
  for (const int truth : {gaussian, kpz, levy}) {
    LayerSpectrum spectrum;
    spectrum.columns = columns;
    for (int m = 1; m <= 40; ++m) {
      const double k = 2 * std::numbers::pi * m / columns, kW = k * shape.width;
      const std::complex<double> mode = truth == gaussian ? std::exp(-kW * kW / 2)
                                        : truth == kpz    ? kpz_peak().mode(kW)
                                                          : fed.mode(k, z);
      spectrum.noise.push_back(0.001);
      const double x = truth == levy ? 0 : shape.peak;
      spectrum.whole.push_back((mode * std::polar(1.0, -k * x)).real() + 0.001 * normal(engine));
    }
    // Not where the best fit begins.
    const LagResponse lag{512, z, {shape.peak + 0.3, 0.1, {}}, {1.05 * shape.width * shape.width, 0.1, {}}};
    const PeakShapeTest test = test_shape(spectrum, lag, fed);
    CHECK(test.degrees_of_freedom == 38);
    const double chi2[] = {test.gaussian, test.kpz, test.levy};
    CAPTURE(truth, test.gaussian, test.kpz, test.levy);
    for (const int tried : {gaussian, kpz, levy}) {
      if (tried == truth) CHECK(chi2[tried] < 38 + 4 * std::sqrt(2 * 38));
      if (tried != truth) CHECK(chi2[tried] > 38 + 8 * std::sqrt(2 * 38));
    }
  }
}

TEST_CASE("A scaled peak is the density that its modes were made of") {
  const ScaledPeak peak = scaled_peak(SoundForm{0.5, 0.2, 0}, 222, 960);
  // Without B a Gaussian; its fitted width is that of one integrated over beads.
  double area = 0;
  for (std::size_t i = 0; i < peak.x.size(); ++i) {
    area += (peak.x[1] - peak.x[0]) * peak.height[i].value;
    CHECK(peak.height[i].value ==
          Approx(std::exp(-peak.x[i] * peak.x[i] / 2) / std::sqrt(2 * std::numbers::pi)).margin(0.002));
  }
  CHECK(area == Approx(1).margin(1e-3));
}

TEST_CASE("The curvature of the thrust is found beside a known fourth power, with errors that cover it") {
  std::mt19937_64 engine(7);
  constexpr double at_zero = 0.83, curvature = -3, fourth = 12;
  constexpr int trials = 400;
  int covered = 0;
  double sum = 0, squares = 0, chi2 = 0;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<LoadedPiles> piles;
    for (const double x : {0.0, 0.035, 0.07, 0.105, 0.14, 0.176}) {
      LoadedPiles one;
      one.line.slope = x;
      const double thrust = at_zero + curvature * x * x / 2 + fourth * x * x * x * x;
      one.thrust = replicated_about(thrust, 3e-4, 32, engine);
      piles.push_back(one);
    }
    Replicated replicated;
    const ThrustCurvature found = fit_thrust(piles, &LoadLine::slope, &replicated);
    CHECK(estimate(replicated).standard_error == Approx(found.curvature.standard_error));
    const double away = (found.curvature.value - curvature) / found.curvature.standard_error;
    if (std::abs(away) < 1) ++covered;
    sum += away / trials;
    squares += away * away / trials;
    chi2 += found.test.chi2 / trials;
    if (trial == 0) CHECK(std::abs(found.at_zero.value - at_zero) < 5 * found.at_zero.standard_error);
  }
  CAPTURE(covered, sum, squares, chi2);
  CHECK(chi2 == Approx(3).margin(0.6));  // six loads, three numbers of the form
  CHECK(std::abs(sum) < 0.2);            // a bias less than a fifth of an error
  CHECK(covered == Approx(0.68 * trials).margin(0.09 * trials));
  CHECK(squares == Approx(1).margin(0.3));
  // Where the thrust is not of that form, chi^2 says so.
  std::vector<LoadedPiles> far;
  for (const double x : {0.0, 0.1, 0.2, 0.3, 0.4, 0.5}) {
    LoadedPiles one;
    one.line.slope = x;
    one.thrust = replicated_about(at_zero + 500 * std::pow(x, 6), 3e-4, 32, engine);
    far.push_back(one);
  }
  CHECK(fit_thrust(far, &LoadLine::slope).test.chi2 > 100);
}
