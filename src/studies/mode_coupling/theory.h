#pragma once
#include <complex>
#include <limits>
#include <vector>

#include "analysis/double_gaussian.h"
#include "analysis/jackknife.h"
#include "studies/spreading.h"

namespace granuscope {
/// A peak of sound that moves with speed c and is coupled to itself and to a field that spreads where it is.
struct CouplingSpec {
  double D = 0;          ///< W^2 = D z without coupling, bead diameters
  double c = 0;          ///< of the peak
  double to_itself = 0;  ///< m of its kernel m f(x, z)^2
  double to_torque = 0;  ///< likewise of that with the spreading field
  double D_torque = 0;   ///< of that field: a peak of it has the variance D_torque z
  double depth = 0;      ///< to which it is followed, bead diameters
  double step = 1;       ///< of z
  int ring = 1024;       ///< bead diameters around, a power of 2, more than 2 c depth
  /// Depth of the layer from which the peak starts: z below it fluctuations have reached the share
  /// 1 - exp(-D k^2 (start + z)) of their plateau, those of the spreading field with D_torque. At the surface 0.
  double start = std::numeric_limits<double>::infinity();
};

/// The peak in the frame that moves with c, followed in z.
struct CoupledPeak {
  CouplingSpec spec;
  std::vector<std::vector<std::complex<double>>> modes;  ///< f(k, z), k = 0 .. ring/2 in 2 pi/ring, at each step of z

  /// x_p and W of a Gaussian fitted to exp(-i k c z) f(k) at the step nearest to z under the weights of every fit
  /// (analysis/shape_fit.h).
  DoubleGaussian shape(double z) const { return shape_below(0, z); }
  /// Likewise of f(k, above + z)/f(k, above), as fluctuations tell the peak that are referred to layers `above` below
  /// their bases: what is coupled remembers its past, so that this is another peak than f(k, z) where z is not large
  /// against `above`. Of waves that are there at `above`.
  DoubleGaussian shape_below(double above, double z) const;
  /// The density of that peak, of area 1, at x from the place where it would be without coupling, c z.
  double density_below(double above, double z, double x) const;
  /// f(k, z) at any k > 0, of the step nearest to z.
  std::complex<double> mode_at(double z, double k) const;
  /// f(k, above + z)/f(k, above), 0 where less than 1.1 % are left at `above`.
  std::complex<double> mode_below(double above, double z, double k) const;
};

/// Solves the one-loop mode-coupling equation (Spohn, J. Stat. Phys. 154, 1191 (2014)),
///   d_z f(k, z) = -(D/2) k^2 f(k, z) - k^2 integral over s of M(k, s) f(k, z - s),
/// M(x, s) = to_itself f(x, s)^2 + to_torque t(x + c s, s)^2, t a Gaussian peak of variance D_torque s: a field that
/// stays where it is passes the peak with speed c. The first term makes W^2 grow from D z towards z^(4/3), the second
/// one makes D grow as k^(-1/2) and gives the peak a tail towards that field. Where fluctuations still build up the
/// kernel depends on the depth z - s, too, down to which what is correlated had built up. Errors are of second order in
/// the step, which is implicit; time grows with the square of the depth and with the ring.
CoupledPeak solve_coupled_peak(const CouplingSpec& spec);

/// The modes of t(x + c s, s)^2 at each step: half of the work, and the same for every D and coupling.
using TorqueKernels = std::vector<std::vector<std::complex<double>>>;
TorqueKernels torque_kernels(const CouplingSpec& spec);
CoupledPeak solve_coupled_peak(const CouplingSpec& spec, const TorqueKernels& torque);

/// The two couplings of a peak, m of theory.h.
struct Couplings {
  double to_itself = 0, to_torque = 0;
  Couplings times(double factor) const { return {factor * to_itself, factor * to_torque}; }
};

/// x_p and W^2 at the lags, and D of the bands that were measured.
struct Spreading {
  std::vector<double> peak, width_squared, D_of_bands;
};

/// What the mode-coupling equation says about the lags of a response: fluctuations refer them to layers below their
/// bases, loads act at the surface.
class SpreadingTheory {
 public:
  /// `D_torque`: of the field that the peaks leave behind.
  SpreadingTheory(const DeepResponse& response, double D_torque);
  CoupledPeak peak(double D, Couplings couplings) const;
  Spreading spreading(double D, Couplings couplings) const;
  /// Slopes of W^2 over the octaves.
  std::vector<double> slopes(double D, Couplings couplings) const;
  /// D with which the first slope is as measured. The slope is D and a part that hardly depends on it.
  double D_for(double first_slope, Couplings couplings) const;
  const std::vector<double>& z() const { return z_; }
  /// Depth below the base of the layers that the lags are counted from.
  double reference() const { return reference_; }

