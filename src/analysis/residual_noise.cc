#include "analysis/residual_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "analysis/double_gaussian.h"
#include "analysis/line_fit.h"

namespace granuscope {
namespace {

double squared_distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

/// `sizes` of sub-ensembles: as many for the whole as without a block, or the slope would depend on the residual in
/// another way.
double exponent_of(double residual, double scatter, double blocks, int sizes) {
  std::vector<double> log_piles, log_rms;
  double k = blocks;
  for (int i = 0; i < sizes; ++i) {
    log_piles.push_back(std::log(k));
    log_rms.push_back(std::log(residual + (blocks - k) / (k * (blocks - 1)) * scatter) / 2);
    k /= 2;
  }
  return fit_line(log_piles, log_rms, std::vector<double>(log_piles.size(), 1.0)).slope;
}

}  // namespace

ResidualNoise residual_noise(const LayerSpectrum& spectrum, const Replicated& peak, const Replicated& width) {
  const std::size_t blocks = spectrum.without_block.size(), size = spectrum.whole.size();
  const auto count = static_cast<double>(blocks);
  std::vector<ModeValue> model(size);
  const auto squared_residual = [&](const std::vector<double>& modes, double x_p, double W) {
    fourier_modes({x_p, W}, spectrum.columns, spectrum.half_shifted, model);
    double sum = 0;
    for (std::size_t i = 0; i < size; ++i) sum += std::pow(modes[i] - model[i].value, 2);
    return sum;
  };
  // With blocks of equal size a block's mean lies (B - 1) times as far from the whole, on the other side, as the mean
  // of the others does. Blocks differ by at most one group of piles.
  std::vector<double> distances;
  double total = 0;
  for (const auto& others : spectrum.without_block) {
    distances.push_back(std::pow(count - 1, 2) * squared_distance(others, spectrum.whole));
    total += distances.back();
  }
  ResidualNoise noise;
  noise.residual.value = squared_residual(spectrum.whole, peak.value, width.value);
  noise.scatter.value = total / count;
  for (std::size_t b = 0; b < blocks; ++b) {
    noise.residual.without_block.push_back(
        squared_residual(spectrum.without_block[b], peak.without_block[b], width.without_block[b]));
    // About their own mean, which lies distance/(B - 1)^2 from that of all.
    noise.scatter.without_block.push_back((total - distances[b]) / (count - 1) - distances[b] / std::pow(count - 1, 2));
  }
  return noise;
}

void add(ResidualNoise& a, const ResidualNoise& b) {
  if (a.residual.without_block.empty()) {
    a = b;
    return;
  }
  const auto plus = [](double p, double q) { return p + q; };
  a.residual = transform(plus, a.residual, b.residual);
  a.scatter = transform(plus, a.scatter, b.scatter);
}

namespace {

/// The replicates of a squared mean say too much about its error: of |m + noise|^2, m the true mean, the jackknife
/// takes 4 |m + noise|^2 for what is 4 |m|^2 + 2 noise^2 (times the variance of a component), twice the variance where
/// m = 0. `noise`: the expected square of it.
Replicated without_excess(Replicated square, double noise) {
  const double left = std::sqrt(1 - 0.5 * noise / std::max(noise, square.value));
  double mean = 0;
  for (const double one : square.without_block) mean += one / static_cast<double>(square.without_block.size());
  for (double& one : square.without_block) one = mean + left * (one - mean);
  return square;
}

}  // namespace

Replicated noise_exponent(const ResidualNoise& noise) {
  const auto blocks = static_cast<double>(noise.residual.without_block.size());
  const Replicated residual = without_excess(noise.residual, noise.scatter.value / (blocks - 1));
  Replicated exponent;
  const int sizes = static_cast<int>(std::log2(blocks)) + 1;
  exponent.value = exponent_of(noise.residual.value, noise.scatter.value, blocks, sizes);
  for (std::size_t b = 0; b < residual.without_block.size(); ++b) {
    exponent.without_block.push_back(
        exponent_of(residual.without_block[b], noise.scatter.without_block[b], blocks - 1, sizes));
  }
  return exponent;
}

}  // namespace granuscope
