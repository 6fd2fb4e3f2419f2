#include "analysis/propagator.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "ensemble/group_fourier.h"
#include "model/lattice.h"
#include "support/error.h"

namespace granuscope {
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
        "is "
        "not known; draw it again");
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
  const auto in_x = [&](const std::vector<double>& modes) {
    std::vector<double> response(static_cast<std::size_t>(columns));
    for (int i = 0; i < columns; ++i) {
      const double angle = 2 * std::numbers::pi * lattice.x(kind_of_row, i) / columns;
      double sum = 1;
      for (std::size_t m = 0; m < modes.size(); ++m) sum += 2 * modes[m] * std::cos(angle * static_cast<double>(m + 1));
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
