#pragma once
#include <vector>

#include "analysis/line_test.h"
#include "analysis/measured_ensemble.h"
#include "fluctuations.h"
#include "peak_shape.h"
#include "saturation.h"
#include "spreading_theory.h"
#include "studies/spreading.h"

namespace granuscope {

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

/// chi^2 of the law of saturation (saturation.h) and the same with twice D, of the mean of C_w and C_H/c_thrust^2 over
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
      to_torque;                 ///< the couplings m (coupled_peak.h): kappa_hh^2 C_H/144 and kappa_tt^2 C_t^2/(36 C_H)
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
