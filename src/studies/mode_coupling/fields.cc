#include "studies/mode_coupling/fields.h"

#include <array>
#include <complex>
#include <numbers>
#include <utility>

#include "ensemble/ensemble_runner.h"
#include "ensemble/estimator.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

/// Modes of the plateau: those that have decayed by exp(-saturated) since the top, and are long against beads.
constexpr double saturated = 4, largest_k = 0.5;
constexpr const char* unknown_lags = "the response is not known at every lag; give more piles";

}  // namespace

LoadedPiles measure_loaded(const MeasuredEnsemble& ensemble) {
  return {ensemble.spec, load_line(ensemble.spec.sampler), block_mean(ensemble.record.sums, "thrust", 0)};
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
  if (w.empty()) {
    for (Estimate* one : {&plateau.of_w, &plateau.of_H, &plateau.of_torque, &plateau.ratio}) {
      one->reason = "no mode of the layer is saturated; give a deeper fluctuation_layer";
    }
    return plateau;
  }
  means = {mean_of(w), mean_of(H), mean_of(torque)};
  plateau.of_w = estimate(means.of_w);
  plateau.of_H = estimate(means.of_H);
  plateau.of_torque = estimate(means.of_torque);
  plateau.ratio = estimate(transform([](double a, double b) { return b / a; }, means.of_w, means.of_H));
  return plateau;
}

bool all_known(const DeepResponse& response) {
  return std::all_of(response.octaves.begin(), response.octaves.end(),
                     [](const OctaveOfDepth& octave) { return octave.D.known(); });
}

}  // namespace

CoupledSpreading measure_coupling(const MeasuredEnsemble& deep, std::vector<LoadedPiles> leaning,
                                  std::vector<LoadedPiles> turned, const LayerFluctuations& layer, int threads) {
  CoupledSpreading result;
  result.mu = deep.spec.sampler.mu;
  result.response = measure_spreading(deep, DeepMeasurement::fluctuations, threads);
  result.leaning = std::move(leaning);
  result.turned = std::move(turned);
  result.D_torque = estimate(layer.D_torque);
  Replicated by_slope, by_torque;
  result.by_slope = fit_thrust(result.leaning, &LoadLine::slope, &by_slope);
  result.by_torque = fit_thrust(result.turned, &LoadLine::offset, &by_torque);
  const auto unknown = [&](const std::string& reason) {
    for (Estimate* one : {&result.to_itself, &result.to_torque, &result.B, &result.of_widths.D, &result.of_widths.B,
                          &result.of_waves.D, &result.of_waves.B, &result.strength, &result.speeds.ratio}) {
      one->reason = reason;
    }
    return result;
  };
  if (!all_known(result.response)) return unknown(unknown_lags);
  PlateauMeans plateau;
  result.plateau = plateau_of(layer, result.response.octaves.front().D.value, plateau);
  if (!result.plateau.of_H.known()) return unknown(result.plateau.of_H.reason);
  const double c = result.response.c_thrust.value;
  const Replicated to_torque =
      transform([](double A, double C_t, double C_H) { return A * A * C_t * C_t / (36 * C_H); }, by_torque,
                plateau.of_torque, plateau.of_H);
  result.to_itself =
      estimate(transform([](double A, double C_H) { return A * A * C_H / 144; }, by_slope, plateau.of_H));
  result.to_torque = estimate(to_torque);
  result.B =
      estimate(transform([&](double m, double D_torque) { return fed_by(m, D_torque, c); }, to_torque, layer.D_torque));
  result.predicted = test_coupling(result.B, result.response, result.form);
  result.of_widths = fit_widths(result.response, result.form.D, result.form.B);
  const Estimate &needed = result.of_widths.B, &said = result.B;
  result.strength = {needed.value / said.value,
                     std::hypot(needed.standard_error, needed.value / said.value * said.standard_error) / said.value,
                     {}};
  result.of_waves = fit_waves(result.response.bands);
  if (result.of_waves.B.known()) {
    result.from_waves = test_waves(result.of_waves, result.response);
    result.speeds = test_speeds(result.of_waves, result.response);
  } else {
    result.speeds.ratio.reason = result.of_waves.B.reason;
  }
  double sum = 0, weights = 0;
  for (const OctaveOfDepth& octave : result.response.octaves) {
    const double weight = std::pow(octave.D.standard_error, -2);
    sum += weight * octave.D.value;
    weights += weight;
  }
  for (const OctaveOfDepth& octave : result.response.octaves) {
    result.diffusion_chi2 += std::pow((octave.D.value - sum / weights) / octave.D.standard_error, 2);
  }
  result.peaks = scaled_peaks(deep, result.response);
  result.shapes = test_shapes(deep, result.response, result.form);
  return result;
}

