#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "analysis/dispersion.h"
#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "model/pile.h"
#include "sampling/sampler_spec.h"
#include "studies/mode_coupling/theory.h"
#include "studies/spreading.h"

namespace granuscope {
/// (one - other)/step.
inline std::vector<double> difference(const std::vector<double>& one, const std::vector<double>& other,
                                      double step = 1) {
  std::vector<double> result;
  for (std::size_t i = 0; i < one.size(); ++i) result.push_back((one[i] - other[i]) / step);
  return result;
}

/// The step in two parameters that takes the residuals, data less model, away best by least squares. Of derivatives of
/// the model.
inline std::array<double, 2> best_step(const std::vector<double>& residual, const std::vector<double>& by_first,
                                       const std::vector<double>& by_second, const std::vector<double>& weight) {
  double aa = 0, ab = 0, bb = 0, ar = 0, br = 0;
  for (std::size_t i = 0; i < residual.size(); ++i) {
    aa += weight[i] * by_first[i] * by_first[i];
    ab += weight[i] * by_first[i] * by_second[i];
    bb += weight[i] * by_second[i] * by_second[i];
    ar += weight[i] * by_first[i] * residual[i];
    br += weight[i] * by_second[i] * residual[i];
  }
  const double determinant = aa * bb - ab * ab;
  return {(ar * bb - br * ab) / determinant, (br * aa - ar * ab) / determinant};
}

/// How the thrust ratio of a row of beads goes with what the row happens to carry:
/// kappa = kappa(0) + by_slope h^2/2 + by_torque t^2/2, h = H/w and t the torque over w of so many beads, from the
/// fluctuations of uniformly loaded piles. In long rows it is what loads that lean, or act beside the centres, do to
/// it.
struct ThrustInBlocks {
  int beads = 0;
  Replicated by_slope, by_torque;
};

/// Sums over all rows of that length of which the parabola is the least squares. They add up.
class BlockRegression {
 public:
  explicit BlockRegression(int beads) : beads_(beads) {}
  int beads() const { return beads_; }
  /// The rows of one layer, as many as fit into it; as LayerFluctuations what torque is.
  void add(const Pile& pile, int layer);
  void add(const BlockRegression& other, double times = 1);
  double by_slope() const;
  double by_torque() const;

 private:
  /// Covariances of h^2/2, t^2/2 and the thrust ratio.
  struct Moments {
    double hh, ht, tt, h_thrust, t_thrust;
  };
  Moments moments() const;

  int beads_;
  double rows_ = 0;
  double sum_[3] = {}, products_[3][3] = {};  ///< of those three numbers
};

/// Of rows of one length, from the regressions over the piles of each block.
ThrustInBlocks thrust_in_blocks(const std::vector<BlockRegression>& blocks);

/// A solution of the mode-coupling equation, referred to layers at the depth `reference` below the base.
struct ReferredPeak {
  const CoupledPeak& solution;
  double reference = 0;
};

/// How much better another shape of the peaks describes one lag than Gaussians do.
struct PeakShapeTest {
  double z = 0;
  int degrees_of_freedom = 0;
  double gaussian = 0, kpz = 0, coupled = 0;  ///< chi^2 with x_p and W free
};

/// Holds the modes of one lag against the three shapes, each with the x_p and W that suit it best.
PeakShapeTest test_shape(const LayerSpectrum& spectrum, const LagResponse& lag, ReferredPeak coupled);

/// One of the two peaks, scaled by its own x_p and W to variance and area 1.
struct ScaledPeak {
  double z = 0;
  std::vector<double> x;         ///< (x - x_p)/W
  std::vector<Estimate> height;  ///< 2 W P
};

/// By cosines and sines, which know the one peak from the other, however near that is on the ring.
ScaledPeak scaled_peak(const LayerSpectrum& spectrum, const LagResponse& lag);
ScaledPeak scaled_peak(ReferredPeak coupled, double z);

/// The fluctuations of one layer of uniformly loaded piles, by wave number: <|x_k|^2> per bead, w = 1 on the mean.
/// The torque of a layer n is t = (-1)^n (T_R + T_L) of its beads, T the tangential forces of the contacts that leave
/// them: contacts turn beads like gears, so that torque balance makes it a conserved field, the third one beside w and
/// H.
struct LayerFluctuations {
  int layer = 0;
  std::vector<double> k;  ///< radians per bead diameter
  std::vector<Replicated> of_w, of_H, of_torque;
};

/// Those of several layers, and how torque spreads.
struct Fluctuations {
  std::vector<LayerFluctuations> layers;  ///< ascending
  Replicated D_torque;                    ///< a peak of torque has the variance D_torque z; bead diameters
  /// Of the lower half of the layers: rows of 8, 16, ... beads up to half of a layer, that of which is uniform.
  std::vector<ThrustInBlocks> thrust;
};

/// What is drawn for it.
struct FluctuationPiles {
  SamplerSpec sampler;
  int columns = 0;
  std::vector<int> layers;  ///< ascending
  std::uint64_t samples = 0;
  int blocks = 0;
};

/// Layers that a pile of them has.
int layers_needed(const FluctuationPiles& piles);

/// Draws the piles, each by itself; threads change no number. Throws InputError if one could not be completed.
Fluctuations measure_fluctuations(const FluctuationPiles& piles, int threads);

/// The fluctuations of a layer in a band of modes half an octave wide, beside what is expected of them.
struct BandOfFluctuations {
  double k_from = 0, k_to = 0;  ///< edges, radians per bead diameter
  double k = 0;                 ///< root mean square of the modes' wave numbers
  int modes = 0;
  Replicated of_w, of_H;  ///< as LayerFluctuations
  Estimate saturation;    ///< share of the plateau that has built up, by the law below
  double doubled = 0;     ///< the same with twice D
};

struct SaturatingSpectrum {
  int layer = 0;
  double z = 0;                           ///< below the loads, where nothing fluctuates
  std::vector<BandOfFluctuations> bands;  ///< ascending in k
};

/// D of waves of any length, from bands that were followed.
class DiffusionOfWaves {
 public:
  /// Bands whose D has an error above a quarter are left out.
  explicit DiffusionOfWaves(const std::vector<BandOfModes>& bands);
  bool known() const { return !k_.empty(); }
  /// On straight lines of log D against log k, beyond the bands that of the nearest one.
  double D(double k) const { return std::exp(interpolated(k, log_D_)); }
  double relative_error(double k) const { return interpolated(k, error_); }
  /// The share 1 - exp(-D(k) k^2 z) of the plateau that fluctuations have in the depth z: a mode's amplitude decays as
  /// exp(-D k^2 z/2), W^2 = D z, and what each layer adds decays likewise.
  double saturation(double k, double z, double times_D = 1) const;

