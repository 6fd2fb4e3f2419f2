#pragma once
#include "analysis/dispersion.h"
#include "analysis/jackknife.h"
#include "studies/sound_form.h"
#include "studies/study.h"

namespace granuscope {
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
