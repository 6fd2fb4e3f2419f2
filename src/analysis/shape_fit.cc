#include "analysis/shape_fit.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit_nlinear.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <numbers>
#include <span>
#include <vector>

#include "model/lattice.h"

namespace granuscope {
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
  const double farthest = std::min(2 * tan30 * z, 0.5 * spectrum.columns);
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

}  // namespace granuscope
