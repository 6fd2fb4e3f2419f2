#pragma once
#include <cstddef>

#include "analysis/layer_spectrum.h"
#include "storage/block_sums.h"

namespace granuscope {

/// Which quantity of an ensemble's sums holds the response P(x), and how: P = (mean - background)/scale.
struct ResponseQuantity {
  const char* name;
  double background, scale;
};

/// "response" as it stands (estimator paired), or "weight" minus the uniform load of 1, divided by the overload.
/// Throws InputError where the ensemble holds neither.
ResponseQuantity response_quantity(const BlockSums& sums, double overload);

/// Whether the sums are those of the estimator multiplexed: spectra of cross-correlations instead of profiles.
bool holds_correlations(const BlockSums& sums);
/// The first recorded layer that holds a response: layer 0 of the estimators multiplexed and fluctuation holds what the
/// others are divided by.
std::size_t first_response(const BlockSums& sums);
/// The realised spectrum of the loads, which is the correlation of layer 0: laid out as in ensemble/real_spectrum.h.
/// The response is the ratio of sums over blocks of the correlation and this. Throws InputError where layer 0 is not
/// recorded.
LayerSums load_spectrum_sums(const BlockSums& sums);

/// The mean response to a unit load at recorded layer number `row`, over the whole ensemble and without each block;
/// entry i belongs to bead i, the loaded bead being Lattice::middle().
BlockMeans mean_response(const BlockSums& sums, std::size_t row, double overload);

}  // namespace granuscope
