#pragma once
#include <vector>

#include "analysis/dispersion.h"
#include "fluctuations.h"

namespace granuscope {

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

}  // namespace granuscope
