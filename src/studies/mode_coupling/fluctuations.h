#pragma once
#include <cstdint>
#include <vector>

#include "analysis/jackknife.h"
#include "sampling/sampler_spec.h"
#include "thrust_in_blocks.h"

namespace granuscope {

/// The fluctuations of one layer of uniformly loaded piles, by wave number: <|x_k|^2> per bead, w = 1 on the mean.
/// The torque of a layer n is t = (-1)^n (T_R + T_L) of its beads, T the tangential forces of the contacts that leave
/// them: contacts turn beads like gears, so that torque balance makes it a conserved field, the third one beside w and
/// H.
struct LayerFluctuations {
  int layer = 0;
  std::vector<double> k;  ///< radians per bead diameter
  std::vector<Replicated> of_w, of_H, of_torque;
};

/// Those of several layers, and how torque spreads.
struct Fluctuations {
  std::vector<LayerFluctuations> layers;  ///< ascending
  Replicated D_torque;                    ///< a peak of torque has the variance D_torque z; bead diameters
  /// Of the lower half of the layers: rows of 8, 16, ... beads up to half of a layer, that of which is uniform.
  std::vector<ThrustInBlocks> thrust;
};

/// What is drawn for it.
struct FluctuationPiles {
  SamplerSpec sampler;
  int columns = 0;
  std::vector<int> layers;  ///< ascending
  std::uint64_t samples = 0;
  int blocks = 0;
};

/// Layers that a pile of them has.
int layers_needed(const FluctuationPiles& piles);

/// Draws the piles, each by itself; threads change no number. Throws InputError if one could not be completed.
Fluctuations measure_fluctuations(const FluctuationPiles& piles, int threads);

}  // namespace granuscope
