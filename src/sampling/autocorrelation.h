#pragma once
#include <vector>

namespace granuscope {

/// 1 + 2 (sum of the autocorrelations of a stationary series): how many of its entries weigh as much as one independent
/// one. The sum ends at the first lag beyond six times half the result (Madras and Sokal, J. Stat. Phys. 50, 109,
/// 1988). Never below 1; 1 for a series that scatters less than rounding does in numbers of size `scale`.
double autocorrelation_time(const std::vector<double>& series, double scale);

}  // namespace granuscope
