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

}  // namespace granuscope
