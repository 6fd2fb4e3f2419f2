#include "analysis/noise_spectrum.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "model/lattice.h"

namespace granuscope {
namespace {

constexpr int most_coefficients = 5;  ///< of ln S; more follow single modes
/// Range and step of the search for D: from next to no friction to beyond mu = 1.7, where damping no longer matters.
constexpr double smallest_damping = 1e-4, largest_damping = 20, damping_step = 2;
constexpr double damping_precision = 0.05;  ///< relative: far less than what its own scatter is worth
constexpr int most_iterations = 100;
constexpr double spectrum_precision = 1e-7;  ///< of ln S
/// A mode whose measured variance is beyond this many times the fitted one counts as that many. It happens in one of
/// 10^5 for 32 blocks, and keeps first steps, taken from a constant S, within bounds.
constexpr double largest_excess = 4;

double wave_number(std::size_t entry, int columns) {
  return 2 * std::numbers::pi * static_cast<double>(entry + 1) / columns;
}

/// k^2 integral from 0 to z of du sin^2(c0 k u) exp(-D k^2 u), twice.
double wave_power(double k, double z, double damping) {
  const double rate = damping * k * k;
  const std::complex<double> turning(rate, 2 * tan30 * k);
  const double still = -std::expm1(-rate * z) / rate;
  const double turned = ((1.0 - std::exp(-turning * z)) / turning).real();
  return k * k * std::max(still - turned, std::numeric_limits<double>::epsilon() * still);
}

/// Chebyshev's polynomials of k on 0 .. pi, shape [modes, coefficients].
Eigen::MatrixXd spectrum_basis(std::size_t modes, int columns, Eigen::Index coefficients) {
  Eigen::MatrixXd basis(static_cast<Eigen::Index>(modes), coefficients);
  for (Eigen::Index m = 0; m < basis.rows(); ++m) {
    const double angle = std::acos(2 * wave_number(static_cast<std::size_t>(m), columns) / std::numbers::pi - 1);
    for (Eigen::Index i = 0; i < coefficients; ++i) basis(m, i) = std::cos(static_cast<double>(i) * angle);
  }
  return basis;
}

}  // namespace

double NoiseSpectrum::fit_spectrum(const std::vector<LayerVariances>& layers, double damping) {
  const std::size_t modes = layers.front().variance.size();
  const auto count = static_cast<Eigen::Index>(modes);
  // What the model leaves to S, which is the same at all depths.
  Eigen::ArrayXXd share(count, static_cast<Eigen::Index>(layers.size()));
  for (std::size_t l = 0; l < layers.size(); ++l) {
    for (std::size_t m = 0; m < modes; ++m) {
      share(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(l)) =
          layers[l].variance[m] / wave_power(wave_number(m, columns_), layers[l].z, damping);
    }
  }
  const Eigen::MatrixXd basis = spectrum_basis(modes, columns_, std::min<Eigen::Index>(most_coefficients, count));
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factor(basis);
  damping_ = damping;
  if (coefficients_.empty()) {
    coefficients_.assign(static_cast<std::size_t>(basis.cols()), 0.0);
    coefficients_.front() = std::log(share.mean());
  }
  Eigen::Map<Eigen::VectorXd> coefficients(coefficients_.data(), basis.cols());
  // Fisher's scoring: every mode has the same weight, so that each step is one projection.
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Eigen::ArrayXd scale = (-(basis * coefficients).array()).exp();
    const Eigen::VectorXd excess = ((share.colwise() * scale).min(largest_excess) - 1).rowwise().mean().matrix();
    const Eigen::VectorXd step = factor.solve(excess);
    coefficients += step;
    if (!(step.cwiseAbs().maxCoeff() > spectrum_precision)) break;
  }
  const Eigen::ArrayXd scale = (-(basis * coefficients).array()).exp();
  double deviance = 0;
  for (std::size_t l = 0; l < layers.size(); ++l) {
    for (std::size_t m = 0; m < modes; ++m) {
      const auto row = static_cast<Eigen::Index>(m);
      const double y = std::min(largest_excess, share(row, static_cast<Eigen::Index>(l)) * scale(row));
      // Measured variances are the same for every D: their own logarithms are left out.
      deviance += y - std::log(scale(row)) + std::log(wave_power(wave_number(m, columns_), layers[l].z, damping));
    }
  }
  return deviance;
}

NoiseSpectrum::NoiseSpectrum(int columns, const std::vector<LayerVariances>& layers) : columns_(columns) {
  // A scan, since the deviance is flat where D matters little, then a golden section of ln D.
  double best = smallest_damping, least = std::numeric_limits<double>::infinity();
  double tried = smallest_damping;
  while (tried < largest_damping) {
    if (const double deviance = fit_spectrum(layers, tried); deviance < least) {
      least = deviance;
      best = tried;
    }
    tried *= damping_step;
  }
  constexpr double golden = 0.6180339887498949;
  double low = std::log(best / damping_step), high = std::log(best * damping_step);
  while (high - low > damping_precision) {
    const double left = high - golden * (high - low), right = low + golden * (high - low);
    if (fit_spectrum(layers, std::exp(left)) < fit_spectrum(layers, std::exp(right))) {
      high = right;
    } else {
      low = left;
    }
  }
  fit_spectrum(layers, std::exp((low + high) / 2));
}

NoiseSpectrum NoiseSpectrum::refitted(const std::vector<LayerVariances>& layers) const {
  NoiseSpectrum other = *this;
  other.fit_spectrum(layers, damping_);
  return other;
}

std::vector<double> NoiseSpectrum::standard_deviations(double z) const {
  const auto modes = static_cast<std::size_t>((columns_ - 1) / 2);
  const Eigen::Map<const Eigen::VectorXd> coefficients(coefficients_.data(),
                                                       static_cast<Eigen::Index>(coefficients_.size()));
  const Eigen::ArrayXd log_spectrum = (spectrum_basis(modes, columns_, coefficients.size()) * coefficients).array();
  std::vector<double> deviations;
  for (std::size_t m = 0; m < modes; ++m) {
    deviations.push_back(std::sqrt(std::exp(log_spectrum(static_cast<Eigen::Index>(m))) *
                                   wave_power(wave_number(m, columns_), z, damping_)));
  }
  return deviations;
}

}  // namespace granuscope
