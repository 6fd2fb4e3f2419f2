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

/// The mean response to a unit load at recorded layer number `row`, over the whole ensemble and without each block;
/// entry i belongs to bead i, the loaded bead being Lattice::middle().
BlockMeans mean_response(const BlockSums& sums, std::size_t row, double overload);

}  // namespace granuscope
