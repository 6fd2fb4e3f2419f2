#include "studies/mode_coupling/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/multiplexed_estimator.h"
#include "model/lattice.h"
#include "sampling/sampler.h"
#include "studies/mode_coupling/theory.h"
#include "support/error.h"

namespace granuscope {
namespace {

/// Modes of the plateau: those that have decayed by exp(-saturated) since the top, and are long against beads.
constexpr double saturated = 4, largest_k = 0.5;
constexpr double nearly_saturated = 0.9;  ///< beyond, the law says no more than that there is a plateau
constexpr std::size_t tested_shapes = 3;
constexpr const char* unknown_lags = "the response is not known at every lag; give more piles";

}  // namespace

LoadedPiles measure_loaded(const MeasuredEnsemble& ensemble) {
  const BlockSums& sums = ensemble.record.sums;
  return {ensemble.spec, load_line(ensemble.spec.sampler), block_mean(sums, "thrust", 0),
          block_mean(sums, "thrust", sums.layers.size() - 1)};
}

Estimate difference_of(const Replicated& one, const Replicated& other) {
  return estimate(transform([](double a, double b) { return a - b; }, one, other));
}

Estimate largest_change_with_depth(const CoupledSpreading& one) {
  Estimate largest{0, 1, {}};
  for (const auto* loads : {&one.leaning, &one.turned}) {
    for (const LoadedPiles& piles : *loads) {
      const Estimate change = difference_of(piles.thrust_below, piles.thrust);
      const auto errors = [](const Estimate& of) { return std::abs(of.value) / of.standard_error; };
      if (errors(change) > errors(largest)) largest = change;
    }
  }
  return largest;
}

ThrustCurvature fit_thrust(const std::vector<LoadedPiles>& piles, double LoadLine::*x, Replicated* curvature) {
  ThrustCurvature result;
  std::vector<double> squares, weights;
  std::vector<Replicated> thrust;
  for (const LoadedPiles& one : piles) {
    squares.push_back(one.line.*x * one.line.*x);
    weights.push_back(std::pow(estimate(one.thrust).standard_error, -2));
    thrust.push_back(one.thrust);
  }
  const auto fit = [&](const std::vector<double>& y) { return fit_parabola(squares, y, weights); };
  result.at_zero = estimate(transform_all(thrust, [&](const auto& y) { return fit(y).intercept; }));
  const Replicated second = transform_all(thrust, [&](const auto& y) { return 2 * fit(y).slope; });
  result.curvature = estimate(second);
  result.test = test_parabola(squares, thrust);
  std::vector<Replicated> changes;
  changes.reserve(piles.size());
  for (const LoadedPiles& one : piles)
    changes.push_back(transform([](double a, double b) { return a - b; }, one.thrust_below, one.thrust));
  result.curvature_change = estimate(transform_all(changes, [&](const auto& y) { return 2 * fit(y).slope; }));
  if (curvature != nullptr) *curvature = second;
  return result;
}

namespace {

/// The plateau with replicates.
struct PlateauMeans {
  Replicated of_w, of_H, of_torque;
};

Plateau plateau_of(const LayerFluctuations& layer, double D, PlateauMeans& means) {
  Plateau plateau;
  plateau.layer = layer.layer;
  plateau.k_from = std::sqrt(saturated / (D * Lattice::depth(layer.layer)));
  plateau.k_to = largest_k;
  std::vector<Replicated> w, H, torque;
  for (std::size_t m = 0; m < layer.k.size(); ++m) {
    if (layer.k[m] < plateau.k_from || layer.k[m] > plateau.k_to) continue;
    w.push_back(layer.of_w[m]);
    H.push_back(layer.of_H[m]);
    torque.push_back(layer.of_torque[m]);
  }
  if (w.empty()) return plateau;
  means = {mean_of(w), mean_of(H), mean_of(torque)};
  plateau.of_w = estimate(means.of_w);
  plateau.of_H = estimate(means.of_H);
  plateau.of_torque = estimate(means.of_torque);
  plateau.ratio = estimate(transform([](double a, double b) { return b / a; }, means.of_w, means.of_H));
  return plateau;
}

SaturationTest test_saturation(const std::vector<SaturatingSpectrum>& spectra, double c_squared,
                               const PlateauMeans& plateau) {
  SaturationTest test;
  for (const SaturatingSpectrum& spectrum : spectra) {
    for (const BandOfFluctuations& band : spectrum.bands) {
      if (band.k_to > largest_k || !(band.saturation.value < nearly_saturated)) continue;
      const Estimate share =
          estimate(transform([&](double w, double H, double w_all,
                                 double H_all) { return (w + H / c_squared) / (w_all + H_all / c_squared); },
                             band.of_w, band.of_H, plateau.of_w, plateau.of_H));
      const double error = std::hypot(share.standard_error, band.saturation.standard_error);
      test.chi2 += std::pow((share.value - band.saturation.value) / error, 2);
      test.doubled_chi2 += std::pow((share.value - band.doubled) / error, 2);
      ++test.points;
    }
  }
  return test;
}

bool all_known(const DeepResponse& response) {
  return std::all_of(response.octaves.begin(), response.octaves.end(),
                     [](const OctaveOfDepth& octave) { return octave.D.known(); });
}

}  // namespace

CoupledSpreading measure_coupling(const MeasuredEnsemble& deep, std::vector<LoadedPiles> leaning,
                                  std::vector<LoadedPiles> turned, std::vector<LoadedPiles> twice_as_wide,
                                  Fluctuations fluctuations, std::vector<DeepResponse> checks, int threads) {
  CoupledSpreading result;
  result.mu = deep.spec.sampler.mu;
  result.response = measure_spreading(deep, DeepMeasurement::fluctuations, threads);
  result.leaning = std::move(leaning);
  result.turned = std::move(turned);
  result.twice_as_wide = std::move(twice_as_wide);
  result.layers = std::move(fluctuations.layers);
  result.spectra = saturating_spectra(result.layers, DiffusionOfWaves(result.response.bands));
  result.in_blocks = std::move(fluctuations.thrust);
  result.D_torque = estimate(fluctuations.D_torque);
  Replicated by_slope, by_torque;
  result.by_slope = fit_thrust(result.leaning, &LoadLine::slope, &by_slope);
  result.by_torque = fit_thrust(result.turned, &LoadLine::offset, &by_torque);
  const auto unknown = [&](const char* reason) {
    for (Estimate* one : {&result.to_itself, &result.to_torque, &result.fit.strength, &result.fit.D})
      one->reason = reason;
    return result;
  };
  if (!all_known(result.response)) return unknown(unknown_lags);
  PlateauMeans plateau;
  result.plateau = plateau_of(result.layers.back(), result.response.octaves.front().D.value, plateau);
  if (!result.plateau.of_H.known()) {
    for (Estimate* one : {&result.plateau.of_w, &result.plateau.of_H, &result.plateau.of_torque, &result.plateau.ratio,
                          &result.plateau.c_thrust_squared})
      one->reason = "no mode of the deepest layer is saturated";
    return unknown("no mode of the deepest layer is saturated; give deeper fluctuation_layers");
  }
  const Estimate& c = result.response.c_thrust;
  result.plateau.c_thrust_squared = {c.value * c.value, 2 * c.value * c.standard_error, {}};
  result.saturation = test_saturation(result.spectra, result.plateau.c_thrust_squared.value, plateau);
  result.to_itself =
      estimate(transform([](double A, double C_H) { return A * A * C_H / 144; }, by_slope, plateau.of_H));
  result.to_torque = estimate(transform([](double A, double C_t, double C_H) { return A * A * C_t * C_t / (36 * C_H); },
                                        by_torque, plateau.of_torque, plateau.of_H));
  const SpreadingTheory theory(result.response, result.D_torque.value);
  const Couplings both{result.to_itself.value, result.to_torque.value};
  const double error =
      std::hypot(result.to_itself.standard_error, result.to_torque.standard_error) / (both.to_itself + both.to_torque);
  result.predicted = predict(theory, result.response, both, error, threads);
  result.without_torque = predict(theory, result.response, {both.to_itself, 0},
                                  result.to_itself.standard_error / result.to_itself.value, threads);
  for (DeepResponse& check : checks) {
    CheckedSpreading checked{std::move(check), {}, {}};
    if (all_known(checked.response)) {
      const SpreadingTheory of_check(checked.response, result.D_torque.value);
      checked.predicted = predict(of_check, checked.response, both, error, threads);
      checked.fit = fit_strength(of_check, checked.response.slopes_of_width, both, checked.predicted.D, threads);
    } else {
      checked.fit.strength.reason = checked.fit.D.reason = unknown_lags;
    }
    result.checks.push_back(std::move(checked));
  }
  result.fit = fit_strength(theory, result.response.slopes_of_width, both, result.predicted.D, threads);
  const CoupledPeak solution = theory.peak(result.predicted.D, both);
  const ReferredPeak coupled{solution, theory.reference()};
  const std::size_t lags = result.response.lags.size();
  for (std::size_t i = lags - std::min(lags, tested_shapes); i < lags; ++i) {
    const LayerSpectrum spectrum = layer_spectrum(deep.record.sums, i + 1, 0);
    result.peaks.push_back(scaled_peak(spectrum, result.response.lags[i]));
    result.shapes.push_back(test_shape(spectrum, result.response.lags[i], coupled));
  }
  result.predicted_peak = scaled_peak(coupled, result.response.lags.back().z);
  return result;
}

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

void BlockRegression::add(const Pile& pile, int layer) {
  const double sign = layer % 2 == 0 ? 1 : -1;
  for (int first = 0; first + beads_ <= pile.lattice.columns(); first += beads_) {
    double w = 0, H = 0, torque = 0, thrust = 0;
    for (int i = first; i < first + beads_; ++i) {
      const std::size_t at = pile.lattice.index(layer, i);
      w += pile.V_R[at] + pile.V_L[at];
      H += pile.H_R[at] + pile.H_L[at];
      torque += sign * (sqrt3 * (pile.H_R[at] + pile.H_L[at]) - pile.V_R[at] + pile.V_L[at]) / 2;
      thrust += sqrt3 * (pile.H_R[at] - pile.H_L[at]);
    }
    const double row[3] = {H * H / (2 * w * w), torque * torque / (2 * w * w), thrust / w};
    rows_ += 1;
    for (int a = 0; a < 3; ++a) {
      sum_[a] += row[a];
      for (int b = 0; b < 3; ++b) products_[a][b] += row[a] * row[b];
    }
  }
}

void BlockRegression::add(const BlockRegression& other, double times) {
  rows_ += times * other.rows_;
  for (int a = 0; a < 3; ++a) {
    sum_[a] += times * other.sum_[a];
    for (int b = 0; b < 3; ++b) products_[a][b] += times * other.products_[a][b];
  }
}

BlockRegression::Moments BlockRegression::moments() const {
  const auto covariance = [&](int a, int b) { return products_[a][b] / rows_ - sum_[a] / rows_ * (sum_[b] / rows_); };
  return {covariance(0, 0), covariance(0, 1), covariance(1, 1), covariance(0, 2), covariance(1, 2)};
}

double BlockRegression::by_slope() const {
  const Moments m = moments();
  return (m.h_thrust * m.tt - m.t_thrust * m.ht) / (m.hh * m.tt - m.ht * m.ht);
}

double BlockRegression::by_torque() const {
  const Moments m = moments();
  return (m.t_thrust * m.hh - m.h_thrust * m.ht) / (m.hh * m.tt - m.ht * m.ht);
}

ThrustInBlocks thrust_in_blocks(const std::vector<BlockRegression>& blocks) {
  BlockRegression all(blocks.front().beads());
  for (const BlockRegression& block : blocks) all.add(block);
  ThrustInBlocks result{all.beads(), {all.by_slope(), {}}, {all.by_torque(), {}}};
  for (const BlockRegression& block : blocks) {
    BlockRegression without = all;
    without.add(block, -1);
    result.by_slope.without_block.push_back(without.by_slope());
    result.by_torque.without_block.push_back(without.by_torque());
  }
  return result;
}

namespace {

/// chi^2 of the peaks mode(k W) exp(-i k x_p) and their mirror images with the best x_p and W.
template <typename Mode>
double chi2_of(const LayerSpectrum& spectrum, double peak, double width, Mode mode) {
  const auto residuals = [&](double x, double W) {
    std::vector<double> result;
    for (std::size_t m = 0; m < spectrum.whole.size(); ++m) {
      const double k = 2 * std::numbers::pi * static_cast<double>(m + 1) / spectrum.columns;
      const double modelled = (mode(k * W) * std::polar(1.0, -k * x)).real();
      result.push_back((spectrum.whole[m] - modelled) / spectrum.noise[m]);
    }
    return result;
  };
  const std::vector<double> alike(spectrum.whole.size(), 1.0);
  std::vector<double> here = residuals(peak, width);
  for (int step = 0; step < 30; ++step) {
    const double h = 1e-4 * width;
    const auto [of_peak, of_width] = best_step(here, difference(here, residuals(peak + h, width), h),
                                               difference(here, residuals(peak, width + h), h), alike);
    const double size = std::hypot(of_peak, of_width), part = std::min(1.0, 0.3 * width / size);
    peak += part * of_peak;
    width += part * of_width;
    here = residuals(peak, width);
    if (size < 1e-6 * width) break;
  }
  double chi2 = 0;
  for (const double one : here) chi2 += one * one;
  return chi2;
}

/// How far scaled peaks reach, in widths, and how fine they are.
constexpr double reach = 4, fineness = 0.1;

std::vector<double> scaled_places() {
  std::vector<double> x;
  for (int i = 0; i <= static_cast<int>(2 * reach / fineness); ++i) x.push_back(fineness * i - reach);
  return x;
}

}  // namespace

ScaledPeak scaled_peak(const LayerSpectrum& spectrum, const LagResponse& lag) {
  const double W = std::sqrt(lag.width_squared.value);
  ScaledPeak peak{lag.z, scaled_places(), {}};
  for (const double x : peak.x) {
    const double angle = 2 * std::numbers::pi * (lag.peak_position.value + x * W) / spectrum.columns;
    const auto height = [&](ResponseModes modes) {
      double sum = 1;
      for (std::size_t m = 0; m < modes.cosines.size(); ++m) {
        const double turned = angle * static_cast<double>(m + 1);
        sum += 2 * (modes.cosines[m] * std::cos(turned) + modes.sines[m] * std::sin(turned));
      }
      return W * sum / spectrum.columns;
    };
    Replicated replicates{height(spectrum.modes()), {}};
    for (std::size_t b = 0; b < spectrum.without_block.size(); ++b)
      replicates.without_block.push_back(height(spectrum.modes_without(b)));
    peak.height.push_back(estimate(replicates));
  }
  return peak;
}

ScaledPeak scaled_peak(ReferredPeak coupled, double z) {
  const CoupledPeak& solution = coupled.solution;
  const DoubleGaussian shape = solution.shape_below(coupled.reference, z);
  const double from_c = shape.peak - solution.spec.c * z;
  ScaledPeak peak{z, scaled_places(), {}};
  for (const double x : peak.x) {
    const double density = solution.density_below(coupled.reference, z, from_c + x * shape.width);
    peak.height.push_back({shape.width * density, 0, {}});
  }
  return peak;
}

PeakShapeTest test_shape(const LayerSpectrum& spectrum, const LagResponse& lag, ReferredPeak coupled) {
  const double peak = lag.peak_position.value, width = std::sqrt(lag.width_squared.value);
  PeakShapeTest test;
  test.z = lag.z;
  test.degrees_of_freedom = static_cast<int>(spectrum.whole.size()) - 2;
  test.gaussian = chi2_of(spectrum, peak, width, [](double k) { return std::complex(std::exp(-k * k / 2)); });
  test.kpz = chi2_of(spectrum, peak, width, [](double k) { return std::complex(kpz_peak().mode(k)); });
  const CoupledPeak& solution = coupled.solution;
  const double W = solution.shape_below(coupled.reference, lag.z).width;
  test.coupled =
      chi2_of(spectrum, peak, width, [&](double k) { return solution.mode_below(coupled.reference, lag.z, k / W); });
  return test;
}

namespace {

using Complex = std::complex<double>;

/// Layers below the deepest one between which the decay of torque is followed, and waves long against beads that have
/// kept some of it; base layers of which the mean is taken.
constexpr int first_lag = 16, last_lag = 64, base_step = 8, bases = 24;
constexpr double least_k = 0.1, most_k = 0.35;
constexpr int shortest_row = 8;  ///< of beads whose thrust is looked at

enum ConservedField { weight, horizontal, torque, fields };

/// Of all modes m = 1, 2, ... of one block, summed over its piles.
struct BlockSpectra {
  std::vector<std::array<std::vector<double>, fields>> power;  ///< of each layer
  std::vector<double> decayed_first, decayed_last;             ///< of torque, over both lags
  std::vector<BlockRegression> thrust;                         ///< of each length of row
};

/// Fourier modes of rows.
class RowTransform {
 public:
  explicit RowTransform(std::size_t size) : row_(size), spectrum_(size) {}
  std::vector<double>& row() { return row_; }
  /// Modes 1 .. (size - 1)/2 of row(), which is used up.
  std::vector<Complex> modes() {
    spectrum_.transform(row_);
    std::vector<Complex> modes;
    for (std::size_t m = 1; m <= (row_.size() - 1) / 2; ++m) modes.emplace_back(row_[2 * m - 1], row_[2 * m]);
    return modes;
  }

