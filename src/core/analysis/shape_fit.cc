#include "analysis/shape_fit.h"

#include <fmt/format.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit_nlinear.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <numbers>

namespace granuscope {
namespace {

Problem find_window_problem(const char* field, const std::array<double, 2>& window) {
  if (window[0] < window[1]) return {};
  return problem(field, "[{}, {}] is not a range of mu: it must ascend from 0 or more; write [low, high]", window[0],
                 window[1]);
}

}  // namespace

std::vector<Key> keys_of(FitSpec& spec) {
  const std::string table = "fit";
  return {
      make_key(table, "first_layer", "layer", "first layer of the window over which the slopes c and D are taken",
               spec.first_layer, KeyRange{.least = 0}),
      make_key(table, "last_layer", "layer", "last layer of that window, at most lattice.layers - 21", spec.last_layer,
               KeyRange{.least = 0}),
      make_key(table, "layer_step", "layers",
               "distance of the fitted layers; an odd one alternates the two kinds of rows", spec.layer_step,
               KeyRange{.least = 1, .why = "it would never reach the end of the window"}),
      make_key(table, "shallow_layer", "layer", "from here down to the window layers are fitted for the figures only",
               spec.shallow_layer, KeyRange{.least = 0}),
      make_key(
          table, "min_identifiable_width", "bead diameters", "below it the size of a bead hides the width of a peak",
          spec.min_identifiable_width,
          KeyRange{.why = "below about half a bead the width of a peak cannot be told from the bead's (0.5 is usual)"}
              .within(least_identifiable_width, 100)),
      make_key(table, "scaling_window", "",
               "range of mu, or of what is scanned, both ends included, of the exponents beta, gamma and alpha",
               spec.scaling_window, KeyRange{.least = 0}),
      make_key(table, "other_scaling_windows", "", "further ranges of mu whose exponents are shown beside it",
               spec.other_scaling_windows, KeyRange{.least = 0}),
  };
}

bool at_step(const FitSpec& spec, int layer) {
  return layer <= spec.last_layer && (spec.last_layer - layer) % spec.layer_step == 0;
}
bool in_window(const FitSpec& spec, int layer) { return layer >= spec.first_layer && at_step(spec, layer); }

Problem find_problem(const FitSpec& fit, const LatticeSpec& lattice, int unused) {
  const int last_usable = lattice.layers - unused - 1;
  FitSpec copy = fit;  // keys could set what they check
  if (auto found = find_range_problem(keys_of(copy))) return found;
  if (fit.shallow_layer > fit.first_layer) {
    return problem("shallow_layer", "layer {} must lie between 0 and first_layer = {}", fit.shallow_layer,
                   fit.first_layer);
  }
  if (fit.last_layer > last_usable) {
    return problem("last_layer",
                   "layer {} lies beyond the last usable one, {}: the lowest {} of {} layers "
                   "follow another law; end the window at {} or compute {} layers",
                   fit.last_layer, last_usable, unused, lattice.layers, last_usable,
                   static_cast<std::int64_t>(fit.last_layer) + unused + 1);
  }
  const int depths = fit.last_layer < fit.first_layer ? 0 : 1 + (fit.last_layer - fit.first_layer) / fit.layer_step;
  if (depths < least_window_depths) {
    constexpr int steps = least_window_depths - 1;
    const std::int64_t first = fit.last_layer - std::int64_t{steps} * fit.layer_step;
    const int step = (fit.last_layer - fit.first_layer) / steps;
    return problem(step > 0 ? "layer_step" : "first_layer",
                   "the window from layer {} to {} in steps of {} holds {} depth{}, but a slope with "
                   "a test of it needs {}; {}{}",
                   fit.first_layer, fit.last_layer, fit.layer_step, depths, depths == 1 ? "" : "s", least_window_depths,
                   step > 0 ? fmt::format("take steps of at most {}, or ", step) : "",
                   first >= fit.shallow_layer ? fmt::format("begin it at layer {}", first) : "end it deeper");
  }
  if (auto found = find_window_problem("scaling_window", fit.scaling_window)) return found;
  for (const auto& window : fit.other_scaling_windows) {
    if (auto found = find_window_problem("other_scaling_windows", window)) return found;
  }
  return {};
}

std::vector<std::size_t> identifiable_depths(std::span<const DepthUse> depths) {
  std::vector<std::size_t> run;
  for (std::size_t i = depths.size(); i-- > 0;) {
    if (depths[i] == DepthUse::fitted) {
      run.push_back(i);
      continue;
    }
    const bool deeper_was_used = i + 1 == depths.size() || depths[i + 1] == DepthUse::fitted;
    if (depths[i] == DepthUse::unidentified || !deeper_was_used) break;
  }
  std::ranges::reverse(run);
  return run;
}

namespace {

struct FitInput {
  const LayerSpectrum& spectrum;
  DoubleGaussian shape;  ///< what `model` was computed for
  std::vector<ModeValue> model;
};

DoubleGaussian shape_of(const gsl_vector* parameters) {
  return {gsl_vector_get(parameters, 0), gsl_vector_get(parameters, 1)};
}

/// The modes of the shape, kept from the residuals for the Jacobian of the same parameters.
const std::vector<ModeValue>& modes_of(const gsl_vector* parameters, FitInput& input) {
  const DoubleGaussian shape = shape_of(parameters);
  if (shape.peak != input.shape.peak || shape.width != input.shape.width) {
    input.shape = shape;
    fourier_modes(shape, input.spectrum.columns, input.spectrum.half_shifted, input.model);
  }
  return input.model;
}

int residuals(const gsl_vector* parameters, void* data, gsl_vector* out) {
  auto& input = *static_cast<FitInput*>(data);
  const auto& model = modes_of(parameters, input);
  for (std::size_t i = 0; i < model.size(); ++i) {
    gsl_vector_set(out, i, (model[i].value - input.spectrum.whole[i]) / input.spectrum.noise[i]);
  }
  return GSL_SUCCESS;
}

int jacobian(const gsl_vector* parameters, void* data, gsl_matrix* out) {
  auto& input = *static_cast<FitInput*>(data);
  const auto& model = modes_of(parameters, input);
  for (std::size_t i = 0; i < model.size(); ++i) {
    gsl_matrix_set(out, i, 0, model[i].by_peak / input.spectrum.noise[i]);
    gsl_matrix_set(out, i, 1, model[i].by_width / input.spectrum.noise[i]);
  }
  return GSL_SUCCESS;
}

constexpr std::size_t max_iterations = 100;
constexpr double narrowest_start = 0.35;  ///< bead diameters; below it no width can be told from the bead's
constexpr double most_of_start = 5;       ///< k W, beyond which a start takes a mode, exp(-k^2 W^2/2), for 0
constexpr double step_tolerance = 1e-9;   ///< relative; far below any standard error
constexpr double misfit_errors = 2;       ///< standard errors that misfit_at_least leaves out

}  // namespace

std::optional<ShapeFit> fit_shape(const LayerSpectrum& spectrum, DoubleGaussian start) {
  const std::vector<double>&modes = spectrum.whole, &noises = spectrum.noise;
  // GSL's default handler aborts the process; status codes are checked instead.
  [[maybe_unused]] static const auto previous_handler = gsl_set_error_handler_off();
  FitInput input{spectrum, {std::numeric_limits<double>::quiet_NaN(), 0}, std::vector<ModeValue>(modes.size())};
  gsl_multifit_nlinear_fdf problem{};
  problem.f = residuals;
  problem.df = jacobian;
  problem.n = modes.size();
  problem.p = 2;
  problem.params = &input;

  const gsl_multifit_nlinear_parameters settings = gsl_multifit_nlinear_default_parameters();
  const std::unique_ptr<gsl_multifit_nlinear_workspace, decltype(&gsl_multifit_nlinear_free)> workspace(
      gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &settings, problem.n, problem.p),
      gsl_multifit_nlinear_free);
  if (!workspace) throw std::bad_alloc();
  double start_values[] = {start.peak, start.width};
  const gsl_vector_view start_view = gsl_vector_view_array(start_values, 2);
  int info = 0;
  if (gsl_multifit_nlinear_init(&start_view.vector, &problem, workspace.get()) != GSL_SUCCESS) return std::nullopt;
  const int status =
      gsl_multifit_nlinear_driver(max_iterations, step_tolerance, 0, 0, nullptr, nullptr, &info, workspace.get());
  // Without a further step that lowers chi2 at working precision (GSL_ENOPROG) the minimum is reached.
  if (status != GSL_SUCCESS && status != GSL_ENOPROG) return std::nullopt;

