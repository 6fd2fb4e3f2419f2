#include "analysis/weighted_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace granuscope {
namespace {

constexpr double width_of_bead = 1;
constexpr int most_steps = 200;
constexpr double precision = 1e-15;    ///< of the sum of squares, relative to the response's
constexpr double farthest_step = 0.5;  ///< of x_p relative to W
constexpr double least_left = 0.3;     ///< of x_p^2 and W^2 after a step
constexpr double nothing = 1e-6;       ///< x_p^2 relative to W^2, or W^2 in bead diameters^2: as good as 0
constexpr double first_damping = 1e-4, damping_step = 10, least_damping = 1e-14, most_damping = 1e12;

/// The normal equations of a step in x_p^2 and W^2.
struct NormalEquations {
  double pp = 0, pw = 0, ww = 0, rp = 0, rw = 0;
};

/// Where sines are not to scale, the best factor comes with each shape, and the normal equations are those of what
/// changes of the shape leave after it: a step is then that of all three numbers together.
class WeightedFit {
 public:
  WeightedFit(const LayerSpectrum& spectrum, ResponseModes modes, ModeWeights weights)
      : spectrum_(spectrum),
        modes_(modes),
        by_width_(weights == ModeWeights::by_width),
        cosines_(modes.cosines.size()),
        sines_(modes.sines.size()) {}

  /// Computes the modes of a shape, to which what follows refers.
  void take(const DoubleGaussian& shape) {
    shape_ = shape;
    fourier_modes(shape, spectrum_.columns, spectrum_.half_shifted, cosines_, sines_);
  }
  /// Under the weights of this width.
  double sum_of_squares(double width) const {
    double sum = 0;
    for_each_mode(width, [&](double weight, double mode, const ModeValue& model, bool) {
      sum += weight * (mode - model.value) * (mode - model.value);
    });
    return sum;
  }
  double power(double width) const {
    double sum = 0;
    for_each_mode(width, [&](double weight, double mode, const ModeValue&, bool) { sum += weight * mode * mode; });
    return sum;
  }
  NormalEquations equations() const {
    NormalEquations sums;
    for_each_mode(shape_.width, [&](double weight, double mode, const ModeValue& model, bool) {
      const double by_peak = model.by_peak / (2 * shape_.peak), by_width = model.by_width / (2 * shape_.width);
      const double residual = mode - model.value;
      sums.pp += weight * by_peak * by_peak;
      sums.pw += weight * by_peak * by_width;
      sums.ww += weight * by_width * by_width;
      sums.rp += weight * residual * by_peak;
      sums.rw += weight * residual * by_width;
    });
    if (modes_.sines_to_scale) return sums;
    double vv = 0, vp = 0, vw = 0;
    for_each_mode(shape_.width, [&](double weight, double, const ModeValue& model, bool sine) {
      if (!sine) return;
      vv += weight * model.value * model.value;
      vp += weight * model.value * model.by_peak / (2 * shape_.peak);
      vw += weight * model.value * model.by_width / (2 * shape_.width);
    });
    if (vv > 0) {
      sums.pp -= vp * vp / vv;
      sums.pw -= vp * vw / vv;
      sums.ww -= vw * vw / vv;
    }
    return sums;
  }

 private:
  /// use(weight, mode, what the shape makes of it, whether it is a sine).
  template <typename Use>
  void for_each_mode(double width, Use use) const {
    const double scale = sine_scale(width);
    for_each_unscaled(width, [&](double weight, std::size_t i) {
      use(weight, modes_.cosines[i], cosines_[i], false);
      if (i >= sines_.size()) return;
      const ModeValue& sine = sines_[i];
      use(weight, modes_.sines[i], ModeValue{scale * sine.value, scale * sine.by_peak, scale * sine.by_width}, true);
    });
  }

  /// The best factor of the shape's sines. None is negative: with the peaks' images on a ring the sines change sign.
  double sine_scale(double width) const {
    if (modes_.sines_to_scale) return 1;
    double vv = 0, mv = 0;
    for_each_unscaled(width, [&](double weight, std::size_t i) {
      vv += weight * sines_[i].value * sines_[i].value;
      mv += weight * sines_[i].value * modes_.sines[i];
    });
    return vv > 0 ? std::max(0.0, mv / vv) : 0;
  }

