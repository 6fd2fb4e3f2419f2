#include "analysis/shape_fit.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "analysis/double_gaussian.h"

namespace granuscope {
namespace {

using Vector = Eigen::VectorXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr int most_steps_of_gauss = 50;
constexpr double search_precision = 1e-8;  ///< of chi^2, relative: a step that gains less ends the search
constexpr double narrowest_kept = 0.05;    ///< bead diameters; a W below it has run away
constexpr int most_halvings = 10;          ///< of a Gauss-Newton step

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
    for (int iteration = 0; iteration < most_steps_of_gauss; ++iteration) {
      const Eigen::Vector3d step = design_.colPivHouseholderQr().solve(residual_);
      const double before = chi2;
      double share = 2;
      for (int halvings = 0; halvings <= most_halvings; ++halvings) {
        share /= 2;
        const DoubleGaussian shape{shape_.peak + share * step(0), shape_.width + share * step(1)};
        if (!(shape.width > narrowest_kept)) continue;
        chi2 = evaluate_at(shape, t_ + share * step(2));
        if (chi2 <= before) {
          shape_ = shape;
          t_ += share * step(2);
          break;
        }
      }
      if (!(chi2 < before * (1 - search_precision))) {
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

double chi2_excess(const ShapeFit& fit) {
  return (fit.chi2 - fit.degrees_of_freedom) / std::sqrt(2.0 * fit.degrees_of_freedom);
}

std::string reason_against_two_gaussians(const ShapeFit& fit) {
  const double largest = fit.shape.width < narrow_peak ? largest_misfit_of_narrow_peaks : largest_misfit;
  if (!(chi2_excess(fit) > largest_chi2_excess && fit.misfit_at_least > largest)) return {};
  return fmt::format(
      "two Gaussians miss {:.0f} % of the response, more than {:.0f} % and more than its noise explains: it has "
      "another shape",
      100 * fit.misfit, 100 * largest);
}

std::string reason_against_identification(const ShapeFit& fit, const PeakEvidence& evidence, const FitSpec& spec) {
  if (std::string other_shape = reason_against_two_gaussians(fit); !other_shape.empty()) return other_shape;
  if (fit.shape.width < spec.min_identifiable_width) {
    return fmt::format(
        "the fitted width {:.2f} is below {} bead diameters: the width of a bead hides it; take more layers",
        fit.shape.width, spec.min_identifiable_width);
  }
  // What goes to which side tells x_p from W also where the peaks overlap.
  if (evidence.for_moved_peak > least_evidence_for_two_peaks) return {};
  if (fit.shape.peak < fit.shape.width) {
    return "the two peaks are closer to the middle than their width: position and width cannot be told apart";
  }
  if (!(evidence.for_two_peaks > least_evidence_for_two_peaks)) {
    return fmt::format(
        "the noise leaves open whether there are two peaks or one: χ² differs by {:.1f}, and at least {} is required; "
        "more "
        "piles can tell",
        evidence.for_two_peaks, least_evidence_for_two_peaks);
  }
  return {};
}

namespace {

constexpr double narrowest_peak = 0.3;    ///< bead diameters
constexpr double scan_step = 1.4;         ///< ratio of neighbouring widths of the scan
constexpr double width_precision = 1e-4;  ///< relative; chi^2 is flat to second order at its minimum

/// chi^2 of two Gaussians at distance x_p = ratio W, as a function of W.
class TiedShape {
 public:
  TiedShape(const LayerSpectrum& spectrum, double ratio)
      : spectrum_(spectrum), ratio_(ratio), modes_(spectrum.whole.size()) {}

  double chi2(double width) {
    fourier_modes({ratio_ * width, width}, spectrum_.columns, spectrum_.half_shifted, modes_);
    double sum = 0;
    for (std::size_t i = 0; i < modes_.size(); ++i) {
      const double residual = (modes_[i].value - spectrum_.whole[i]) / spectrum_.noise[i];
      sum += residual * residual;
    }
    return sum;
  }

  /// Smallest chi^2 over all widths: a scan that no local minimum can fool, then a golden section.
  double least_chi2(double widest) {
    double best_width = narrowest_peak, best = chi2(narrowest_peak);
    double width = narrowest_peak * scan_step;
    while (width < widest) {
      if (const double value = chi2(width); value < best) {
        best = value;
        best_width = width;
      }
      width *= scan_step;
    }
    constexpr double golden = 0.6180339887498949;
    double low = best_width / scan_step, high = best_width * scan_step;
    double left = high - golden * (high - low), right = low + golden * (high - low);
    double at_left = chi2(left), at_right = chi2(right);
    while (high - low > width_precision * best_width) {
      if (at_left < at_right) {
        high = right;
        right = left;
        at_right = at_left;
        left = high - golden * (high - low);
        at_left = chi2(left);
      } else {
        low = left;
        left = right;
        at_left = at_right;
        right = low + golden * (high - low);
        at_right = chi2(right);
      }
    }
    return std::min({best, at_left, at_right});
  }

 private:
  const LayerSpectrum& spectrum_;
  double ratio_;
  std::vector<ModeValue> modes_;
};

/// Standard errors of the sines.
std::vector<double> noise_of_sines(const BlockMeans& sines) {
  std::vector<double> noise;
  for (std::size_t m = 0; m < sines.whole.size(); ++m) {
    Replicated sine{sines.whole[m], {}};
    for (const auto& without : sines.without_block) sine.without_block.push_back(without[m]);
    noise.push_back(estimate(sine).standard_error);
  }
  return noise;
}

/// What chi^2 of cosines and sines prefers a peak beside the middle by to the best one in the middle, whose cosines
/// have chi^2 `in_the_middle`. The cosines of `best` are those of its image across the ring, too; where they tell no
/// peak from two, the shape that x_p and W are taken from is nearer.
double weigh_motion(const LayerSpectrum& spectrum, double in_the_middle, const DoubleGaussian& best) {
  const std::vector<double>&of_sines = spectrum.sines.whole, noise = noise_of_sines(spectrum.sines);
  std::vector<ModeValue> cosines(spectrum.whole.size()), sines(of_sines.size());
  const auto chi2_at = [&](double peak, double width) {
    fourier_modes({peak, width}, spectrum.columns, spectrum.half_shifted, cosines, sines);
    double sum = 0;
    for (std::size_t i = 0; i < cosines.size(); ++i) {
      sum += std::pow((cosines[i].value - spectrum.whole[i]) / spectrum.noise[i], 2);
    }
    for (std::size_t i = 0; i < sines.size(); ++i) sum += std::pow((sines[i].value - of_sines[i]) / noise[i], 2);
    return sum;
  };
  const DoubleGaussian weighted =
      weighted_shape(spectrum, spectrum.modes(), ModeWeights::by_width, best).value_or(best);
  double moved = in_the_middle;
  for (std::size_t i = 0; i < noise.size(); ++i) moved += std::pow(of_sines[i] / noise[i], 2);
  const double middle = moved;
  for (const DoubleGaussian& shape : {best, weighted}) {
    moved = std::min({moved, chi2_at(shape.peak, shape.width), chi2_at(spectrum.columns - shape.peak, shape.width)});
  }
  return middle - moved;
}

}  // namespace

PeakEvidence weigh_peaks(const LayerSpectrum& spectrum, const ShapeFit& best) {
  const double widest = 0.5 * spectrum.columns;
  const double one_gaussian = TiedShape(spectrum, 0).least_chi2(widest);
  const double edge = TiedShape(spectrum, 1).least_chi2(widest);
  PeakEvidence evidence;
  evidence.against_one_gaussian = one_gaussian - best.chi2;
  const bool two_peaks = best.shape.peak > best.shape.width;
  // The edge belongs to both sides; a search that missed a shallow minimum cannot make either side worse than it.
  const double with_one = two_peaks ? std::min(one_gaussian, edge) : std::min({best.chi2, one_gaussian, edge});
  const double with_two = two_peaks ? std::min(best.chi2, edge) : edge;
  evidence.for_two_peaks = with_one - with_two;
  if (!spectrum.sines.whole.empty() && spectrum.sines_to_scale)
    evidence.for_moved_peak = weigh_motion(spectrum, one_gaussian, best.shape);
  return evidence;
}

namespace {

/// Share of the bead at x that lies within W + 1/2 of +-x_p. Beads that count whole or not at all would make height
/// jump where an edge passes the middle of one, which no jackknife follows.
double share_within(double x, const DoubleGaussian& shape) {
  return std::clamp(shape.width + 1 - std::abs(std::abs(x) - shape.peak), 0.0, 1.0);
}

}  // namespace

Replicated peak_height(const BlockMeans& response, const Lattice& lattice, int layer, const Replicated& peak,
                       const Replicated& width) {
  const auto height = [&](const std::vector<double>& pressure, const DoubleGaussian& shape) {
    std::vector<double> x, shares;
    double measured = 0;
    for (int i = 0; i < lattice.columns(); ++i) {
      const double at = lattice.x(layer, i), share = share_within(at, shape);
      if (share == 0) continue;
      x.push_back(at);
      shares.push_back(share);
      measured += share * pressure[static_cast<std::size_t>(i)];
    }
    const std::vector<double> fitted = evaluate(shape, x, lattice.columns());
    return largest_value(shape) * measured / std::inner_product(shares.begin(), shares.end(), fitted.begin(), 0.0);
  };
  Replicated result;
  result.value = height(response.whole, {peak.value, width.value});
  for (std::size_t b = 0; b < response.without_block.size(); ++b) {
    result.without_block.push_back(height(response.without_block[b], {peak.without_block[b], width.without_block[b]}));
  }
  return result;
}

}  // namespace granuscope
