#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "analysis/claim_spec.h"
#include "analysis/fit_spec.h"
#include "analysis/precision.h"
#include "ensemble/ensemble_spec.h"
#include "model/lattice.h"
#include "render/scene.h"
#include "sampling/sampler_spec.h"
#include "sampling/scan_parameter.h"

namespace granuscope {

/// The rendered force network of one named pile (the paper's Fig. 1, right): never a chosen sample.
struct ForceChainSpec {
  bool show = true;
  int columns = 70;  ///< of the pile, periodic; all are shown
  int layers = 60;   ///< shown; bottom_margin more are computed, so that the shown ones follow the bulk law
  double mu = 0.1;
  std::uint64_t sample = 0;  ///< of the experiment's seed
  /// 57 mm wide: two pictures share a row of the printed report, with text of 8 pt. Its window is ignored: columns and
  /// layers above say what is shown.
  SceneSpec scene{.width_px = 900, .dpi = 400, .window = {}, .range = {}};
  bool weight = true;     ///< also the weights of the same pile's beads
  bool friction = false;  ///< also how much of its friction each contact uses
  bool response = true;   ///< also how they change with the overload, every bead keeping its random number

  /// Saturates: what is absurd is refused, but only after it has been looked at.
  int computed_layers() const {
    return std::min(layers, std::numeric_limits<int>::max() - bottom_margin) + bottom_margin;
  }
};

/// What differs from main ensemble to main ensemble.
struct ScanSpec {
  std::string parameter;  ///< ScanParameter::name; empty: the usual one of the model
  std::vector<double>
      values;  ///< ascending, no duplicates; none: MainLine::mu of beads, else what the model itself says
};

/// What every experiment measures, and what a study may go by: the main ensembles, their fits and claims, and the pile
/// that is shown. The defaults are the paper's numbers.
struct MainLine {
  LatticeSpec lattice;
  std::vector<double> mu{0.0, 0.1, 0.2, 0.3};  ///< friction coefficients, ascending, no duplicates
  SamplerSpec sampling;                        ///< its mu is ignored: see sampler_at
  ScanSpec scan;                               ///< of friction it is empty: mu has its values
  ResponseSpec response;
  FitSpec fit;
  PrecisionSpec precision;
  ClaimSpec claims;
  ForceChainSpec force_chains;

  /// Throws InputError if the scan names a parameter on which the piles do not depend.
  const ScanParameter& scanned() const;
  /// Of each main ensemble, ascending.
  std::vector<double> scan_values() const;
  /// The value that figures of a single one show: the nearest to `wanted`, but the last of another parameter than
  /// friction that does not have it.
  double shown_value(double wanted) const;
  /// The sampler's parameters at one value of what is scanned.
  SamplerSpec sampler_at(double value) const;

  /// Those of beads at one friction coefficient, whatever the model is.
  SamplerSpec sampler_for(double friction) const {
    SamplerSpec spec = sampling;
    spec.model = {};
    spec.mu = friction;
    return spec;
  }

  /// An ensemble of the main line's sampler, overload and blocks.
  EnsembleSpec ensemble_at(double friction, LatticeSpec size, std::uint64_t samples) const;

  /// Uniformly loaded piles of a law as it is by default, whatever the main ensembles are drawn by; every layer
  /// recorded.
  EnsembleSpec uniform_piles(Law law, double friction, LatticeSpec size, std::uint64_t samples) const;
};

}  // namespace granuscope
