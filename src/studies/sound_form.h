#pragma once
#include <complex>

#include "analysis/dispersion.h"
#include "analysis/double_gaussian.h"
#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "studies/spreading.h"

namespace granuscope {
/// A peak of sound that diffuses and is fed by a field which stays where it is and spreads there by diffusion. A mode
/// of it is, over the depth z,
///   f(k, z) = exp(-i c k z - D k^2 z/2 - (1 + i) B k^(3/2) z):
/// a Gaussian convolved with the one-sided Levy law of index 3/2 and skewness 1, the shape of sound beside a diffusive
/// mode (Popkov, Schmidt and Schuetz, Phys. Rev. Lett. 112, 200602 (2014); Spohn, J. Stat. Phys. 154, 1191 (2014)). A
/// wave decays as with D(k) = D + 2 B/sqrt(k) and has the speed c(k) = c + B sqrt(k), so that
///   c(k) - c = (D(k) - D) k/2.
struct SoundForm {
  double c = 0, D = 0, B = 0;  ///< lengths in bead diameters

  std::complex<double> mode(double k, double z) const;
  /// x_p and W of two Gaussians fitted to such peaks on a ring under the weights of every fit (analysis/shape_fit.h);
  /// x_p is not taken back around the ring.
  DoubleGaussian shape(double z, int columns) const;
  /// Slope of W^2 over each octave from one of these depths to the next.
  std::vector<double> slopes(const std::vector<double>& z, int columns) const;
};

/// B that a coupling m to the field gives: the memory m t^2 of the one-loop equation, t a Gaussian of variance D_field
/// z that the peak passes with the speed c, has over waves that are long against D_field the Laplace transform m/(2
/// sqrt(D_field c k)) exp(i pi/4), which makes B = m/sqrt(8 D_field c).
double fed_by(double coupling, double D_field, double c);

/// The two numbers of a straight model and what is known of them, by least squares.
struct TwoNumbers {
  double first = 0, second = 0;
  double first_variance = 0, second_variance = 0, covariance = 0;
};

/// Of y, of which `by_first` and `by_second` are the derivatives.
TwoNumbers least_squares(const std::vector<double>& y, const std::vector<double>& by_first,
                         const std::vector<double>& by_second, const std::vector<double>& weight);
/// (one - other)/step.
std::vector<double> less(const std::vector<double>& one, const std::vector<double>& other, double step = 1);

/// D and B as they describe some numbers best.
struct FormFit {
  Estimate D, B;
  double D_B = 0;  ///< covariance
  double chi2 = 0;
  int degrees_of_freedom = 0;
};

/// Of D(k) = D + 2 B/sqrt(k), by bands of waves that are long against beads and whose D is known to a quarter; each
/// band has waves of its own. Unknown with fewer than three bands.
FormFit fit_waves(const std::vector<BandOfModes>& bands);

/// Of the slopes of W^2 over the octaves; errors by taking the slopes' replicates through the last step. Slopes of
/// different octaves hardly depend on each other.
FormFit fit_widths(const DeepResponse& response, double D, double B);

/// What one form says about a response.
struct FormTest {
  std::vector<double> slopes;         ///< of W^2 over the octaves
  std::vector<double> width_squared;  ///< at the lags, from the first one, which is taken as measured
  double chi2 = 0;                    ///< of the octaves, or of those behind the first where D suits that one
  int octaves = 0;
};

/// W^2 from D and B of the waves, nothing being taken from W^2. `fit`: with its errors.
FormTest test_waves(const FormFit& fit, const DeepResponse& response);

/// W^2 with this B, and D such that the first octave spreads as measured; `form`: what comes out.
FormTest test_coupling(const Estimate& B, const DeepResponse& response, SoundForm& form);

/// How many times B sqrt(k) the speed of waves, c(k) - c_thrust, is on average: 1 by the form, with chi^2 of that.
struct SpeedTest {
  Estimate ratio;
  double chi2 = 0;
  double chi2_of_none = 0;  ///< of waves that all have the speed c_thrust
  int bands = 0;
};
SpeedTest test_speeds(const FormFit& fit, const DeepResponse& response);

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

/// How much better another shape of the peaks describes one lag than Gaussians do.
struct PeakShapeTest {
  double z = 0;
  int degrees_of_freedom = 0;
  double gaussian = 0, kpz = 0, levy = 0;  ///< chi^2 with x_p and W free; levy: of the form of sound, NaN without it
};
void to_json(Json& json, const PeakShapeTest& test);

/// Holds the modes of one lag against the three shapes, each with the x_p and W that suit it best.
PeakShapeTest test_shape(const LayerSpectrum& spectrum, const LagResponse& lag, const SoundForm& form);

/// Of the three deepest lags of an ensemble as measure_spreading takes it; without the form where its D is 0.
std::vector<PeakShapeTest> test_shapes(const MeasuredEnsemble& deep, const DeepResponse& response,
                                       const SoundForm& form);

/// One of the two peaks, scaled by its own x_p and W to variance and area 1.
struct ScaledPeak {
  double z = 0;
  std::vector<double> x;         ///< (x - x_p)/W
  std::vector<Estimate> height;  ///< 2 W P
};

/// By cosines and sines, which know the one peak from the other, however near that is on the ring.
ScaledPeak scaled_peak(const LayerSpectrum& spectrum, const LagResponse& lag);
ScaledPeak scaled_peak(const SoundForm& form, double z, int columns);

/// Of the three deepest lags.
std::vector<ScaledPeak> scaled_peaks(const MeasuredEnsemble& deep, const DeepResponse& response);

}  // namespace granuscope
