#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "analysis/jackknife.h"
#include "ensemble/ensemble_spec.h"
#include "storage/block_sums.h"
#include "storage/ensemble_file.h"

namespace granuscope {
/// Mean of a profile or number over the whole ensemble and without each block, shape [width] each.
struct BlockMeans {
  std::vector<double> whole;
  std::vector<std::vector<double>> without_block;
};

/// Modes 1, 2, ... of a response, from all or some of its blocks.
struct ResponseModes {
  std::span<const double> cosines;
  std::span<const double> sines = {};  ///< as LayerSpectrum::sines
  bool sines_to_scale = true;          ///< likewise
};

/// The mirror-symmetric Fourier modes of the mean response of one layer, by block:
///   y_m = sum_j P(x_j) cos(2 pi m x_j / columns),   m = 1 .. (columns-1)/2.
/// The estimator fluctuation gives the first of them only, those that carry weight, and none where nothing fluctuates.
/// The mode m = 0 is the area, known exactly; the mode m = columns/2 vanishes on every other layer and is left out.
/// Cosines alone are the mirror symmetrisation x -> -x.
struct LayerSpectrum {
  int columns = 0;
  bool half_shifted = false;      ///< beads at half-integer x
  double pitch = 1, ray = tan30;  ///< of its rows; all else is in columns
  std::vector<double> whole;      ///< from the whole ensemble, entry m-1 for mode m
  std::vector<std::vector<double>> without_block;
  /// Standard deviation of each entry of `whole`, from the scatter of the block means, smoothed over neighbouring
  /// modes. Noise is nearly invariant under translation, so its modes are nearly uncorrelated and this is its
  /// covariance (for a point load an approximation).
  std::vector<double> noise;
  bool exact = false;  ///< no scatter at all: noise is 0
  /// Where H tells what goes to which side, as under the estimator fluctuation and, if it is asked for, multiplexed:
  /// sum_j P_+(x_j) sin(2 pi m x_j / columns) of the peak P_+ that moves towards +x, P being half of it and half of its
  /// mirror image. Empty elsewhere.
  BlockMeans sines;
  /// False: they are those of the response of H, up to a factor near 1 that a fit has to find.
  bool sines_to_scale = true;

  ResponseModes modes() const { return {whole, sines.whole, sines_to_scale}; }
  ResponseModes modes_without(std::size_t block) const {
    return {without_block[block],
            sines.whole.empty() ? std::span<const double>() : std::span<const double>(sines.without_block[block]),
            sines_to_scale};
  }
};

/// Means of one quantity at recorded layer number `row` (an index into sums.layers).
BlockMeans block_means(const BlockSums& sums, const std::string& quantity, std::size_t row);

/// The same for a quantity that is one number per layer.
Replicated block_mean(const BlockSums& sums, const std::string& quantity, std::size_t row);

/// The propagation coefficient that follows from the thrust ratio (results.h), averaged over the recorded
/// layers from `first_layer` on.
Replicated thrust_speed(const BlockSums& sums, int first_layer);

/// Spectrum of the response (w - 1)/overload at recorded layer number `row`.
LayerSpectrum layer_spectrum(const BlockSums& sums, std::size_t row, double overload);

/// Which quantity of an ensemble's sums holds the response P(x), and how: P = (mean - background)/scale.
struct ResponseQuantity {
  const char* name;
  double background, scale;
};

/// "response" as it stands (estimator paired), "weight" minus the uniform load of 1, divided by the overload, or
/// "moved_weight".
/// Throws InputError where the ensemble holds neither.
ResponseQuantity response_quantity(const BlockSums& sums, double overload);

/// Whether the sums are those of the estimator multiplexed: spectra of cross-correlations instead of profiles.
bool holds_correlations(const BlockSums& sums);
/// Or those of the estimator point whose loads are moved, on the ring of response_columns: layer 0 is what they are
/// divided by, mode by mode.
bool holds_moved_weights(const BlockSums& sums);
/// The first recorded layer that holds a response: layer 0 of the estimators multiplexed and fluctuation, and of moved
/// loads, holds what the others are divided by.
std::size_t first_response(const BlockSums& sums);
/// The realised spectrum of the loads, which is the correlation of layer 0: laid out as in
/// ensemble/estimator.h; of moved loads their correlation by place. The response is the ratio of sums over
/// blocks of the correlation and this. Throws InputError where layer 0 is not recorded.
LayerSums load_spectrum_sums(const BlockSums& sums);

/// The mean response to a unit load at recorded layer number `row`, over the whole ensemble and without each block;
/// entry i belongs to bead i of the response's ring, the loaded bead being its Lattice::middle().
BlockMeans mean_response(const BlockSums& sums, std::size_t row, double overload);

/// One ensemble handed to the analysis: what was drawn, and what came of it.
struct MeasuredEnsemble {
  EnsembleSpec spec;
  EnsembleRecord record;
};

/// What is left of a response when its fit is taken away, and how much its blocks scatter: sums of squares over the
/// modes of a layer. Sums over layers add up.
struct ResidualNoise {
  Replicated residual;  ///< sum of (mean of all blocks - fit)^2
  Replicated scatter;   ///< mean over blocks of the sum of (mean of the block - mean of all blocks)^2
};

/// `peak` and `width` are the fit with its replicates.
ResidualNoise residual_noise(const LayerSpectrum& spectrum, const Replicated& peak, const Replicated& width);

/// a += b, component by component; an empty `a` becomes b.
void add(ResidualNoise& a, const ResidualNoise& b);

/// The power with which the rms residual about the fit falls with the number N of piles averaged, over sub-ensembles of
/// B, B/2, B/4, ... 1 of the B blocks: the slope of its logarithm on ln N, every size weighted alike. The mean square
/// over all choices of k of the B blocks is known without drawing any:
///   residual + (B - k)/(k (B - 1)) scatter.
/// -1/2 if the residual is nothing but noise of independent piles; nearer to 0 if the shape fitted is not the
/// response's.
Replicated noise_exponent(const ResidualNoise& noise);

}  // namespace granuscope