  ShapeFit result;
  result.shape = shape_of(gsl_multifit_nlinear_position(workspace.get()));
  result.shape.width = std::abs(result.shape.width);  // the shape is even in both
  result.shape.peak = std::abs(std::remainder(result.shape.peak, spectrum.columns));
  const gsl_vector* final_residuals = gsl_multifit_nlinear_residual(workspace.get());
  const std::vector<ModeValue>& model = modes_of(gsl_multifit_nlinear_position(workspace.get()), input);
  double missed = 0, noise_power = 0, response = 0;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const double residual = gsl_vector_get(final_residuals, i), noise = noises[i];
    result.chi2 += residual * residual;
    missed += (residual * residual - 1) * noise * noise;
    noise_power += std::pow(noise, 4);
    response += model[i].value * model[i].value;
  }
  // A squared Gaussian residual has twice the squared variance of its noise as its variance.
  const double missed_error = std::sqrt(2 * noise_power);
  result.misfit = std::sqrt(std::max(0.0, missed) / response);
  result.misfit_at_least = std::sqrt(std::max(0.0, missed - misfit_errors * missed_error) / response);
  result.degrees_of_freedom = static_cast<int>(modes.size()) - 2;
  if (!std::isfinite(result.chi2) || !std::isfinite(result.shape.peak) || !std::isfinite(result.shape.width))
    return std::nullopt;
  return result;
}

