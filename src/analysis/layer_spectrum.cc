#include "analysis/layer_spectrum.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/mean_response.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// cos(2 pi m x_j / columns), shape [columns, modes]. 2 x_j is an integer, so every angle comes from one exact table.
Matrix cosine_matrix(const Lattice& lattice, int layer, int modes) {
  const int period = 2 * lattice.columns();
  std::vector<double> cosine(static_cast<std::size_t>(period));
  for (int i = 0; i < period; ++i) cosine[static_cast<std::size_t>(i)] = std::cos(2 * std::numbers::pi * i / period);
  Matrix matrix(lattice.columns(), modes);
  for (int j = 0; j < lattice.columns(); ++j) {
    const long twice_x = std::lround(2 * lattice.x(layer, j)) + period;
    for (int m = 1; m <= modes; ++m) matrix(j, m - 1) = cosine[static_cast<std::size_t>(twice_x * m % period)];
  }
  return matrix;
}

/// Half width of the running mean over modes that smooths the noise estimate: the scatter of 32 block means gives each
/// mode's variance to 25 %, nine modes together to 8 %, which costs the fit less than 1 % of its precision.
constexpr int smoothing_half_width = 4;

}  // namespace

BlockMeans block_means(const BlockSums& sums, const std::string& quantity, std::size_t row) {
  const QuantitySums& q = sums.quantities.at(quantity);
  const auto width = static_cast<std::size_t>(q.width);
  const auto blocks = static_cast<std::size_t>(sums.blocks());
  std::vector<double> total(width);
  double samples = 0;
  const auto block_sum = [&](std::size_t b) { return &q.sum[(b * sums.layers.size() + row) * width]; };
  for (std::size_t b = 0; b < blocks; ++b) {
    samples += static_cast<double>(sums.count[b]);
    for (std::size_t i = 0; i < width; ++i) total[i] += block_sum(b)[i];
  }
  BlockMeans means;
  means.whole.resize(width);
  means.without_block.assign(blocks, std::vector<double>(width));
  for (std::size_t i = 0; i < width; ++i) {
    means.whole[i] = total[i] / samples;
    for (std::size_t b = 0; b < blocks; ++b) {
      means.without_block[b][i] = (total[i] - block_sum(b)[i]) / (samples - static_cast<double>(sums.count[b]));
    }
  }
  return means;
}

Replicated block_mean(const BlockSums& sums, const std::string& quantity, std::size_t row) {
  const BlockMeans means = block_means(sums, quantity, row);
  Replicated number;
  number.value = means.whole[0];
  for (const auto& without : means.without_block) number.without_block.push_back(without[0]);
  return number;
}

LayerSpectrum layer_spectrum(const BlockSums& sums, std::size_t row, double overload) {
  const ResponseQuantity response = response_quantity(sums, overload);
  const QuantitySums& q = sums.quantities.at(response.name);
  const int columns = q.width, modes = (columns - 1) / 2, blocks = sums.blocks();
  const int layer = sums.layers[row];
  const Lattice lattice({columns, layer + 1});

  // Rows: block sums. The uniform load only enters the mode m = 0.
  Matrix block_sums(blocks, columns);
  Eigen::VectorXd count(blocks);
  for (int b = 0; b < blocks; ++b) {
    count(b) = static_cast<double>(sums.count[static_cast<std::size_t>(b)]);
    const std::size_t offset =
        (static_cast<std::size_t>(b) * sums.layers.size() + row) * static_cast<std::size_t>(columns);
    for (int i = 0; i < columns; ++i) {
      block_sums(b, i) = q.sum[offset + static_cast<std::size_t>(i)] - count(b) * response.background;
    }
  }
  const Matrix block_modes = block_sums * cosine_matrix(lattice, layer, modes) / response.scale;

  LayerSpectrum spectrum;
  spectrum.columns = columns;
  spectrum.half_shifted = layer % 2 == 1;
  const Eigen::RowVectorXd total = block_modes.colwise().sum();
  const double samples = count.sum();
  const Eigen::RowVectorXd mean = total / samples;
  const auto to_vector = [](const Eigen::RowVectorXd& v) { return std::vector<double>(v.data(), v.data() + v.size()); };
  spectrum.whole = to_vector(mean);
  Eigen::RowVectorXd variance = Eigen::RowVectorXd::Zero(modes);
  for (int b = 0; b < blocks; ++b) {
    spectrum.without_block.push_back(to_vector((total - block_modes.row(b)) / (samples - count(b))));
    variance += count(b) * (block_modes.row(b) / count(b) - mean).array().square().matrix();
  }
  variance /= (blocks - 1) * samples;

  // A scatter at the level of rounding is no scatter.
  const double rounding = 1e-26;
  spectrum.exact = variance.maxCoeff() <= rounding * mean.array().square().maxCoeff();
  spectrum.noise.assign(static_cast<std::size_t>(modes), 0.0);
  if (spectrum.exact) return spectrum;
  for (int m = 0; m < modes; ++m) {
    // The window shrinks towards both ends, so that it stays centred where the spectrum is steep (small m).
    const int half = std::min({smoothing_half_width, m, modes - 1 - m});
    spectrum.noise[static_cast<std::size_t>(m)] = std::sqrt(variance.segment(m - half, 2 * half + 1).mean());
  }
  return spectrum;
}

}  // namespace granuscope
