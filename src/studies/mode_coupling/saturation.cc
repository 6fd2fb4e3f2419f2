#include "saturation.h"

#include <algorithm>
#include <cmath>

#include "model/lattice.h"

namespace granuscope {
namespace {

constexpr double most_error = 0.25;  ///< of D, relative: bands with more tell nothing

}  // namespace

DiffusionOfWaves::DiffusionOfWaves(const std::vector<BandOfModes>& bands) {
  for (const BandOfModes& band : bands) {
    if (!(band.D.value > 0 && band.D.standard_error < most_error * band.D.value)) continue;
    k_.push_back(std::log(band.k));
    log_D_.push_back(std::log(band.D.value));
    error_.push_back(band.D.standard_error / band.D.value);
  }
}

double DiffusionOfWaves::interpolated(double k, const std::vector<double>& y) const {
  const double at = std::log(k);
  const auto above = static_cast<std::size_t>(std::lower_bound(k_.begin(), k_.end(), at) - k_.begin());
  if (above == 0) return y.front();
  if (above == k_.size()) return y.back();
  return std::lerp(y[above - 1], y[above], (at - k_[above - 1]) / (k_[above] - k_[above - 1]));
}

double DiffusionOfWaves::saturation(double k, double z, double times_D) const {
  return -std::expm1(-times_D * D(k) * k * k * z);
}

std::vector<SaturatingSpectrum> saturating_spectra(const std::vector<LayerFluctuations>& layers,
                                                   const DiffusionOfWaves& diffusion) {
  std::vector<SaturatingSpectrum> spectra;
  for (const LayerFluctuations& layer : layers) {
    const std::vector<double> edges = half_octave_bands(2 * static_cast<int>(layer.k.size()) + 1);
    SaturatingSpectrum& spectrum = spectra.emplace_back();
    spectrum.layer = layer.layer;
    spectrum.z = Lattice::depth(layer.layer) - Lattice::depth(0);
    for (std::size_t e = 0; e + 1 < edges.size(); ++e) {
      BandOfFluctuations band;
      band.k_from = edges[e];
      band.k_to = edges[e + 1];
      if (diffusion.known()) {
        band.saturation = {0, 0, {}};
      } else {
        band.saturation.reason = "D is not known for any wave";
      }
      std::vector<Replicated> w, H;
      for (std::size_t m = 0; m < layer.k.size(); ++m) {
        const double k = layer.k[m];
        if (k < band.k_from || k >= band.k_to) continue;
        w.push_back(layer.of_w[m]);
        H.push_back(layer.of_H[m]);
        band.k += k * k;
        if (!diffusion.known()) continue;
        const double share = diffusion.saturation(k, spectrum.z);
        band.saturation.value += share;
        band.saturation.standard_error += diffusion.saturation(k, spectrum.z, 1 + diffusion.relative_error(k)) - share;
        band.doubled += diffusion.saturation(k, spectrum.z, 2);
      }
      if (w.empty()) continue;
      const auto modes = static_cast<double>(w.size());
      band.modes = static_cast<int>(w.size());
      band.k = std::sqrt(band.k / modes);
      band.of_w = mean_of(w);
      band.of_H = mean_of(H);
      band.saturation.value /= modes;
      band.saturation.standard_error /= modes;
      band.doubled /= modes;
      spectrum.bands.push_back(std::move(band));
    }
  }
  return spectra;
}

}  // namespace granuscope
