#pragma once
#include <vector>

#include "ensemble/ensemble_spec.h"

namespace granuscope {

/// Which layers of a pile the estimator fluctuation compares, over how many layers, and how many Fourier modes of them.
/// The layer m + reference of a base m is compared with m (the lag 0 of what is recorded), and with it those that lie l
/// layers deeper, for each recorded lag l.
struct FluctuationPlan {
  int reference = 0;        ///< at least the reference lag asked for
  std::vector<int> bases;   ///< ascending, evenly spaced
  std::vector<int> lags;    ///< recorded, ascending, the first is 0
  std::vector<int> modes;   ///< of each lag: modes 1 .. modes[i] are compared
  std::vector<int> layers;  ///< all that are needed, ascending
  int layers_needed = 0;    ///< of a lattice on which one base fits
};

FluctuationPlan fluctuation_plan(const EnsembleSpec& spec);

/// The highest mode on a ring of `columns` that tells something of a lag: where k W = 4.5 for a rough W(lag), so that
/// the response has fallen to 4e-5 and the mode counts less than 1 % in the fit that x_p and W come from
/// (weighted_shape.h); or where k W(reference) = 3, if that is less: the noise is divided by exp(-k^2
/// W(reference)^2/2).
int weighty_modes(double mu, int columns, int lag, int reference);

/// Layers below which uniformly loaded piles fluctuate as deep ones do: 0.6/mu^2, at least 60 and at most 2000.
int saturated_layer(double mu);

}  // namespace granuscope
