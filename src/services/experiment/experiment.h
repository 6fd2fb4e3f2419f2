#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "studies/study.h"
#include "support/key.h"

namespace granuscope {
/// Which plots are made, and of what.
struct FigureSpec {
  bool bead_forces = true;                    ///< the paper's Fig. 1, left: one bead's forces, at profile_mu
  bool response_profiles = true;              ///< the paper's Fig. 2
  double profile_mu = 0.3;                    ///< must be one of the experiment's friction coefficients
  std::vector<int> profile_layers{110, 170};  ///< usable layers, ascending
  bool transport_with_depth = true;           ///< Fig. 3: c and D against z, insets against mu
  bool propagation_against_diffusion = true;  ///< Fig. 4: c against D
  bool scaling_with_friction = true;          ///< D against mu, from slopes and from ratios
  bool propagation_and_thrust = true;         ///< c beside the speed that follows from the thrust ratio
};

/// One more picture of the pile of ForceChainSpec, under a name of its own.
struct PictureSpec {
  std::string scene = "forces";
  std::vector<double> window;  ///< x0, x1 in bead diameters from the middle, first and last layer; empty: all shown
  std::vector<double> range;   ///< ends of the colour scale; empty: from what is shown
  std::string colour_map;      ///< empty: the scene's own
  int width_px = 900;

  /// What is to be rendered, with the rest as the force-chain picture has it. Throws InputError if a list does not have
  /// as many numbers as it needs.
  SceneSpec scene_like(const ForceChainSpec& chains, double angle) const;
};

/// The mean response of an ensemble over the plane, with the fitted rays and widths.
struct ResponseFieldSpec {
  bool show = true;  ///< at the friction coefficient of figures.response_profiles
};

struct ReportSpec {
  bool pdf = true;       ///< also write report.pdf where WeasyPrint is installed
  std::string headline;  ///< page 1 says this instead of sentences made from the numbers; untrusted text
  std::string about;     ///< id of the study that page 1 is about; empty: the main line, or a study if it found nothing
  std::string key_figure;  ///< id of the figure of page 1; empty: the first of what page 1 is about
};

/// One experiment, resolved and validated: what `granuscope run` computes, shows and says. Composed of each room's own
/// parameter struct; the defaults are the paper's numbers.
struct Experiment : MainLine {
  Experiment();

  std::string name = "experiment";  ///< untrusted text, one line
  std::string description;          ///< untrusted text, may be empty
  FigureSpec figures;
  Studies studies;
  std::map<std::string, PictureSpec> pictures;  ///< by name, the tables [scenes.pictures.NAME]
  ResponseFieldSpec response_field;
  ReportSpec report;
  std::map<std::string, std::string> expected_verdicts;  ///< claim id -> verdict, the table [gate.expect]

  /// The main ensemble at one value of what is scanned, with the layers that fits and figures read.
  EnsembleSpec main_ensemble(double value) const;
};

/// Number of letters to insert, remove, replace or swap with their neighbour to turn one word into the other.
int edit_distance(std::string_view a, std::string_view b);

/// The known name that a mistyped one most probably means, the same but for capitals before all others; or nothing if
/// none is near.
std::optional<std::string> nearest_name(std::string_view mistyped, const std::vector<std::string>& known);

/// The one place where the parameters of an experiment are checked against their ranges and against each other. All
/// that is wrong in the order of the keys, of each key the first thing; rules across keys wait for values that make
/// sense.
std::vector<KeyProblem> find_problems(const Experiment& experiment);

/// Those of single values: whether what is written makes sense by itself.
std::vector<KeyProblem> find_value_problems(const Experiment& experiment);

/// A sentence that names keys of beads which change nothing, as the piles are of another model; else empty.
std::string note_of_idle_keys(const Experiment& experiment);

/// A sentence where the columns end the window of the fit above the last usable layer, or where it holds hardly any
/// depth; else empty.
std::string note_of_short_window(const Experiment& experiment);

/// Memory of the largest data of a run, in bytes: the piles under work and the block sums. Saturates, never overflows.
double estimate_memory(const Experiment& experiment);

}  // namespace granuscope
