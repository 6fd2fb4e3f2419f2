#pragma once

#include "studies/study.h"

namespace granuscope {

/// The worst residual of balance or cone over a range of layers.
struct ResidualAtDepth {
  int first_layer = 0, last_layer = 0;
  double residual = 0;  ///< relative to the largest force of the same layer
};

/// One pile under conditions that strain the sampler.
struct StabilityTrial {
  double mu = 0;
  int columns = 0, layers = 0;
  std::string load;     ///< what rests on the top beads, in words
  std::string outcome;  ///< solved; or stuck or refused, by name
  std::string reason;   ///< if not solved
  bool deep = false;    ///< one of those whose residuals are followed with depth
  // What follows is known if it was solved.
  double residual = 0;                  ///< the worst of all layers
  double rounded_per_bead = 0;          ///< share of the beads put onto a band's end because only rounding missed it
  std::vector<ResidualAtDepth> depths;  ///< from the top down, ever longer ranges
};

/// The piles of a stability test, drawn by the law "granusolve".
struct StabilitySpec {
  int layers = 0;  ///< of the deep piles; 0: no stability test
  int columns = 64;
};

/// Layers of the piles under uneven loads, and of those on the narrowest ring.
inline constexpr int uneven_stability_layers = 60, narrow_stability_layers = 1000;

/// Friction from next to none to next to sqrt(3), with 1/sqrt(3), where a contact may stand upright, and the numbers
/// before and after it.
std::vector<double> stability_friction();

/// At each friction: deep piles with an overload, the narrowest ring, loads over ten orders of magnitude side by side,
/// and half of the top unloaded. Every pile is either solved, and audited, or its outcome says by name why not.
std::vector<StabilityTrial> run_stability_trials(const StabilitySpec& spec, std::uint64_t seed);

/// The figure: worst residual against depth in the deep piles. Throws InputError where none of them was solved.
Figure plot_stability(const std::vector<StabilityTrial>& trials, const std::filesystem::path& run_folder);

/// Piles that strain the sampler; `measured`: what they were found to do, if that is known already.
std::unique_ptr<Study> numerical_stability_study(std::vector<StabilityTrial> measured = {});

}  // namespace granuscope
