#include "analysis/shape_diagnostics.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "analysis/weighted_shape.h"

namespace granuscope {
namespace {

using Vector = Eigen::VectorXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr int max_iterations = 50;
constexpr double precision = 1e-8;  ///< of chi^2, relative: a step that gains less ends the search
constexpr double narrowest = 0.05;  ///< bead diameters; a W below it has run away
constexpr int most_halvings = 10;   ///< of a Gauss-Newton step

Eigen::Map<const Vector> as_vector(const std::vector<double>& list) {
  return {list.data(), static_cast<Eigen::Index>(list.size())};
}

/// Modes of a response spread evenly over |x| < reach, each bead holding the part of its width inside.
Vector plateau_modes(double reach, const LayerSpectrum& spectrum) {
  Vector modes = Vector::Zero(static_cast<Eigen::Index>(spectrum.whole.size()));
  const double shift = spectrum.half_shifted ? 0.5 : 0;
  for (int bead = 0; bead + shift - 0.5 < reach; ++bead) {
    const double x = bead + shift;
    const double inside = (std::min(x + 0.5, reach) - std::max(x - 0.5, -reach)) / (2 * reach);
    const double both_sides = x == 0 ? inside : 2 * inside;
    const double angle = 2 * std::numbers::pi * x / spectrum.columns, twice = 2 * std::cos(angle);
    // cos(m angle) for m = 1, 2, ... by the recurrence of Chebyshev's polynomials.
    double before = 1, cosine = twice / 2;
    for (double& mode : modes) {
      mode += both_sides * cosine;
      before = std::exchange(cosine, twice * cosine - before);
    }
  }
  return modes;
}

/// Weighted least squares of G(x_p, W) with one more parameter t: (1 + t) G for the area, (1 - t) G + t plateau for the
/// background.
class ExtendedFit {
 public:
  enum class Extra { area, background };

  /// `sigma`: of each mode.
  ExtendedFit(const LayerSpectrum& spectrum, const DoubleGaussian& shape, const Vector& sigma, Extra extra)
      : spectrum_(spectrum),
        shape_(shape),
        y_(as_vector(spectrum.whole)),
        sigma_(sigma),
        added_(extra == Extra::area ? Vector::Zero(y_.size()) : plateau_modes(shape.peak, spectrum)),
        of_shape_(extra == Extra::area ? 1 : -1),
        modes_(spectrum.whole.size()) {}

  struct Measured {
    Replicated peak, width, t;
    double chi2 = 0;
  };
  Measured measure() {
    const bool found = converge();
    const std::array<double, 3> whole{found ? shape_.peak : nan, found ? shape_.width : nan, found ? t_ : nan};
    Measured measured{{whole[0], {}}, {whole[1], {}}, {whole[2], {}}, found ? residual_.squaredNorm() : nan};
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor(design_);
    for (const auto& without : spectrum_.without_block) {
      const Eigen::Vector3d step = factor.solve(((as_vector(without) - y_).array() / sigma_.array()).matrix());
      measured.peak.without_block.push_back(whole[0] + step(0));
      measured.width.without_block.push_back(whole[1] + step(1));
      measured.t.without_block.push_back(whole[2] + step(2));
    }
    return measured;
  }

 private:
  /// Residuals over noise and their derivatives at (shape, t); returns chi^2.
  double evaluate_at(const DoubleGaussian& shape, double t) {
    fourier_modes(shape, spectrum_.columns, spectrum_.half_shifted, modes_);
    const double amplitude = 1 + of_shape_ * t;
    design_.resize(y_.size(), 3);
    residual_.resize(y_.size());
    for (Eigen::Index i = 0; i < y_.size(); ++i) {
      const ModeValue& g = modes_[static_cast<std::size_t>(i)];
      design_.row(i) << amplitude * g.by_peak, amplitude * g.by_width, added_(i) + of_shape_ * g.value;
      design_.row(i) /= sigma_(i);
      residual_(i) = (y_(i) - amplitude * g.value - t * added_(i)) / sigma_(i);
    }
    return residual_.squaredNorm();
  }

  /// Gauss-Newton with halved steps.
  bool converge() {
    double chi2 = evaluate_at(shape_, t_);
    for (int iteration = 0; iteration < max_iterations; ++iteration) {
      const Eigen::Vector3d step = design_.colPivHouseholderQr().solve(residual_);
      const double before = chi2;
      double share = 2;
      for (int halvings = 0; halvings <= most_halvings; ++halvings) {
        share /= 2;
        const DoubleGaussian shape{shape_.peak + share * step(0), shape_.width + share * step(1)};
        if (!(shape.width > narrowest)) continue;
        chi2 = evaluate_at(shape, t_ + share * step(2));
        if (chi2 <= before) {
          shape_ = shape;
          t_ += share * step(2);
          break;
        }
      }
      if (!(chi2 < before * (1 - precision))) {
        chi2 = evaluate_at(shape_, t_);
        return std::isfinite(chi2);
      }
    }
    return false;
  }

  const LayerSpectrum& spectrum_;
  DoubleGaussian shape_;
  double t_ = 0;
  Vector y_, sigma_, added_;
  double of_shape_;
  std::vector<ModeValue> modes_;
  Eigen::MatrixXd design_;
  Vector residual_;
};

}  // namespace

ShapeDiagnostics diagnose_shape(const LayerSpectrum& spectrum, const ShapeFit& fit, const DoubleGaussian& shape) {
  using Extra = ExtendedFit::Extra;
  const Vector noise = as_vector(spectrum.noise);
  Vector by_width(noise.size());
  for (Eigen::Index i = 0; i < by_width.size(); ++i) {
    const double k = 2 * std::numbers::pi * static_cast<double>(i + 1) / spectrum.columns;
    by_width(i) = 1 / std::sqrt(weight_by_width(k, shape.width));
  }
  const Replicated excess = ExtendedFit(spectrum, fit.shape, noise, Extra::area).measure().t;
  const ExtendedFit::Measured beside = ExtendedFit(spectrum, shape, by_width, Extra::background).measure();
  const ExtendedFit::Measured by_noise = ExtendedFit(spectrum, fit.shape, noise, Extra::background).measure();
  return {.area = transform([](double t) { return 1 + t; }, excess),
          .background = by_noise.t,
          .chi2_beside = by_noise.chi2,
          .peak = beside.peak,
          .width_squared = transform([](double width) { return width * width; }, beside.width)};
}

}  // namespace granuscope
