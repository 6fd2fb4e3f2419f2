#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "analysis/transport.h"

namespace granuscope {

/// A response known in advance: x_p = position_offset + c z, W^2 = width_offset + D z, exactly double Gaussian.
struct KnownTransport {
  double c = 0.55, D = 0.08, position_offset = -0.2, width_offset = 0.1;
  double alpha_thrust = 0.93;
  double position_power = 1, width_power = 1;  ///< of z in x_p and W^2, scaled to agree at z = 80
  double in_the_middle = 0;                    ///< share of the response that sits in one Gaussian at x = 0 instead
};

struct SyntheticNoise {
  double per_sample = 0.5;  ///< standard deviation of one bead's weight in one pile
  std::uint64_t seed = 1;
  double depth_correlation = 0;  ///< between a recorded layer and the next
};

/// An ensemble whose block sums follow the known response plus Gaussian noise that is correlated along the layer as in
/// real piles: neighbours exchange weight, so that every layer's sum stays exact.
MeasuredEnsemble synthetic_ensemble(const KnownTransport& known, const SyntheticNoise& noise, int columns,
                                    const std::vector<int>& layers, int blocks, std::uint64_t samples_per_block);

/// The same for any response: entry i of response_of(layer) belongs to bead i of the layer.
MeasuredEnsemble synthetic_ensemble(const std::function<std::vector<double>(int)>& response_of, double alpha_thrust,
                                    const SyntheticNoise& noise, int columns, const std::vector<int>& layers,
                                    int blocks, std::uint64_t samples_per_block);

}  // namespace granuscope
