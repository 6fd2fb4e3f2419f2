#pragma once
#include <complex>
#include <limits>
#include <vector>

#include "analysis/double_gaussian.h"

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
  /// (analysis/weighted_shape.h).
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

}  // namespace granuscope