 private:
  double interpolated(double k, const std::vector<double>& y) const;
  std::vector<double> k_, log_D_, error_;  ///< logarithm of k
};

std::vector<SaturatingSpectrum> saturating_spectra(const std::vector<LayerFluctuations>& layers,
                                                   const DiffusionOfWaves& diffusion);

/// Uniformly loaded piles whose loads lean, or act beside the centres of the beads.
struct LoadedPiles {
  EnsembleSpec spec;
  LoadLine line;
  Replicated thrust;        ///< kappa = 3 sigma_xx / w where fluctuations are saturated
  Replicated thrust_below;  ///< the same much deeper: equal, if they are
};

/// How the thrust ratio kappa depends on one of the two: kappa(0) + kappa'' x^2/2 + ... x^4.
struct ThrustCurvature {
  Estimate at_zero, curvature;
  Estimate curvature_change;  ///< what it is much deeper, less that
  LineTest test;              ///< of that form
};

/// Means over a band of modes that are saturated and long against beads, in the deepest layer.
struct Plateau {
  int layer = 0;
  double k_from = 0, k_to = 0;
  Estimate of_w, of_H, of_torque;
  Estimate ratio;             ///< C_H/C_w; that of sound is
  Estimate c_thrust_squared;  ///< of the piles whose response is followed
};

/// chi^2 of the law of saturation (measure.h) and the same with twice D, of the mean of C_w and C_H/c_thrust^2 over
/// the plateau: each of the two swings about the law where less than some waves fit into the depth, and against the
/// other, since what a layer adds is horizontal force alone.
struct SaturationTest {
  double chi2 = 0, doubled_chi2 = 0;
  int points = 0;  ///< bands of layers, those that are short of their plateau
};

/// The same response measured in another way, with the prediction and the fit of its own: nothing is taken from the
/// other but the couplings.
struct CheckedSpreading {
  DeepResponse response;
  PredictedSpreading predicted;
  StrengthFit fit;
};

/// What the mode-coupling theory of the three conserved fields, weight, horizontal force and torque, says at one
/// friction coefficient, beside what is measured.
struct CoupledSpreading {
  double mu = 0;
  DeepResponse response;
  std::vector<LoadedPiles> leaning, turned;  ///< upright first, ascending in slope, in offset
  std::vector<LoadedPiles> twice_as_wide;    ///< of the largest slope and offset, where asked for
  std::vector<LayerFluctuations> layers;
  std::vector<SaturatingSpectrum> spectra;  ///< of them, by bands
  SaturationTest saturation;
  ThrustCurvature by_slope, by_torque;
  std::vector<ThrustInBlocks> in_blocks;  ///< the same, from fluctuations
  Plateau plateau;
  Estimate D_torque;
  Estimate to_itself,
      to_torque;                 ///< the couplings m (theory.h): kappa_hh^2 C_H/144 and kappa_tt^2 C_t^2/(36 C_H)
  PredictedSpreading predicted;  ///< with both; empty where something is unknown
  PredictedSpreading without_torque;
  std::vector<CheckedSpreading> checks;
  StrengthFit fit;
  std::vector<ScaledPeak> peaks;  ///< of the deepest lags
  ScaledPeak predicted_peak;      ///< of the last of them; no errors
  std::vector<PeakShapeTest> shapes;
};

/// Of an ensemble with two lags recorded.
LoadedPiles measure_loaded(const MeasuredEnsemble& ensemble);

/// The difference of two numbers that share their blocks.
Estimate difference_of(const Replicated& one, const Replicated& other);

/// The thrust ratio deeper less that here, of the load where it is most errors away from 0.
Estimate largest_change_with_depth(const CoupledSpreading& one);

/// Of piles that are alike but for one number of their line of load, `x` of it. Piles of equal sample share their
/// random numbers, which their replicates know.
ThrustCurvature fit_thrust(const std::vector<LoadedPiles>& piles, double LoadLine::*x, Replicated* curvature = nullptr);

/// All of it, from an ensemble as measure_spreading takes it and what else has been measured.
CoupledSpreading measure_coupling(const MeasuredEnsemble& deep, std::vector<LoadedPiles> leaning,
                                  std::vector<LoadedPiles> turned, std::vector<LoadedPiles> twice_as_wide,
                                  Fluctuations fluctuations, std::vector<DeepResponse> checks, int threads);

}  // namespace granuscope
