#pragma once
#include <complex>

#include "analysis/dispersion.h"
#include "analysis/double_gaussian.h"
#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "studies/spreading.h"
#include "studies/study.h"

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

/// The fluctuations of layers of uniformly loaded piles, by wave number: <|x_k|^2> per bead, w = 1 on the mean. The
/// torque of a layer n is t = (-1)^n (T_R + T_L) of its beads, T the tangential forces of the contacts that leave them:
/// contacts turn beads like gears, so that torque balance makes it a conserved field, the third one beside w and H.
struct LayerFluctuations {
  int layer = 0;          ///< the shallowest
  std::vector<double> k;  ///< radians per bead diameter
  std::vector<Replicated> of_w, of_H, of_torque;
  Replicated D_torque;  ///< a peak of torque has the variance D_torque z; bead diameters
};

/// What is drawn for it.
struct FluctuationPiles {
  SamplerSpec sampler;
  int columns = 0, layer = 0;
  std::uint64_t samples = 0;
  int blocks = 0;
};

/// Layers that a pile of them has.
int layers_needed(const FluctuationPiles& piles);

/// Draws the piles, each by itself; threads change no number. Throws InputError if one could not be completed.
LayerFluctuations measure_fluctuations(const FluctuationPiles& piles, int threads);

/// Uniformly loaded piles whose loads lean, or act beside the centres of the beads.
struct LoadedPiles {
  EnsembleSpec spec;
  LoadLine line;
  Replicated thrust;  ///< kappa = 3 sigma_xx / w where fluctuations are saturated
};

/// How the thrust ratio kappa depends on one of the two: kappa(0) + kappa'' x^2/2 + ... x^4.
struct ThrustCurvature {
  Estimate at_zero, curvature;
  LineTest test;  ///< of that form
};

/// Means over a band of modes that are saturated and long against beads.
struct Plateau {
  int layer = 0;
  double k_from = 0, k_to = 0;
  Estimate of_w, of_H, of_torque;
  Estimate ratio;  ///< C_H/C_w; that of sound is c_thrust^2
};

/// How weight, horizontal force and torque couple at one friction coefficient, and how peaks spread beside the form
/// that follows.
struct CoupledSpreading {
  double mu = 0;
  DeepResponse response;
  std::vector<LoadedPiles> leaning, turned;  ///< upright first, ascending in slope, in offset
  ThrustCurvature by_slope, by_torque;
  Plateau plateau;
  Estimate D_torque;
  Estimate to_itself,
      to_torque;                  ///< couplings m of the peak: kappa_hh^2 C_H/144 and kappa_tt^2 C_t^2/(36 C_H)
  Estimate B;                     ///< that to_torque gives
  SoundForm form;                 ///< with that B, and D of the first octave
  FormTest predicted;             ///< by it
  FormFit of_widths;              ///< D and B that describe W^2 best
  Estimate strength;              ///< B of them over the predicted one
  FormFit of_waves;               ///< D and B of D(k)
  FormTest from_waves;            ///< by them
  SpeedTest speeds;               ///< likewise c(k)
  double diffusion_chi2 = 0;      ///< of one D in all octaves
  std::vector<ScaledPeak> peaks;  ///< of the deepest lags
  std::vector<PeakShapeTest> shapes;
};

/// Of an ensemble with the lag 0 recorded.
LoadedPiles measure_loaded(const MeasuredEnsemble& ensemble);

/// Of piles that are alike but for one number of their line of load, `x` of it. Piles of equal sample share their
/// random numbers, which their replicates know.
ThrustCurvature fit_thrust(const std::vector<LoadedPiles>& piles, double LoadLine::*x, Replicated* curvature = nullptr);

/// All of it, from an ensemble as measure_spreading takes it and what else has been measured.
CoupledSpreading measure_coupling(const MeasuredEnsemble& deep, std::vector<LoadedPiles> leaning,
                                  std::vector<LoadedPiles> turned, const LayerFluctuations& layer, int threads);

/// Why the peaks spread faster than diffusion: they are sound, and torque, which stays where it is and spreads there,
/// is conserved, too, and lowers the thrust. One closed form follows (SoundForm), whose B comes from piles under
/// loads that lean or act beside the centres and from the fluctuations of single layers.
std::unique_ptr<Study> mode_coupling_study();

/// What the sentences of page 1 need beside the results; null where nothing is predicted. The prediction holds at a
/// friction coefficient if its strength is 1 within the claim's tolerance and three errors, and if it describes W^2
/// better than one D: errors alone do not make it hold.
Json coupling_page_1(const std::vector<CoupledSpreading>& measured);

}  // namespace granuscope
