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

/// Put behind the text of an experiment whose PDF nobody looks at: typesetting takes longer than all else together.
inline const std::string no_pdf = "[report]\npdf = false\n";

/// An experiment without its PDF.
inline Experiment without_pdf(Experiment experiment) {
  experiment.report.pdf = false;
  return experiment;
}

/// An experiment without figures, pictures and PDF.
inline Experiment unplotted(Experiment experiment) {
  FigureSpec& figures = experiment.figures;
  for (bool* shown : {&figures.bead_forces, &figures.response_profiles, &figures.transport_with_depth,
                      &figures.propagation_against_diffusion, &figures.scaling_with_friction,
                      &figures.propagation_and_thrust, &experiment.force_chains.show, &experiment.report.pdf}) {
    *shown = false;
  }
  return experiment;
}

/// The smallest one with one plot, no pictures and no PDF.
inline const std::string one_plot_text = [] {
  std::string text = smallest_experiment_text + "show = false\n" + no_pdf;
  for (const char* figure : {"bead_forces", "transport_with_depth", "propagation_against_diffusion",
                             "scaling_with_friction", "propagation_and_thrust"}) {
    text += std::string("[figures.") + figure + "]\nshow = false\n";
  }
  return text;
}();

}  // namespace granuscope
