#include "analysis/dispersion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "ensemble/group_fourier.h"
#include "model/lattice.h"
#include "support/error.h"

namespace granuscope {
namespace {

constexpr int most_steps = 50;
constexpr double small_step = 1e-10;  ///< of c k z and of k^2 D z / 2: far below any standard error
constexpr double longest_step = 0.5;  ///< of the same
constexpr double most_decay = 0.5;    ///< -ln of the amplitude that is left

struct WaveOfBand {
  double k;
  ModePropagator G;
};

/// Gauss and Newton's steps; not finite where they do not end. Phase and decay decouple: the one turns the model, the
/// other shortens it.
RoughPropagation fit_band(const std::vector<WaveOfBand>& band, double z, RoughPropagation at) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  const double farthest = band.back().k * z, decay_of_D = band.back().k * farthest / 2;
  for (int step = 0; step < most_steps; ++step) {
    // The ratio of the fields' amplitudes, by which the corners tell one sine.
    double of_w = 0, of_H = 0;
    const auto length = [&](double k) { return std::exp(-k * k * at.D * z / 2); };
    for (const auto& [k, G] : band) {
      const double corner = -length(k) * std::sin(at.c * k * z);
      of_w += corner * G.wH;
      of_H += corner * G.Hw;
    }
    const double s = std::sqrt(of_H / of_w);
    if (!std::isfinite(s) || s == 0) break;
    double turn = 0, turn_power = 0, decay = 0, decay_power = 0;
    for (const auto& [k, G] : band) {
      const double phase = at.c * k * z, modulus = length(k), by_c = k * z, by_D = k * k * z / 2;
      // The part of e^(i c k z - k^2 D z / 2) that G has along the model and across it.
      const double real = (G.ww + G.HH) / 2, imaginary = -(s * G.wH + G.Hw / s) / 2;
      const double along = real * std::cos(phase) + imaginary * std::sin(phase) - modulus;
      const double across = imaginary * std::cos(phase) - real * std::sin(phase);
      turn += across * modulus * by_c;
      turn_power += modulus * modulus * by_c * by_c;
      decay -= along * modulus * by_D;
      decay_power += modulus * modulus * by_D * by_D;
    }
    const double of_c = turn / turn_power, of_D = decay / decay_power;
    const double part =
        std::min({1.0, longest_step / (std::abs(of_c) * farthest), longest_step / (std::abs(of_D) * decay_of_D)});
    at.c += part * of_c;
    at.D += part * of_D;
    if (!std::isfinite(at.c) || !std::isfinite(at.D)) break;
    if (std::abs(of_c) * farthest < small_step && std::abs(of_D) * decay_of_D < small_step) return at;
  }
  return {unknown, unknown};
}

}  // namespace

std::vector<double> half_octave_bands(int columns) {
  std::vector<double> edges;
  const double first = 2 * std::numbers::pi / columns;
  double edge = std::numbers::sqrt2;
  do {
    edge /= std::numbers::sqrt2;
    edges.push_back(edge);
  } while (edge > first);
  std::ranges::reverse(edges);
  return edges;
}

std::vector<BandOfModes> measure_dispersion(const BlockSums& sums, std::size_t above, std::size_t below,
                                            const std::vector<double>& edges, RoughPropagation rough) {
  const int columns = sums.quantities.at("propagation").width / 2;
  const double first = 2 * std::numbers::pi / columns;
  const LayerSums sums_above = propagation_at(sums, above), sums_below = propagation_at(sums, below);
  const std::size_t blocks = sums_above.blocks();
  // Without each of the blocks, and last without none.
  std::vector<std::vector<double>> of_above, of_below;
  for (std::size_t left_out = 0; left_out <= blocks; ++left_out) {
    of_above.push_back(propagation_without(sums_above, left_out));
    of_below.push_back(propagation_without(sums_below, left_out));
  }
  const std::size_t known = std::min(of_above.back().size(), of_below.back().size()) / correlation_parts;
  std::vector<BandOfModes> bands;
  for (std::size_t e = 0; e + 1 < edges.size(); ++e) {
    BandOfModes band;
    band.k_from = edges[e];
    band.k_to = edges[e + 1];
    band.z_from = sums.rows.spacing * sums.layers[above];
    band.z_to = sums.rows.spacing * sums.layers[below];
    std::vector<std::size_t> modes;
    double squares = 0;
    for (std::size_t m = 1; m <= known; ++m) {
      const double k = first * static_cast<double>(m);
      if (k < band.k_from || k >= band.k_to) continue;
      modes.push_back(m);
      squares += k * k;
    }
    if (modes.empty()) continue;
    band.modes = static_cast<int>(modes.size());
    band.k = std::sqrt(squares / static_cast<double>(modes.size()));
    const auto fit_without = [&](std::size_t left_out, RoughPropagation start) {
      std::vector<WaveOfBand> waves;
      for (const std::size_t m : modes) {
        const std::size_t at = (m - 1) * correlation_parts;
        waves.push_back(
            {first * static_cast<double>(m), mode_propagator(&of_below[left_out][at], &of_above[left_out][at])});
      }
      return fit_band(waves, band.z_to - band.z_from, start);
    };
    const RoughPropagation whole = fit_without(blocks, rough);
    Replicated c{whole.c, {}}, D{whole.D, {}};
    for (std::size_t b = 0; b < blocks; ++b) {
      const RoughPropagation without = fit_without(b, whole);
      c.without_block.push_back(without.c);
      D.without_block.push_back(without.D);
    }
    const std::string reason = "no two modes of sound describe the band";
    band.c = estimate(c, reason);
    band.D = estimate(D, reason);
    bands.push_back(band);
  }
  return bands;
}

