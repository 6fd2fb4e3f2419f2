#include "analysis/mean_response.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "analysis/dispersion.h"
#include "analysis/double_gaussian.h"
#include "analysis/results.h"
#include "ensemble/estimator.h"
#include "model/lattice.h"
#include "support/error.h"

namespace granuscope {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// cos(2 pi m x_j / columns), shape [columns, modes]. 2 x_j is an integer, so every angle comes from one exact table.
Matrix cosine_matrix(const Lattice& lattice, bool half_shifted, int modes) {
  const int period = 2 * lattice.columns();
  std::vector<double> cosine(static_cast<std::size_t>(period));
  for (int i = 0; i < period; ++i) cosine[static_cast<std::size_t>(i)] = std::cos(2 * std::numbers::pi * i / period);
  Matrix matrix(lattice.columns(), modes);
  for (int j = 0; j < lattice.columns(); ++j) {
    const long twice_x = std::lround(2 * lattice.x(half_shifted ? 1 : 0, j)) + period;
    for (int m = 1; m <= modes; ++m) matrix(j, m - 1) = cosine[static_cast<std::size_t>(twice_x * m % period)];
  }
  return matrix;
}

/// Half width of the running mean over modes that smooths the noise estimate: the scatter of 32 block means gives each
/// mode's variance to 25 %, nine modes together to 8 %, which costs the fit less than 1 % of its precision.
constexpr int smoothing_half_width = 4;

/// Below this share of all blocks' power of a mode a block's part of it is rounding.
constexpr double no_power = 1e-12;

constexpr const char* moved_weight = "moved_weight";

/// For each block and mode a sum and what it is to be divided by, so that the response is the ratio of their totals.
/// Shape [blocks, modes].
struct BlockModes {
  Matrix numerator, denominator;
};

/// Means over samples: the denominator is their number. Of moved loads it is what layer 0 has of each mode, which is
/// the loads.
BlockModes modes_of_profiles(const BlockSums& sums, std::size_t row, double overload, int modes) {
  const ResponseQuantity response = response_quantity(sums, overload);
  const LayerSums layer = sums.layer(response.name, row);
  const int columns = static_cast<int>(layer.width()), blocks = sums.blocks();
  if (holds_moved_weights(sums)) {
    const LayerSums loads = load_spectrum_sums(sums);
    const auto modes_in = [&](const LayerSums& of, bool half_shifted) -> Matrix {
      Matrix rows(blocks, columns);
      for (int b = 0; b < blocks; ++b)
        rows.row(b) = Eigen::Map<const Eigen::RowVectorXd>(of.block(static_cast<std::size_t>(b)), columns);
      return rows * cosine_matrix(Lattice({columns, 2}), half_shifted, modes);
    };
    return {modes_in(layer, sums.rows.shifted(sums.layers[row])), modes_in(loads, false)};
  }
  // Rows: block sums. The uniform load only enters the mode m = 0.
  Matrix block_sums(blocks, columns), count(blocks, modes);
  for (int b = 0; b < blocks; ++b) {
    const auto samples = static_cast<double>(sums.count[static_cast<std::size_t>(b)]);
    count.row(b).setConstant(samples);
    const double* const of_block = layer.block(static_cast<std::size_t>(b));
    for (int i = 0; i < columns; ++i) block_sums(b, i) = of_block[i] - samples * response.background;
  }
  return {
      block_sums * cosine_matrix(Lattice({columns, 2}), sums.rows.shifted(sums.layers[row]), modes) / response.scale,
      count};
}

enum class Part { cosines, sines };

/// Cross-correlations, divided by the realised spectrum of the loads: cosines of what is even in x, minus the sines of
/// what is odd.
BlockModes modes_of_correlations(const BlockSums& sums, const char* quantity, Part part, std::size_t row, int modes) {
  const int blocks = sums.blocks(), columns = sums.quantities.at("correlation").width;
  const bool half_shifted = sums.rows.shifted(sums.layers[row]);
  BlockModes result{Matrix(blocks, modes), Matrix(blocks, modes)};
  const LayerSums correlations = sums.layer(quantity, row), load_spectra = load_spectrum_sums(sums);
  for (int b = 0; b < blocks; ++b) {
    const double* const correlation = correlations.block(static_cast<std::size_t>(b));
    const double* const loads = load_spectra.block(static_cast<std::size_t>(b));
    for (int m = 1; m <= modes; ++m) {
      // The spectrum counts whole beads; x does half a bead more on every other layer: C_m exp(-i k/2).
      const double half_k = half_shifted ? std::numbers::pi * m / columns : 0.0;
      const double* const C = correlation + 2 * m - 1;
      result.numerator(b, m - 1) = part == Part::cosines ? C[0] * std::cos(half_k) + C[1] * std::sin(half_k)
                                                         : C[0] * std::sin(half_k) - C[1] * std::cos(half_k);
      result.denominator(b, m - 1) = loads[2 * m - 1];
    }
  }
  return result;
}

int columns_of_response(const BlockSums& sums, double overload) {
  return holds_correlations(sums) ? sums.quantities.at("correlation").width
                                  : sums.quantities.at(response_quantity(sums, overload).name).width;
}

BlockModes block_modes(const BlockSums& sums, std::size_t row, double overload) {
  const int modes = (columns_of_response(sums, overload) - 1) / 2;
  return holds_correlations(sums) ? modes_of_correlations(sums, "correlation", Part::cosines, row, modes)
                                  : modes_of_profiles(sums, row, overload, modes);
}

using Row = Eigen::Array<double, 1, Eigen::Dynamic>;

std::vector<double> to_vector(const Row& v) { return {v.data(), v.data() + v.size()}; }

/// Of all blocks, and of all but one.
BlockMeans ratios(const BlockModes& block) {
  const Row numerator = block.numerator.colwise().sum(), denominator = block.denominator.colwise().sum();
  BlockMeans means{to_vector(numerator / denominator), {}};
  for (Eigen::Index b = 0; b < block.numerator.rows(); ++b) {
    means.without_block.push_back(
        to_vector((numerator - Row(block.numerator.row(b))) / (denominator - Row(block.denominator.row(b)))));
  }
  return means;
}

/// The same times a number, so that its squares have the same sum as those of `cosines`, in which signal and noise are
/// alike.
BlockMeans to_size_of(const std::vector<double>& cosines, BlockMeans sines) {
  const auto squares = [](const std::vector<double>& modes) {
    return std::inner_product(modes.begin(), modes.end(), modes.begin(), 0.0);
  };
  const double size = squares(sines.whole);
  const double scale = size > 0 ? std::sqrt(squares(cosines) / size) : 1;
  for (double& mode : sines.whole) mode *= scale;
  for (auto& without : sines.without_block) {
    for (double& mode : without) mode *= scale;
  }
  return sines;
}

/// With each block's residual r_b about the mean, sum_b r_b^2/d_b / ((blocks - 1) sum_b d_b): the variance of a
/// weighted mean of numerator/denominator.
Row scatter_variance(const BlockModes& block, const Row& mean, const Row& denominator) {
  const auto blocks = static_cast<int>(block.numerator.rows());
  Row variance = Row::Zero(mean.size());
  for (int b = 0; b < blocks; ++b) {
    const Row n = block.numerator.row(b), d = block.denominator.row(b);
    // Loads that happen to lack a mode, as those of a single pile may, say nothing about it.
    variance += (d > no_power * denominator).select((n - mean * d).square() / d, Row::Zero(mean.size()));
  }
  return variance / ((blocks - 1) * denominator);
}

/// The root of the variance, smoothed over neighbouring modes.
std::vector<double> smoothed_root(const Row& variance) {
  const auto modes = static_cast<int>(variance.size());
  std::vector<double> root;
  for (int m = 0; m < modes; ++m) {
    // The window shrinks towards both ends, so that it stays centred where the spectrum is steep (small m).
    const int half = std::min({smoothing_half_width, m, modes - 1 - m});
    root.push_back(std::sqrt(variance.segment(m - half, 2 * half + 1).mean()));
  }
  return root;
}

}  // namespace

