#pragma once
#include <array>
#include <string>
#include <vector>

#include "analysis/layer_spectrum.h"

namespace granuscope {

/// Shapes that models of different classes give the response of a layer. As Fourier modes, in q = |k| s:
enum class ResponseShape {
  two_gaussians,  ///< cos(k x_p) exp(-k^2 W^2/2): waves that spread
  one_gaussian,   ///< exp(-k^2 W^2/2): diffusion
  isotropic,      ///< (1 + q) exp(-q), the elastic half plane 2 s^3/[pi (x^2 + s^2)^2]
  orthotropic,    ///< [cos(a q) + sin(a q)/a] exp(-q), an anisotropic elastic half plane; two peaks if a > 1
};
inline constexpr std::array<ResponseShape, 4> all_response_shapes = {
    ResponseShape::two_gaussians, ResponseShape::one_gaussian, ResponseShape::isotropic, ResponseShape::orthotropic};
std::string name_of(ResponseShape shape);  ///< "two Gaussians", ...

/// One of them as it fits best, each mode weighted with its noise.
struct FittedResponseShape {
  double chi2 = 0;
  double position = 0;  ///< of the peaks, bead diameters; 0 where there is one
  double width = 0;     ///< W, or s
};

/// All of them, in the order of all_response_shapes.
using FittedResponseShapes = std::array<FittedResponseShape, all_response_shapes.size()>;
FittedResponseShapes fit_response_shapes(const LayerSpectrum& spectrum, double z);

/// The simplest shape that none with one parameter more beats by `decisive` in chi^2: two Gaussians hold one at x_p =
/// 0, and an orthotropic half plane the isotropic one at a = 0.
ResponseShape best_shape(const FittedResponseShapes& fits);
inline constexpr double decisive_shape_chi2 = 9;  ///< three standard deviations of one parameter

/// W^2 of the single Gaussian that fits these modes best, each weighted as `noise` says (those of a spectrum or of its
/// replicates).
double single_width_squared(const LayerSpectrum& spectrum, const std::vector<double>& modes);

}  // namespace granuscope
