#pragma once
#include <vector>

#include "analysis/jackknife.h"
#include "coupled_peak.h"
#include "studies/spreading.h"

namespace granuscope {

/// The two couplings of a peak, m of coupled_peak.h.
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

}  // namespace granuscope