BlockMeans block_means(const BlockSums& sums, const std::string& quantity, std::size_t row) {
  const LayerSums layer = sums.layer(quantity, row);
  const std::size_t width = layer.width(), blocks = layer.blocks();
  std::vector<double> total(width);
  double samples = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    samples += static_cast<double>(sums.count[b]);
    for (std::size_t i = 0; i < width; ++i) total[i] += layer.block(b)[i];
  }
  BlockMeans means;
  means.whole.resize(width);
  means.without_block.assign(blocks, std::vector<double>(width));
  for (std::size_t i = 0; i < width; ++i) {
    means.whole[i] = total[i] / samples;
    for (std::size_t b = 0; b < blocks; ++b) {
      means.without_block[b][i] = (total[i] - layer.block(b)[i]) / (samples - static_cast<double>(sums.count[b]));
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

Replicated thrust_speed(const BlockSums& sums, int first_layer) {
  std::vector<Replicated> ratios;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    if (sums.layers[row] >= first_layer) ratios.push_back(block_mean(sums, "thrust", row));
  }
  return transform([&](double kappa) { return speed_from_thrust(kappa, sums.rows.ray()); }, mean_of(ratios));
}

namespace {

/// Each mode is a ratio of sums that the scatter of the blocks enters twice: its variance is the jackknife's.
LayerSpectrum spectrum_of_propagation(const BlockSums& sums, std::size_t row) {
  PropagatedModes propagated = propagated_modes(sums, row);
  BlockMeans& modes = propagated.cosines;
  LayerSpectrum spectrum;
  spectrum.columns = sums.quantities.at("propagation").width / 2;
  spectrum.half_shifted = sums.rows.shifted(sums.layers[row]);
  spectrum.pitch = sums.rows.pitch;
  spectrum.ray = sums.rows.ray();
  Row variance(static_cast<Eigen::Index>(modes.whole.size()));
  for (std::size_t m = 0; m < modes.whole.size(); ++m) {
    Replicated mode{modes.whole[m], {}};
    for (const auto& without : modes.without_block) mode.without_block.push_back(without[m]);
    variance(static_cast<Eigen::Index>(m)) = std::pow(estimate(mode).standard_error, 2);
  }
  spectrum.noise = smoothed_root(variance);
  spectrum.whole = std::move(modes.whole);
  spectrum.without_block = std::move(modes.without_block);
  spectrum.sines = std::move(propagated.sines);
  return spectrum;
}

}  // namespace

LayerSpectrum layer_spectrum(const BlockSums& sums, std::size_t row, double overload) {
  if (holds_propagation(sums)) return spectrum_of_propagation(sums, row);
  const BlockModes block = block_modes(sums, row, overload);
  LayerSpectrum spectrum;
  spectrum.columns = columns_of_response(sums, overload);
  spectrum.half_shifted = sums.rows.shifted(sums.layers[row]);
  spectrum.pitch = sums.rows.pitch;
  spectrum.ray = sums.rows.ray();
  BlockMeans cosines = ratios(block);
  spectrum.whole = std::move(cosines.whole);
  spectrum.without_block = std::move(cosines.without_block);
  const Row denominator = block.denominator.colwise().sum();
  const Row mean = Row(block.numerator.colwise().sum()) / denominator;
  const Row variance = scatter_variance(block, mean, denominator);
  // A scatter at the level of rounding is no scatter.
  const double rounding = 1e-26;
  spectrum.exact = variance.maxCoeff() <= rounding * mean.square().maxCoeff();
  spectrum.noise = smoothed_root(variance);
  if (spectrum.exact) spectrum.noise.assign(spectrum.noise.size(), 0.0);
  if (sums.quantities.contains("correlation_H")) {
    const int modes = static_cast<int>(spectrum.whole.size());
    spectrum.sines =
        to_size_of(spectrum.whole, ratios(modes_of_correlations(sums, "correlation_H", Part::sines, row, modes)));
    spectrum.sines_to_scale = false;
  }
  return spectrum;
}

namespace {

/// The response of each distance d from the loaded bead, shifted so that the loaded bead is the middle one.
std::vector<double> response_of(const std::vector<double>& correlation, const std::vector<double>& loads,
                                const RealSpectrum& fourier) {
  const std::size_t columns = correlation.size();
  std::vector<double> by_distance(columns), response(columns);
  for (std::size_t at = 0; at < columns; ++at) {
    // Entries 2m - 1 and 2m are the real and imaginary parts of the mode m, whose load spectrum is real.
    by_distance[at] = correlation[at] / loads[at == 0 ? 0 : (at - 1) / 2 * 2 + 1];
  }
  // What the piles of a group share has been taken off, and with it the load; the response has the sum 1.
  if (loads[0] <= no_power * loads[1]) by_distance[0] = 1;
  fourier.inverse(by_distance);
  for (std::size_t d = 0; d < columns; ++d) response[(d + columns / 2) % columns] = by_distance[d];
  return response;
}

BlockMeans mean_correlation(const BlockSums& sums, std::size_t row) {
  const bool moved = holds_moved_weights(sums);
  const LayerSums correlations = sums.layer(moved ? moved_weight : "correlation", row),
                  load_spectra = load_spectrum_sums(sums);
  const std::size_t columns = correlations.width(), blocks = correlations.blocks();
  const RealSpectrum fourier(columns);
  const auto total = [&](std::size_t left_out) {
    std::vector<double> correlation(columns), loads(columns);
    for (std::size_t b = 0; b < blocks; ++b) {
      if (b == left_out) continue;
      const double* const c = correlations.block(b);
      const double* const l = load_spectra.block(b);
      for (std::size_t i = 0; i < columns; ++i) correlation[i] += c[i], loads[i] += l[i];
    }
    if (moved) {  // by place, not by mode
      for (std::vector<double>* sum : {&correlation, &loads}) {
        std::rotate(sum->begin(), sum->begin() + static_cast<std::ptrdiff_t>(columns / 2), sum->end());
        fourier.transform(*sum);
      }
    }
    return response_of(correlation, loads, fourier);
  };
  BlockMeans means;
  means.whole = total(blocks);
  for (std::size_t b = 0; b < blocks; ++b) means.without_block.push_back(total(b));
  return means;
}

}  // namespace

ResponseQuantity response_quantity(const BlockSums& sums, double overload) {
  if (sums.quantities.contains("response")) return {"response", 0, 1};
  if (sums.quantities.contains("weight")) return {"weight", 1, overload};
  if (holds_moved_weights(sums)) return {moved_weight, 0, overload};
  throw InputError(
      "the ensemble holds numbers per layer only, so that there is no response to fit; draw it with its profiles "
      "recorded");
}

bool holds_moved_weights(const BlockSums& sums) { return sums.quantities.contains(moved_weight); }

bool holds_correlations(const BlockSums& sums) { return sums.quantities.contains("correlation"); }

std::size_t first_response(const BlockSums& sums) {
  return holds_correlations(sums) || holds_propagation(sums) || holds_moved_weights(sums) ? 1 : 0;
}

LayerSums load_spectrum_sums(const BlockSums& sums) {
  if (sums.layers.empty() || sums.layers.front() != 0) {
    throw InputError(
        "the ensemble does not hold layer 0, and with it the spectrum of its loads, so that its response is not known; "
        "draw it again");
  }
  return sums.layer(holds_correlations(sums) ? "correlation" : moved_weight, 0);
}

BlockMeans mean_response(const BlockSums& sums, std::size_t row, double overload) {
  if (holds_propagation(sums)) return propagated_response(sums, row);
  if (holds_correlations(sums) || holds_moved_weights(sums)) return mean_correlation(sums, row);
  const ResponseQuantity response = response_quantity(sums, overload);
  BlockMeans means = block_means(sums, response.name, row);
  const auto take_response = [&](std::vector<double>& profile) {
    for (double& value : profile) value = (value - response.background) / response.scale;
  };
  take_response(means.whole);
  for (auto& without : means.without_block) take_response(without);
  return means;
}

namespace {

double squared_distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

/// `sizes` of sub-ensembles: as many for the whole as without a block, or the slope would depend on the residual in
/// another way.
double exponent_of(double residual, double scatter, double blocks, int sizes) {
  std::vector<double> log_piles, log_rms;
  double k = blocks;
  for (int i = 0; i < sizes; ++i) {
    log_piles.push_back(std::log(k));
    log_rms.push_back(std::log(residual + (blocks - k) / (k * (blocks - 1)) * scatter) / 2);
    k /= 2;
  }
  return fit_line(log_piles, log_rms, std::vector<double>(log_piles.size(), 1.0)).slope;
}

}  // namespace

ResidualNoise residual_noise(const LayerSpectrum& spectrum, const Replicated& peak, const Replicated& width) {
  const std::size_t blocks = spectrum.without_block.size(), size = spectrum.whole.size();
  const auto count = static_cast<double>(blocks);
  std::vector<ModeValue> model(size);
  const auto squared_residual = [&](const std::vector<double>& modes, double x_p, double W) {
    fourier_modes({x_p, W}, spectrum.columns, spectrum.half_shifted, model);
    double sum = 0;
    for (std::size_t i = 0; i < size; ++i) sum += std::pow(modes[i] - model[i].value, 2);
    return sum;
  };
  // With blocks of equal size a block's mean lies (B - 1) times as far from the whole, on the other side, as the mean
  // of the others does. Blocks differ by at most one group of piles.
  std::vector<double> distances;
  double total = 0;
  for (const auto& others : spectrum.without_block) {
    distances.push_back(std::pow(count - 1, 2) * squared_distance(others, spectrum.whole));
    total += distances.back();
  }
  ResidualNoise noise;
  noise.residual.value = squared_residual(spectrum.whole, peak.value, width.value);
  noise.scatter.value = total / count;
  for (std::size_t b = 0; b < blocks; ++b) {
    noise.residual.without_block.push_back(
        squared_residual(spectrum.without_block[b], peak.without_block[b], width.without_block[b]));
    // About their own mean, which lies distance/(B - 1)^2 from that of all.
    noise.scatter.without_block.push_back((total - distances[b]) / (count - 1) - distances[b] / std::pow(count - 1, 2));
  }
  return noise;
}

void add(ResidualNoise& a, const ResidualNoise& b) {
  if (a.residual.without_block.empty()) {
    a = b;
    return;
  }
  const auto plus = [](double p, double q) { return p + q; };
  a.residual = transform(plus, a.residual, b.residual);
  a.scatter = transform(plus, a.scatter, b.scatter);
}

namespace {

/// The replicates of a squared mean say too much about its error: of |m + noise|^2, m the true mean, the jackknife
/// takes 4 |m + noise|^2 for what is 4 |m|^2 + 2 noise^2 (times the variance of a component), twice the variance where
/// m = 0. `noise`: the expected square of it.
Replicated without_excess(Replicated square, double noise) {
  const double left = std::sqrt(1 - 0.5 * noise / std::max(noise, square.value));
  double mean = 0;
  for (const double one : square.without_block) mean += one / static_cast<double>(square.without_block.size());
  for (double& one : square.without_block) one = mean + left * (one - mean);
  return square;
}

}  // namespace

Replicated noise_exponent(const ResidualNoise& noise) {
  const auto blocks = static_cast<double>(noise.residual.without_block.size());
  const Replicated residual = without_excess(noise.residual, noise.scatter.value / (blocks - 1));
  Replicated exponent;
  const int sizes = static_cast<int>(std::log2(blocks)) + 1;
  exponent.value = exponent_of(noise.residual.value, noise.scatter.value, blocks, sizes);
  for (std::size_t b = 0; b < residual.without_block.size(); ++b) {
    exponent.without_block.push_back(
        exponent_of(residual.without_block[b], noise.scatter.without_block[b], blocks - 1, sizes));
  }
  return exponent;
}

}  // namespace granuscope
