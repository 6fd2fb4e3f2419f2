#pragma once
#include "analysis/estimate.h"
#include "storage/block_sums.h"

namespace granuscope {

/// How many independent piles would have given the ensemble's standard errors: variance of one pile over the variance
/// of the mean (jackknife over blocks), each summed over the layers in which the quantity scatters; the smaller number
/// of "thrust" and "weight_variance". The number of samples for independent ones, less for a chain. Its relative
/// standard error is sqrt(2/(blocks - 1)) or less, depending on how many layers are independent; that of one layer is
/// stated. Unknown, with the reason, without blocks enough or without scatter.
Estimate effective_samples(const BlockSums& sums);

}  // namespace granuscope