 private:
  double D_of(const BandOfModes& band, const CoupledPeak& solved) const;
  double depth() const { return reference_ + z_.back(); }
  CouplingSpec spec(double D, Couplings couplings) const;

  std::vector<double> z_;
  std::vector<BandOfModes> bands_;
  int columns_;
  double c_, D_torque_;
  double start_ = 0, reference_ = 0;  ///< 0: loads act at the surface
  int ring_ = 512;
  TorqueKernels torque_;
};

/// What the theory says at the lags of a response, of which it takes W^2 at the first lag as it is.
struct PredictedSpreading {
  std::vector<double> width_squared,
      width_squared_error;           ///< errors from those of the couplings and of the first octave
  std::vector<double> c;             ///< slope of x_p over each octave
  double D = 0;                      ///< without coupling: such that the first octave spreads as measured
  std::vector<Estimate> slopes;      ///< of W^2 over each octave
  std::vector<Estimate> D_of_bands;  ///< of each band measured: -2 ln|f(k, z_to)/f(k, z_from)|/(k^2 (z_to - z_from))
  double chi2 = 0;                   ///< of the octaves behind the first, errors of both sides
};

/// The prediction, of which nothing is free but the D of the first octave. `error`: of the couplings, relative.
PredictedSpreading predict(const SpreadingTheory& theory, const DeepResponse& response, Couplings couplings,
                           double error, int threads);

/// chi^2 of a prediction against a response over the same lags, of the octaves behind the first.
double chi2_of(const PredictedSpreading& predicted, const DeepResponse& response);

/// Common factor of both couplings, and D, that describe all octaves best.
struct StrengthFit {
  Estimate strength, D;
  double chi2 = 0;
  int degrees_of_freedom = 0;
  double diffusion_chi2 = 0;  ///< of one D in all octaves
};

/// Of slopes of W^2 over the octaves, by Gauss and Newton's steps from `D` and strength 1; errors by taking the slopes'
/// replicates through the last step. Slopes of different octaves hardly depend on each other.
StrengthFit fit_strength(const SpreadingTheory& theory, const std::vector<Replicated>& slopes, Couplings couplings,
                         double D, int threads);

/// The shape f_KPZ of a peak that spreads as z^(2/3): the stationary two-point function of the Kardar-Parisi-Zhang
/// class in one dimension (Prähofer and Spohn, J. Stat. Phys. 115, 255 (2004)). Even, of area 1.
struct KpzPeak {
  static constexpr double step = 0.1;
  std::vector<double> density;  ///< f_KPZ(i step), i = 0, 1, ...; what lies beyond is less than 1e-8
  double variance = 0;          ///< of f_KPZ itself, 0.5105

  /// Characteristic function of the shape scaled to variance 1, at wave number k: mean of cos(k x).
  double mode(double k) const;
};

/// Computed at first use, in less than a second, to some 1e-8 of the largest value.
const KpzPeak& kpz_peak();

/// Variance of the stationary height that the shape is derived from at y: the function whose second derivative is
/// 4 f_KPZ(y). At y = 0 that of the distribution of Baik and Rains.
double stationary_height_variance(double y);

}  // namespace granuscope
