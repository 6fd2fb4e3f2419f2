#pragma once
#include "experiment/experiment_file.h"

namespace granuscope {

/// Real piles, small enough for a second: shallow layers, few samples. Its numbers mean little; its machinery is whole.
inline Experiment small_experiment() {
  return parse_experiment(R"(
[experiment]
name = "small"
[lattice]
columns = 120
layers = 70
[friction]
mu = [0.0, 0.2, 0.3, 0.4]
[sampling]
seed = 11
[response]
samples = 256
[fit]
first_layer = 25
last_layer = 49
layer_step = 3
shallow_layer = 13
scaling_window = [0.2, 0.4]
[figures.response_profiles]
mu = 0.3
layers = [31, 49]
[scenes.force_chains]
columns = 40
layers = 20
)",
                          "small.toml");
}

}  // namespace granuscope
