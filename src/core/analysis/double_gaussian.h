#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "analysis/mean_response.h"
#include "sampling/sampler_spec.h"

namespace granuscope {
/// The paper's G(x): two mirror Gaussians of area 1/2 each at +-peak, integrated over the width of a bead, on a ring.
struct DoubleGaussian {
  double peak = 0;   ///< x_p, bead diameters
  double width = 1;  ///< W, bead diameters
};

/// Value at each bead centre x (shape of `x`, bead diameters) on a ring of `columns`; sums to 1 over the ring.
std::vector<double> evaluate(const DoubleGaussian& shape, std::span<const double> x, int columns);

/// The largest value of the two Gaussians per bead diameter (not integrated over a bead), on an open line.
double largest_value(const DoubleGaussian& shape);

/// One Fourier mode of the sampled shape and its derivatives.
struct ModeValue {
  double value, by_peak, by_width;
};

/// sum_j G(x_j) cos(k x_j) over the beads of one layer, k = 2 pi mode / columns, for beads at integer x
/// (`half_shifted` false) or half-integer x (true), for the modes 1 .. modes.size(). With q = k + 2 pi l it is
///   sum over l of (-1)^(l half_shifted) cos(q x_p) exp(-q^2 W^2 / 2) sin(q/2)/(q/2),
/// the sum running over the aliases that sampling at bead centres folds onto k. `sines`: as many, or none of them:
/// sum_j G_+(x_j) sin(k x_j) of the Gaussian G_+ at +peak, of area 1; the same formula with sin(q x_p).
void fourier_modes(const DoubleGaussian& shape, int columns, bool half_shifted, std::span<ModeValue> modes,
                   std::span<ModeValue> sines = {});

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

// What a response will be like, before anything is drawn.

/// The fewest columns, from `columns` on, of a ring on which they are apart at each of these layers alone, however
/// often they have met on the way there, at each of these friction coefficients: fits in Fourier modes need no more.
int columns_apart(const std::vector<double>& mu, const std::vector<int>& layers, int columns);
/// Widths of a peak on the smallest ring that has two waves of k W < 2, which count in a fit of x_p and W.
inline constexpr double widths_of_ring = 6;
/// The fewest columns, from `columns` on, of a ring of so many widths at each of these layers: enough where sines tell
/// a peak from the one that moves to the other side, be they apart or not.
int columns_of_waves(const std::vector<double>& mu, const std::vector<int>& layers, int columns);
}  // namespace granuscope