std::vector<BandOfModes> dispersion_of_lags(const BlockSums& sums, double c, const std::vector<double>& D) {
  const std::vector<double> edges = half_octave_bands(sums.quantities.at("propagation").width / 2);
  std::map<double, BandOfModes> bands;  // by lower edge
  for (std::size_t i = 0; i < D.size(); ++i) {
    if (!std::isfinite(D[i])) continue;
    for (const BandOfModes& band : measure_dispersion(sums, i + 1, i + 2, edges, {c, D[i]})) {
      if (!band.c.known() || !band.D.known()) continue;
      if (band.k * band.k * D[i] * band.z_to / 2 < most_decay) {
        bands.insert_or_assign(band.k_from, band);
      } else {
        bands.try_emplace(band.k_from, band);
      }
    }
  }
  std::vector<BandOfModes> all;
  all.reserve(bands.size());
  for (const auto& [edge, band] : bands) all.push_back(band);
  return all;
}

namespace {

constexpr const char* quantity = "propagation";

struct Modes {
  std::vector<double> cosines, sines;
};

Modes modes_without(const LayerSums& lag, const LayerSums& reference, std::size_t left_out) {
  const std::vector<double> C = propagation_without(lag, left_out), C_r = propagation_without(reference, left_out);
  std::vector<ModePropagator> propagators;
  double of_w = 0, of_H = 0;
  for (std::size_t at = 0; at < C.size(); at += correlation_parts) {
    propagators.push_back(mode_propagator(&C[at], &C_r[at]));
    of_w += std::abs(propagators.back().wH);
    of_H += std::abs(propagators.back().Hw);
  }
  Modes modes;
  const bool scalar = of_w == 0 || of_H == 0;
  // The sines depend on it in second order only.
  const double s = std::sqrt(of_H / of_w);
  for (const ModePropagator& G : propagators) {
    modes.cosines.push_back(scalar ? G.ww : (G.ww + G.HH) / 2);
    if (!scalar) modes.sines.push_back(-(s * G.wH + G.Hw / s) / 2);
  }
  return modes;
}

}  // namespace

bool holds_propagation(const BlockSums& sums) { return sums.quantities.contains(quantity); }

LayerSums propagation_at(const BlockSums& sums, std::size_t row) { return sums.layer(quantity, row); }

std::vector<double> propagation_without(const LayerSums& propagation, std::size_t left_out) {
  const std::size_t width = propagation.width();
  std::vector<double> total(width);
  for (std::size_t b = 0; b < propagation.blocks(); ++b) {
    if (b == left_out) continue;
    const double* const of_block = propagation.block(b);
    for (std::size_t i = 0; i < width; ++i) total[i] += of_block[i];
  }
  // Beyond the last mode with weight all parts are 0.
  std::size_t end = 0;
  while (end + correlation_parts <= width && (total[end] != 0 || total[end + 1] != 0)) end += correlation_parts;
  total.resize(end);
  return total;
}

ModePropagator mode_propagator(const double* below, const double* above) {
  const double ww = above[0], HH = above[1], wH = above[2], Hw = above[3];
  if (HH == 0) return {below[0] / ww, 0, 0, 0};
  const double determinant = ww * HH + wH * Hw;
  return {(below[0] * HH + below[2] * Hw) / determinant, (below[1] * ww + below[3] * wH) / determinant,
          (below[2] * ww - below[0] * wH) / determinant, (below[3] * HH - below[1] * Hw) / determinant};
}

PropagatedModes propagated_modes(const BlockSums& sums, std::size_t row) {
  if (sums.layers.empty() || sums.layers.front() != 0) {
    throw InputError(
        "the ensemble does not hold the lag 0, and with it what its other lags are referred to, so that its response "
        "is not known; draw it again");
  }
  PropagatedModes modes;
  const LayerSums lag = propagation_at(sums, row), reference = propagation_at(sums, 0);
  Modes whole = modes_without(lag, reference, lag.blocks());
  modes.cosines.whole = std::move(whole.cosines);
  modes.sines.whole = std::move(whole.sines);
  for (std::size_t b = 0; b < lag.blocks(); ++b) {
    Modes without = modes_without(lag, reference, b);
    modes.cosines.without_block.push_back(std::move(without.cosines));
    modes.sines.without_block.push_back(std::move(without.sines));
  }
  return modes;
}

BlockMeans propagated_response(const BlockSums& sums, std::size_t row) {
  const int columns = sums.quantities.at(quantity).width / 2, layer = sums.layers[row];
  const Lattice lattice({columns, 2});
  const int kind_of_row = sums.rows.shifted(layer) ? 1 : 0;
  // Places are multiples of a half, so that all phases are multiples of half a turn over the columns.
  std::vector<double> cosine(static_cast<std::size_t>(2 * columns));
  for (std::size_t k = 0; k < cosine.size(); ++k)
    cosine[k] = std::cos(std::numbers::pi * static_cast<double>(k) / columns);
  const auto in_x = [&](const std::vector<double>& modes) {
    std::vector<double> response(static_cast<std::size_t>(columns));
    for (int i = 0; i < columns; ++i) {
      const auto step = static_cast<std::size_t>(std::abs(std::lround(2 * lattice.x(kind_of_row, i))));
      double sum = 1;
      std::size_t phase = step;
      for (const double mode : modes) {
        sum += 2 * mode * cosine[phase];
        phase += step;
        if (phase >= cosine.size()) phase -= cosine.size();
      }
      response[static_cast<std::size_t>(i)] = sum / columns;
    }
    return response;
  };
  const BlockMeans modes = propagated_modes(sums, row).cosines;
  BlockMeans response{in_x(modes.whole), {}};
  for (const auto& without : modes.without_block) response.without_block.push_back(in_x(without));
  return response;
}

}  // namespace granuscope