namespace {

using Complex = std::complex<double>;

/// Base layers of which the mean is taken, layers below them between which the decay of torque is followed, and waves
/// long against beads that have kept some of it.
constexpr int first_lag = 16, last_lag = 64, base_step = 8, bases = 24;
constexpr double least_k = 0.1, most_k = 0.35;

enum ConservedField { weight, horizontal, torque, fields };

/// Of all modes m = 1, 2, ... of one block, summed over its piles.
struct BlockSpectra {
  std::array<std::vector<double>, fields> power;    ///< mean over the bases
  std::vector<double> decayed_first, decayed_last;  ///< of torque, over both lags
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

void add_pile(const Pile& pile, int first_base, RowTransform& transform, BlockSpectra& sums) {
  for (int base = first_base; base < first_base + bases * base_step; base += base_step) {
    std::vector<Complex> above;
    for (const ConservedField field : {weight, horizontal, torque}) {
      above = modes_of(pile, base, field, transform);
      for (std::size_t m = 0; m < above.size(); ++m) {
        sums.power[field][m] += std::norm(above[m]) / (pile.lattice.columns() * bases);
      }
    }
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
std::vector<Replicated> means(const std::vector<BlockSpectra>& blocks, ConservedField field, double samples_of_block) {
  const std::size_t modes = blocks.front().power[field].size();
  const auto count = static_cast<double>(blocks.size());
  std::vector<Replicated> result(modes);
  for (std::size_t m = 0; m < modes; ++m) {
    double total = 0;
    for (const BlockSpectra& block : blocks) total += block.power[field][m];
    result[m].value = total / (count * samples_of_block);
    for (const BlockSpectra& block : blocks)
      result[m].without_block.push_back((total - block.power[field][m]) / ((count - 1) * samples_of_block));
  }
  return result;
}

}  // namespace

int layers_needed(const FluctuationPiles& piles) {
  return piles.layer + bases * base_step + last_lag + bottom_margin + 1;
}

LayerFluctuations measure_fluctuations(const FluctuationPiles& piles, int threads) {
  const Lattice lattice({piles.columns, layers_needed(piles)});
  const auto modes = static_cast<std::size_t>((piles.columns - 1) / 2);
  const std::uint64_t of_block = piles.samples / static_cast<std::uint64_t>(piles.blocks);
  std::vector<BlockSpectra> blocks(static_cast<std::size_t>(piles.blocks));
  for_each_index(blocks.size(), threads, [&](std::size_t b) {
    BlockSpectra& sums = blocks[b];
    sums.power.fill(std::vector<double>(modes));
    sums.decayed_first.resize(modes);
    sums.decayed_last.resize(modes);
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
      add_pile(pile, piles.layer, transform, sums);
    }
  });
  LayerFluctuations result;
  result.layer = piles.layer;
  for (std::size_t m = 1; m <= modes; ++m) {
    result.k.push_back(2 * std::numbers::pi * static_cast<double>(m) / piles.columns);
  }
  const auto mean_of_field = [&](ConservedField field) { return means(blocks, field, static_cast<double>(of_block)); };
  result.of_w = mean_of_field(weight);
  result.of_H = mean_of_field(horizontal);
  result.of_torque = mean_of_field(torque);
  const auto D_without = [&](std::size_t left_out) {
    std::vector<double> first(modes), last(modes);
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      if (b == left_out) continue;
      for (std::size_t m = 0; m < modes; ++m) {
        first[m] += blocks[b].decayed_first[m];
        last[m] += blocks[b].decayed_last[m];
      }
    }
    return decay(result.k, first, last);
  };
  result.D_torque.value = D_without(blocks.size());
  for (std::size_t b = 0; b < blocks.size(); ++b) result.D_torque.without_block.push_back(D_without(b));
  return result;
}

}  // namespace granuscope
