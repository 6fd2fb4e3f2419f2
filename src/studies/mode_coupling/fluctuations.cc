#include "fluctuations.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "ensemble/parallel.h"
#include "ensemble/real_spectrum.h"
#include "model/lattice.h"
#include "sampling/sampler.h"
#include "support/error.h"

namespace granuscope {
namespace {

using Complex = std::complex<double>;

/// Layers below the deepest one between which the decay of torque is followed, and waves long against beads that have
/// kept some of it; base layers of which the mean is taken.
constexpr int first_lag = 16, last_lag = 64, base_step = 8, bases = 24;
constexpr double least_k = 0.1, most_k = 0.35;
constexpr int shortest_row = 8;  ///< of beads whose thrust is looked at

enum Field { weight, horizontal, torque, fields };

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

std::vector<Complex> modes_of(const Pile& pile, int layer, Field field, RowTransform& transform) {
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
    for (const Field field : {weight, horizontal, torque}) {
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
std::vector<Replicated> means(const std::vector<BlockSpectra>& blocks, std::size_t layer, Field field,
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
    const auto mean_of_field = [&](Field field) { return means(blocks, l, field, static_cast<double>(of_block)); };
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