 private:
  std::vector<double> row_;
  RealSpectrum spectrum_;
};

std::vector<Complex> modes_of(const Pile& pile, int layer, ConservedField field, RowTransform& transform) {
  const double sign = layer % 2 == 0 ? 1 : -1;
  for (int i = 0; i < pile.lattice.columns(); ++i) {
    const std::size_t at = pile.lattice.index(layer, i);
    const double H = pile.H_R[at] + pile.H_L[at];
    double& value = transform.row()[static_cast<std::size_t>(i)];
    if (field == weight) value = pile.V_R[at] + pile.V_L[at] - 1;
    if (field == horizontal) value = H;
    if (field == torque) value = sign * (sqrt3 * H - pile.V_R[at] + pile.V_L[at]) / 2;
  }
  return transform.modes();
}

void add_pile(const Pile& pile, const std::vector<int>& layers, RowTransform& transform, BlockSpectra& sums) {
  for (std::size_t l = 0; l < layers.size(); ++l) {
    for (const ConservedField field : {weight, horizontal, torque}) {
      const std::vector<Complex> modes = modes_of(pile, layers[l], field, transform);
      std::vector<double>& power = sums.power[l][field];
      for (std::size_t m = 0; m < modes.size(); ++m) power[m] += std::norm(modes[m]) / pile.lattice.columns();
    }
  }
  const int end = layers.back() + bases * base_step;
  for (int layer = layers.back() / 2; layer < end; layer += base_step) {
    for (BlockRegression& rows : sums.thrust) rows.add(pile, layer);
  }
  for (int base = layers.back(); base < end; base += base_step) {
    const std::vector<Complex> above = modes_of(pile, base, torque, transform);
    for (const auto& [lag, sum] :
         {std::pair(first_lag, &sums.decayed_first), std::pair(last_lag, &sums.decayed_last)}) {
      const std::vector<Complex> below = modes_of(pile, base + lag, torque, transform);
      for (std::size_t m = 0; m < above.size(); ++m) (*sum)[m] += (below[m] * std::conj(above[m])).real();
    }
  }
}

/// D for which the modes that are left after the first lag decay to what is left after the last one.
double decay(const std::vector<double>& k, const std::vector<double>& first, const std::vector<double>& last) {
  const double z = Lattice::depth(last_lag) - Lattice::depth(first_lag);
  double D = 0.3;
  for (int step = 0; step < 50; ++step) {
    double difference = 0, slope = 0;
    for (std::size_t m = 0; m < k.size(); ++m) {
      if (k[m] < least_k || k[m] > most_k) continue;
      const double rate = k[m] * k[m] * z / 2, left = first[m] * std::exp(-D * rate);
      difference += left - last[m];
      slope -= rate * left;
    }
    const double change = difference / slope;
    D -= change;
    if (std::abs(change) < 1e-10) break;
  }
  return D;
}

/// Mean over all blocks and without each.
std::vector<Replicated> means(const std::vector<BlockSpectra>& blocks, std::size_t layer, ConservedField field,
                              double samples_of_block) {
  const std::size_t modes = blocks.front().power[layer][field].size();
  const auto count = static_cast<double>(blocks.size());
  std::vector<Replicated> result(modes);
  for (std::size_t m = 0; m < modes; ++m) {
    double total = 0;
    for (const BlockSpectra& block : blocks) total += block.power[layer][field][m];
    result[m].value = total / (count * samples_of_block);
    for (const BlockSpectra& block : blocks)
      result[m].without_block.push_back((total - block.power[layer][field][m]) / ((count - 1) * samples_of_block));
  }
  return result;
}

}  // namespace

int layers_needed(const FluctuationPiles& piles) {
  return piles.layers.back() + bases * base_step + last_lag + bottom_margin + 1;
}

Fluctuations measure_fluctuations(const FluctuationPiles& piles, int threads) {
  const Lattice lattice({piles.columns, layers_needed(piles)});
  const auto modes = static_cast<std::size_t>((piles.columns - 1) / 2);
  const std::uint64_t of_block = piles.samples / static_cast<std::uint64_t>(piles.blocks);
  std::vector<BlockSpectra> blocks(static_cast<std::size_t>(piles.blocks));
  for_each_index(blocks.size(), threads, [&](std::size_t b) {
    BlockSpectra& sums = blocks[b];
    sums.power.resize(piles.layers.size());
    for (auto& layer : sums.power) layer.fill(std::vector<double>(modes));
    sums.decayed_first.resize(modes);
    sums.decayed_last.resize(modes);
    for (int beads = shortest_row; beads <= piles.columns / 2; beads *= 2) sums.thrust.emplace_back(beads);
    const auto sampler = make_sampler(piles.sampler, lattice);
    const std::vector<double> load(static_cast<std::size_t>(piles.columns), 1.0);
    RowTransform transform(load.size());
    Pile pile(lattice);
    for (std::uint64_t i = 0; i < of_block; ++i) {
      const std::uint64_t sample = b * of_block + i;
      if (sampler->draw(sample, load, pile)) {
        throw InputError(fmt::format(
            "sample {} of {} x {} beads at mu = {} could not be completed, so that its fluctuations are not known; "
            "raise sampling.effort",
            sample, piles.columns, lattice.layers(), piles.sampler.mu));
      }
      add_pile(pile, piles.layers, transform, sums);
    }
  });
  Fluctuations result;
  std::vector<double> k;
  for (std::size_t m = 1; m <= modes; ++m) k.push_back(2 * std::numbers::pi * static_cast<double>(m) / piles.columns);
  for (std::size_t l = 0; l < piles.layers.size(); ++l) {
    const auto mean_of_field = [&](ConservedField field) {
      return means(blocks, l, field, static_cast<double>(of_block));
    };
    result.layers.push_back(
        {piles.layers[l], k, mean_of_field(weight), mean_of_field(horizontal), mean_of_field(torque)});
  }
  for (std::size_t rows = 0; rows < blocks.front().thrust.size(); ++rows) {
    std::vector<BlockRegression> of_length;
    of_length.reserve(blocks.size());
    for (const BlockSpectra& block : blocks) of_length.push_back(block.thrust[rows]);
    result.thrust.push_back(thrust_in_blocks(of_length));
  }
  const auto D_without = [&](std::size_t left_out) {
    std::vector<double> first(modes), last(modes);
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      if (b == left_out) continue;
      for (std::size_t m = 0; m < modes; ++m) {
        first[m] += blocks[b].decayed_first[m];
        last[m] += blocks[b].decayed_last[m];
      }
    }
    return decay(k, first, last);
  };
  result.D_torque.value = D_without(blocks.size());
  for (std::size_t b = 0; b < blocks.size(); ++b) result.D_torque.without_block.push_back(D_without(b));
  return result;
}

}  // namespace granuscope