DoubleGaussian coarse_shape(const LayerSpectrum& spectrum, double z) {
  const std::size_t modes = spectrum.whole.size();
  DoubleGaussian best;
  double best_chi2 = std::numeric_limits<double>::infinity();
  std::vector<double> envelope(modes), target(modes);
  for (std::size_t i = 0; i < modes; ++i) target[i] = spectrum.whole[i] / spectrum.noise[i];
  // Of the modes from each one on, beyond which a shape has none.
  std::vector<double> chi2_without_shape(modes + 1, 0.0);
  for (std::size_t i = modes; i-- > 0;) chi2_without_shape[i] = chi2_without_shape[i + 1] + target[i] * target[i];
  // Beyond the far side of the ring a peak is the image of one on this side.
  const double farthest = std::min(2 * spectrum.ray * z, 0.5 * spectrum.columns);
  double width = narrowest_start;
  while (width < 0.5 * z) {
    // The modes without their aliases: near enough for a start, and then one exponential serves every position.
    for (std::size_t i = 0; i < modes; ++i) {
      const double k = 2 * std::numbers::pi * static_cast<double>(i + 1) / spectrum.columns;
      envelope[i] = std::exp(-k * k * width * width / 2) * std::sin(k / 2) / (k / 2) / spectrum.noise[i];
    }
    const double step = std::max(0.5 * width, 0.25);
    const std::size_t of_shape = std::min(
        modes, static_cast<std::size_t>(most_of_start / width * spectrum.columns / (2 * std::numbers::pi)) + 1);
    const int steps = static_cast<int>(farthest / step);
    for (int s = 0; s <= steps; ++s) {
      const double peak = s * step;
      // cos(k_m x_p) for m = 1, 2, ... by the recurrence of Chebyshev's polynomials.
      const double twice = 2 * std::cos(2 * std::numbers::pi / spectrum.columns * peak);
      double before = 1, cosine = twice / 2, chi2 = chi2_without_shape[of_shape];
      for (std::size_t i = 0; i < of_shape; ++i) {
        const double residual = envelope[i] * cosine - target[i];
        chi2 += residual * residual;
        const double next = twice * cosine - before;
        before = cosine;
        cosine = next;
      }
      if (chi2 < best_chi2) {
        best_chi2 = chi2;
        best = {peak, width};
      }
    }
    width *= 1.5;
  }
  return best;
}

namespace {

constexpr double width_of_bead = 1;
constexpr int most_fit_steps = 200;
constexpr double fit_precision = 1e-15;  ///< of the sum of squares, relative to the response's
constexpr double farthest_step = 0.5;    ///< of x_p relative to W
constexpr double least_left = 0.3;       ///< of x_p^2 and W^2 after a step
constexpr double nothing = 1e-6;         ///< x_p^2 relative to W^2, or W^2 in bead diameters^2: as good as 0
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
  const double least_gain = fit_precision * fit.power(at.width);
  for (int step = 0; step < most_fit_steps; ++step) {
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
