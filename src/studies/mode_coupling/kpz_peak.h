#pragma once
#include <vector>

namespace granuscope {
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
