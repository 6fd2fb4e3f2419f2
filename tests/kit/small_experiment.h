#pragma once
#include <string>

#include "experiment/experiment_file.h"

namespace granuscope {

/// Real piles, small enough for a second: shallow layers, few samples. Its numbers mean little; its machinery is whole.
inline const std::string small_experiment_text = R"([experiment]
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
)";

inline Experiment small_experiment() { return parse_experiment(small_experiment_text, "small.toml"); }

/// Smaller still, for what is run many times: every stage in it, but too few friction coefficients for exponents.
inline const std::string smallest_experiment_text = R"([experiment]
name = "small"
[lattice]
columns = 60
layers = 50
[friction]
mu = [0.0, 0.3]
[response]
samples = 256
[fit]
first_layer = 8
last_layer = 26
layer_step = 2
shallow_layer = 4
scaling_window = [0.1, 0.3]
[figures.response_profiles]
mu = 0.3
layers = [10, 20]
[scenes.force_chains]
columns = 30
layers = 20
width_px = 500
dpi = 100
)";

}  // namespace granuscope