  template <typename Use>
  void for_each_unscaled(double width, Use use) const {
    // exp(-a m^2) for m = 1, 2, ... by recurrence.
    const double step_of_k = 2 * std::numbers::pi / spectrum_.columns;
    const double a = by_width_ ? step_of_k * step_of_k * (width * width + width_of_bead * width_of_bead) / 4 : 0;
    double weight = std::exp(-a), ratio = std::exp(-3 * a);
    const double ratio_of_ratios = std::exp(-2 * a);
    for (std::size_t i = 0; i < cosines_.size(); ++i) {
      use(weight, i);
      weight *= ratio;
      ratio *= ratio_of_ratios;
    }
  }

  const LayerSpectrum& spectrum_;
  ResponseModes modes_;
  bool by_width_;
  DoubleGaussian shape_;
  std::vector<ModeValue> cosines_, sines_;
};

}  // namespace

double weight_by_width(double k, double width) {
  return std::exp(-k * k * (width * width + width_of_bead * width_of_bead) / 4);
}

// Levenberg and Marquardt's steps in x_p^2 and W^2, in which the shape is smooth where peaks merge or are narrower than
// beads, with the weights of the last W: they end where the least squares under the weights of W have that W. GSL's
// solver keeps the weights that it begins with.
std::optional<DoubleGaussian> weighted_shape(const LayerSpectrum& spectrum, ResponseModes modes, ModeWeights weights,
                                             DoubleGaussian start) {
  DoubleGaussian at;
  at.width = std::max(start.width, std::sqrt(nothing));
  at.peak = std::max(start.peak, std::sqrt(nothing) * at.width);
  WeightedFit fit(spectrum, modes, weights);
  if (!modes.sines.empty()) {
    // They tell x_p from columns - x_p, as the cosines that the start is from do not.
    const auto squares_at = [&](double peak) {
      fit.take({peak, at.width});
      return fit.sum_of_squares(at.width);
    };
    if (squares_at(spectrum.columns - at.peak) < squares_at(at.peak)) at.peak = spectrum.columns - at.peak;
  }
  fit.take(at);
  NormalEquations here = fit.equations();
  double damping = first_damping, squares = fit.sum_of_squares(at.width);
  const double least_gain = precision * fit.power(at.width);
  for (int step = 0; step < most_steps; ++step) {
    const double pp = here.pp * (1 + damping), ww = here.ww * (1 + damping), width_squared = at.width * at.width;
    const double determinant = pp * ww - here.pw * here.pw;
    double square_step = (here.rp * ww - here.rw * here.pw) / determinant;  // of x_p^2
    double width_step = (here.rw * pp - here.rp * here.pw) / determinant;   // of W^2
    if (square_step < 0 && at.peak * at.peak < nothing * width_squared) {   // merged: x_p stays where it is
      square_step = 0;
      width_step = here.rw / ww;
    }
    const double gain = here.rp * square_step + here.rw * width_step;
    if (!std::isfinite(gain)) return std::nullopt;
    if (gain <= least_gain || damping > most_damping || width_squared < nothing) {
      return DoubleGaussian{std::abs(std::remainder(at.peak, spectrum.columns)), at.width};
    }
    const double part = std::min(
        {1.0, 2 * farthest_step * at.peak * at.width / std::abs(square_step), width_squared / std::abs(width_step)});
    const DoubleGaussian next{
        std::sqrt(std::max(at.peak * at.peak + part * square_step, least_left * at.peak * at.peak)),
        std::sqrt(std::max(width_squared + part * width_step, least_left * width_squared))};
    fit.take(next);
    if (fit.sum_of_squares(at.width) <= squares) {
      at = next;
      here = fit.equations();
      squares = fit.sum_of_squares(at.width);
      damping = std::max(damping / damping_step, least_damping);
    } else {
      damping *= damping_step;
    }
  }
  return std::nullopt;
}

}  // namespace granuscope
