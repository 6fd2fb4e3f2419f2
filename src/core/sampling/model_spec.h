#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "model/lattice.h"
#include "support/error.h"
#include "support/key.h"

namespace granuscope {

/// What a pile is a model of. All but the first and the last hand the forces of a row down to the next one by a rule of
/// their own, and never look back.
enum class ModelName {
  frictional_beads,  ///< the paper's beads, under one of the laws of sampler_spec.h
  q_model,           ///< each bead hands a random share of its weight to either lower neighbour; no horizontal force
  three_leg,         ///< each bead stands on three legs, on a rectangular lattice
  stochastic_osl,    ///< oriented stress linearity, sigma_xx = eta (1 + v) sigma_zz, v random in space
  diluted_beads,     ///< the paper's beads, of which a share of the contacts is opened; solved as a whole, not by rows
};
inline constexpr std::array<ModelName, 5> all_models = {ModelName::frictional_beads, ModelName::q_model,
                                                        ModelName::three_leg, ModelName::stochastic_osl,
                                                        ModelName::diluted_beads};

/// q-model: the distribution of the share q that the lower-left neighbour gets, independent from bead to bead.
enum class SplitLaw {
  uniform,   ///< on [0, 1]
  critical,  ///< 0 or 1
  beta,      ///< of density 6 q (1 - q)
};

/// Three-leg model: the distribution of the share p that the middle leg carries.
enum class MiddleLaw {
  free,      ///< middle + v, whatever the other legs do; they may pull
  positive,  ///< uniform on [0, share p_max], p_max = 1 - |F_x| / (F_t tan psi): every leg pushes
  clipped,   ///< uniform on what [0, p_max] leaves of middle +- noise, and p_max where it leaves nothing
};

/// q = 1/2 + disorder (q' - 1/2), with q' of the law.
struct QModelSpec {
  SplitLaw split = SplitLaw::uniform;
  double disorder = 1;  ///< 0 (all beads split alike) to 1
};

/// Columns are one bead diameter apart, rows sqrt 3: the outer legs lean by 30 degrees, as the contacts of beads do.
struct ThreeLegSpec {
  MiddleLaw law = MiddleLaw::free;
  double middle = 0.1;   ///< free, clipped: the mean of p before it is clipped
  double noise = 0.05;   ///< free, clipped: p is uniform on middle +- noise
  double share = 1;      ///< positive
  int cell_columns = 1;  ///< free: v is the same within cells of so many columns and rows, which lie at random
  int cell_rows = 1;
};

/// Stochastic OSL: the distribution of v.
enum class NoiseLaw {
  uniform,
  gaussian,  ///< cut at |v| = 1
};

/// The mean speed is that of beads without friction, eta = 1/3. Rows are sqrt(3)/2 apart.
struct StochasticOslSpec {
  double disorder = 0.2;  ///< standard deviation of v
  int cell_columns = 1;   ///< v is the same within cells of so many bead diameters and rows, which lie at random
  int cell_rows = 1;
  int grid = 8;  ///< nodes per bead diameter, and steps per row
  NoiseLaw noise = NoiseLaw::uniform;
};

/// Friction is that of the SamplerSpec. See diluted_beads.h.
struct DilutedBeadsSpec {
  double share = 0.05;        ///< of the contacts below the top layer that are opened
  double least_slack = 0.02;  ///< a contact is opened only if all others can have N - |T|/mu at least so large, in
                              ///< loads of one top bead, at once
};

/// Piles of these are solved as a whole, in a time that grows as the third power of the number of beads.
inline constexpr int most_diluted_beads = 2048;

struct ModelSpec {
  ModelName name = ModelName::frictional_beads;
  QModelSpec q_model;
  ThreeLegSpec three_leg;
  StochasticOslSpec stochastic_osl;
  DilutedBeadsSpec diluted_beads;

  bool is_beads() const { return name == ModelName::frictional_beads; }
  bool has_contacts() const {  ///< of beads with friction: a pile of it is a Pile
    return is_beads() || name == ModelName::diluted_beads;
  }
};

/// A number of a model that says how disordered its piles are.
struct ModelParameter {
  const char *name, *symbol, *meaning;   ///< "middle", "p", "mean share of the middle leg"
  bool (*belongs_to)(const ModelSpec&);  ///< whether its piles depend on it
  double& (*in)(ModelSpec&);             ///< where it is
};
/// Of all models; of each the usual one first.
std::span<const ModelParameter> model_parameters();

/// [model] and the tables of its models, bound to the spec.
std::vector<Key> keys_of(ModelSpec& model);

/// Where its rows lie; of beads with contacts at this angle.
RowGeometry rows_of(const ModelSpec& model, double angle = usual_angle);

/// Layers at the bottom that are computed and not used: failures below would reach up into those of beads; a floor that
/// bears whatever it is given lets the lowest layers of piles that are solved as a whole be freer than others. Models
/// that never look back have none.
int bottom_margin_of(const ModelSpec& model);

/// Roughly by how much the square of a peak's width grows per bead diameter of depth, within a factor of two. Of the
/// models that hand forces down row by row.
double rough_spreading(const ModelSpec& model);

/// Propagation coefficient of the model without its disorder: the speed that disorder slows down. 0 of the q-model.
double speed_without_disorder(const ModelSpec& model);

/// Whether it hands down weights alone and knows no horizontal force.
inline bool is_scalar(const ModelSpec& model) { return model.name == ModelName::q_model; }

/// What is counted of each of its layers beside thrust and weight variance, as means over the beads: "middle" (p of the
/// three-leg model), "traction" (share of its beads on a leg that pulls or, if clipped, for which nothing was left).
std::span<const char* const> extra_names(const ModelSpec& model);

/// The first number out of range, or a lattice on which the model cannot be. Keys are those of the model's table, such
/// as "three_leg.middle".
Problem find_problem(const ModelSpec& model, const LatticeSpec& lattice);

/// Canonical text of everything that its numbers depend on, a line for each; nothing for the beads.
std::string configuration_text(const ModelSpec& model);

/// Takes one line of it, in the order of the text; false: it is none.
bool read_configuration(ModelSpec& model, const std::string& name, const std::string& value);

/// "frictional-beads", "q-model", "three-leg", "stochastic-osl", "diluted-beads". Those that take a name throw
/// InputError with all.
std::string name_of(ModelName name);
ModelName model_named(const std::string& name);
/// "three-leg, positive": with the law it follows.
std::string law_of(const ModelSpec& model);
/// "uniform", "gaussian".
std::string name_of(NoiseLaw law);
/// "uniform", "critical", "beta".
std::string name_of(SplitLaw law);
/// "free", "positive", "clipped".
std::string name_of(MiddleLaw law);

}  // namespace granuscope
