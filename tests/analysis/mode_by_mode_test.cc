// The estimator fluctuation against loads, mode by mode: in bands of wave numbers, and under the same weights, x_p and
// W^2 must grow with depth as those of the response to loads do. Source of the expected numbers: the estimator
// multiplexed, on other piles.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "analysis/mean_response.h"
#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"

using namespace granuscope;

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
