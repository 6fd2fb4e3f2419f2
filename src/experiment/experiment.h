#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "analysis/fit_spec.h"
#include "ensemble/response_spec.h"
#include "model/lattice.h"
#include "render/scene.h"
#include "sampling/sampler_spec.h"

namespace granuscope {

/// Which plots are drawn, and of what.
struct FigureSpec {
  bool response_profiles = true;              ///< the paper's Fig. 2
  double profile_mu = 0.3;                    ///< must be one of the experiment's friction coefficients
  std::vector<int> profile_layers{110, 170};  ///< usable layers, ascending
  bool transport_with_depth = true;           ///< Fig. 3: c and D against z, insets against mu
  bool propagation_against_diffusion = true;  ///< Fig. 4: c against D
};

/// The rendered force network of one named pile (the paper's Fig. 1, right): never a chosen sample.
struct ForceChainSpec {
  bool draw = true;
  int columns = 70;  ///< of the pile, periodic; all are shown
  int layers = 60;   ///< shown; bottom_margin more are computed, so that the shown ones follow the bulk law
  double mu = 0.1;
  std::uint64_t sample = 0;  ///< of the experiment's seed
  SceneSpec scene;           ///< its window is ignored: columns and layers above say what is shown

  int computed_layers() const { return layers + bottom_margin; }
};

struct ReportSpec {
  bool pdf = true;  ///< also write report.pdf where WeasyPrint is installed
};

/// One experiment, resolved and validated: what `granuscope run` computes, draws and says. Composed of each room's own
/// parameter struct; the defaults are the paper's numbers.
struct Experiment {
  std::string name = "experiment";  ///< untrusted text, one line
  std::string description;          ///< untrusted text, may be empty
  LatticeSpec lattice;
  std::vector<double> mu{0.0, 0.1, 0.2, 0.3};  ///< friction coefficients, ascending, no duplicates
  SamplerSpec sampling;                        ///< its mu is ignored: see sampler_for
  ResponseSpec response;
  FitSpec fit;
  FigureSpec figures;
  ForceChainSpec force_chains;
  ReportSpec report;
  std::map<std::string, std::string> expected_verdicts;  ///< claim id -> verdict, the table [gate.expect]

  /// The sampler's parameters at one friction coefficient.
  SamplerSpec sampler_for(double friction) const {
    SamplerSpec spec = sampling;
    spec.mu = friction;
    return spec;
  }
};

}  // namespace granuscope
