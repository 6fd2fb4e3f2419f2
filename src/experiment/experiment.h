#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "analysis/claim_spec.h"
#include "analysis/fit_spec.h"
#include "analysis/precision.h"
#include "analysis/stress.h"
#include "ensemble/response_spec.h"
#include "model/lattice.h"
#include "render/scene.h"
#include "sampling/sampler_spec.h"

namespace granuscope {

/// Which plots are drawn, and of what.
struct FigureSpec {
  bool bead_forces = true;                    ///< the paper's Fig. 1, left: one bead's forces, at profile_mu
  bool response_profiles = true;              ///< the paper's Fig. 2
  double profile_mu = 0.3;                    ///< must be one of the experiment's friction coefficients
  std::vector<int> profile_layers{110, 170};  ///< usable layers, ascending
  bool transport_with_depth = true;           ///< Fig. 3: c and D against z, insets against mu
  bool propagation_against_diffusion = true;  ///< Fig. 4: c against D
  bool scaling_with_friction = true;          ///< D and c0 - c against mu, from slopes and from ratios
  bool propagation_and_thrust = true;         ///< c beside the speed that follows from the thrust ratio
};

/// The standard procedure beside the paper's own (estimator "paired"): how many beads draw again. On the experiment's
/// lattice, with its overload.
struct RedrawnBeadsSpec {
  std::vector<double> mu;       ///< empty: not measured
  std::uint64_t samples = 512;  ///< pairs of piles per friction coefficient
};

/// Blocks of an ensemble that is only counted: few, so that the largest piles need not be many.
inline constexpr int counted_work_blocks = 8;

/// The work of drawing piles of several sizes, counted.
struct CountedWorkSpec {
  std::vector<double> mu;                       ///< empty: not measured
  std::vector<int> sizes{125, 250, 500, 1000};  ///< columns and layers of each square pile, ascending
  std::uint64_t samples = 64;                   ///< piles per size and friction coefficient
};

/// The thrust ratio at small friction, from uniformly loaded piles that are narrow and deep.
struct SmallFrictionSpec {
  std::vector<double> mu;  ///< each above 0; empty: not measured
  int columns = 64;
  double depth = 4;             ///< in units of the saturation depth of 0.6/mu^2 layers
  std::uint64_t samples = 512;  ///< piles per friction coefficient

  /// Layers computed at one friction coefficient.
  int layers(double friction) const;
};

/// The share of the response that lies along the rays, on piles of the size of the force-chain picture.
struct ChainShareSpec {
  std::uint64_t samples = 0;  ///< 0: not measured
};

/// The response to several kinds and sizes of load, beside the linear response.
struct NonlinearitySpec {
  std::vector<double> mu;                        ///< each above 0; empty: not measured
  std::vector<double> epsilons{0.1, 0.25, 0.5};  ///< multiplexed; that of ResponseSpec is taken for the linear response
  std::vector<double> overloads{0.25, 1, 4};     ///< point
  std::uint64_t multiplexed_samples = 1024;      ///< piles at the epsilon of ResponseSpec; others ~ 1/epsilon^2
  std::uint64_t point_samples = 8192;            ///< piles at the overload 1; others in inverse proportion
};

/// The laws side by side on uniformly loaded piles.
struct LawComparisonSpec {
  double mu = 0.3;
  int columns = 12, layers = 30;         ///< of the piles of granusolve and polytope
  std::uint64_t samples = 0;             ///< piles of each law; 0: not measured
  std::vector<double> cost_mu;           ///< where the work of eloy-clement is counted; empty: not at all
  std::vector<int> cost_sizes{4, 6, 8};  ///< columns and layers of the square piles for it, ascending
  std::uint64_t response_samples = 0;    ///< piles of each law for c and D; 0: not measured
  int response_columns = 24, response_layers = 27;
  std::uint64_t response_burn_in = 20'000, response_thinning = 2000;  ///< polytope, sweeps; 0: measured
  std::vector<double> exact_mu;        ///< where the thrust of the law rejection is followed; empty: not at all
  std::uint64_t exact_samples = 2048;  ///< piles at each friction and size
  static constexpr double response_epsilon = 0.5;
  static constexpr int tiny = 6;               ///< columns and layers of the piles that every law can draw
  static constexpr LatticeSpec narrow{4, 16};  ///< the deepest piles that rejection still draws in a second
  static constexpr double effort = 1e5;        ///< solutions per bead that eloy-clement is granted
};

/// The error of each estimator against its run time, on ensembles of their own.
struct ErrorAgainstTimeSpec {
  int repetitions = 0;  ///< independent ones of each estimator; 0: not measured
  double mu = 0.3;
  int columns = 500, layers = 200;
};

/// The rendered force network of one named pile (the paper's Fig. 1, right): never a chosen sample.
struct ForceChainSpec {
  bool draw = true;
  int columns = 70;  ///< of the pile, periodic; all are shown
  int layers = 60;   ///< shown; bottom_margin more are computed, so that the shown ones follow the bulk law
  double mu = 0.1;
  std::uint64_t sample = 0;  ///< of the experiment's seed
  SceneSpec scene;           ///< its window is ignored: columns and layers above say what is shown
  bool weight = true;        ///< also the weights of the same pile's beads
  bool friction = false;     ///< also how much of its friction each contact uses
  bool response = true;      ///< also how they change with the overload, every bead keeping its random number

  /// Saturates: what is absurd is refused, but only after it has been looked at.
  int computed_layers() const {
    return std::min(layers, std::numeric_limits<int>::max() - bottom_margin) + bottom_margin;
  }
};

/// One more picture of the pile of ForceChainSpec, under a name of its own.
struct PictureSpec {
  std::string scene = "forces";
  std::vector<double> window;  ///< x0, x1 in bead diameters from the middle, first and last layer; empty: all shown
  std::vector<double> range;   ///< ends of the colour scale; empty: from what is shown
  std::string colour_map;      ///< empty: the scene's own
  int width_px = 1600;

  /// What is to be drawn, with the rest as the force-chain picture has it. Throws InputError if a list does not have as
  /// many numbers as it needs.
  SceneSpec scene_like(const ForceChainSpec& chains) const;
};

/// The mean response of an ensemble over the plane, with the fitted rays and widths.
struct ResponseFieldSpec {
  bool draw = true;  ///< at the friction coefficient of figures.response_profiles
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
  PrecisionSpec precision;
  ClaimSpec claims;
  FigureSpec figures;
  RedrawnBeadsSpec redrawn_beads;
  CountedWorkSpec counted_work;
  SmallFrictionSpec small_friction;
  ChainShareSpec chain_share;
  LawComparisonSpec law_comparison;
  NonlinearitySpec nonlinearity;
  StressSpec stress;
  ErrorAgainstTimeSpec error_against_time;
  ForceChainSpec force_chains;
  std::map<std::string, PictureSpec> pictures;  ///< by name, the tables [scenes.pictures.NAME]
  ResponseFieldSpec response_field;
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
