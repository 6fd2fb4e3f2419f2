#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "model/equilibrium.h"
#include "model/pile.h"
#include "sampling/model_spec.h"
#include "support/error.h"
#include "support/key.h"

namespace granuscope {
/// What "a random pile" means. The mean response depends on it, so it is a named choice.
enum class Law { granusolve, eloy_clement, rejection, polytope };

inline constexpr std::array<Law, 4> all_laws = {Law::granusolve, Law::eloy_clement, Law::rejection, Law::polytope};

/// Largest SamplerSpec::max_tries: the key of a random number has 24 bits for the attempt.
inline constexpr std::uint64_t most_tries = (std::uint64_t{1} << 24) - 1;

/// Largest SamplerSpec::burn_in and thinning, so that the last of eight piles keeps its sweeps below most_tries.
inline constexpr std::uint64_t most_sweeps = most_tries / 8;

/// Beads of the largest pile that the law "polytope" takes on by itself: on 32 x 64 beads at mu = 0.3 and lambda = 1
/// some 20 000 sweeps weigh as much as one independent pile, and their number grows faster than that of the beads.
inline constexpr std::uint64_t most_polytope_beads = 4096;

/// How the beads of one layer are ordered while it is solved.
enum class LayerOrder {
  random,      ///< a random first bead and a random direction for each layer: the law
  rightwards,  ///< a random first bead, always rightwards: a reading of the paper's words; breaks mirror symmetry
  fixed,       ///< always from bead 0 rightwards: kept to show that the tests would see it
};

/// Which number of a bead is uniform on what friction allows. Of the affine choices (any component of any of its
/// contact forces) all are one law. The others are no law of both contacts at once: each bead draws one of the two.
enum class DrawnVariable {
  force,  ///< the law
  angle,  ///< the angle that the force of one lower contact makes with it
  ratio,  ///< T/N of one lower contact
};

/// Which of its rules granusolve repairs a failing bead by; backtracks are always left to it. Anything but `all` is
/// another law, kept to show what each rule contributes.
enum class RepairRules {
  all,             ///< pair, arcs and ring
  no_pair,         ///< arcs of four parents and more, and the ring
  no_arcs,         ///< the pair alone
  backtrack_only,  ///< neither: the beads above draw blindly again
};

struct SamplerSpec {
  Law law = Law::granusolve;
  double mu = 0.1;  ///< friction coefficient, 0 <= mu < sqrt(3)
  std::uint64_t seed = 1;
  double load_angle = 0;     ///< of the load on every top bead from the vertical, degrees: to the right > 0
  double load_offset = 0;    ///< how far to the right of their centres the loads act on the top beads, bead radii
  bool lean_excess = false;  ///< both of what a load has beyond 1 alone (LoadLine)
  double bead_weight = 0;    ///< of every bead by itself, loads of one top bead: gravity
  double effort = 200;       ///< granusolve, eloy-clement: a pile fails by name after this many bead solutions per bead
  std::uint64_t max_tries = 1'000'000;  ///< rejection: a pile fails by name after this many tries
  LayerOrder order = LayerOrder::random;
  DrawnVariable drawn = DrawnVariable::force;  ///< granusolve
  RepairRules rules = RepairRules::all;        ///< granusolve
  double lambda = 1;           ///< polytope: the density is the product of length^-lambda over all beads, 0 to 1
  std::uint64_t burn_in = 0;   ///< polytope: sweeps before the first of eight piles; 0: from the autocorrelation
  std::uint64_t thinning = 0;  ///< polytope: sweeps from one of them to the next; 0: from the autocorrelation
  ModelSpec model;             ///< any but the frictional beads has its own law and no mu; of these it takes the seed
};

/// Limit of SamplerSpec::load_angle, degrees: where a load points along a contact, the other one bears nothing.
inline constexpr double load_angle_limit = 30;

/// Largest SamplerSpec::bead_weight: a top load counts for little beside it, and forces keep their digits.
inline constexpr double most_bead_weight = 1000;

/// [sampling], bound to the spec. Its mu is told elsewhere: by the ensemble, or by what an experiment scans.
std::vector<Key> keys_of(SamplerSpec& spec);

/// As the samplers take it.
LoadLine load_line(const SamplerSpec& spec);

/// The first number out of range, or that would change nothing (mu is left to the FrictionCone).
Problem find_problem(const SamplerSpec& spec);
/// Throws InputError with it.
void validate(const SamplerSpec& spec);

/// "granusolve", "eloy-clement", "rejection", "polytope".
std::string name_of(Law law);
/// Of any model: "granusolve", "three-leg, positive".
std::string law_of(const SamplerSpec& spec);
/// Throws InputError naming the known laws.
Law law_named(const std::string& name);

/// Whether piles are drawn by the kernels of eight side by side, which know the law as it is by default.
bool drawn_side_by_side(const SamplerSpec& spec);

/// "force", "angle", "ratio".
std::string name_of(DrawnVariable drawn);

/// "random", "rightwards", "fixed".
std::string name_of(LayerOrder order);

/// "all", "no-pair", "no-arcs", "backtrack-only".
std::string name_of(RepairRules rules);
/// Throws InputError naming the known ones.
RepairRules repair_rules_named(const std::string& name);

/// Changes whenever the same key gives another pile; part of every ensemble's configuration.
inline constexpr const char* sampling_version = "7";

/// A number of a sampler that an experiment varies from ensemble to ensemble: how strong the disorder of its piles is.
struct ScanParameter {
  std::string name;                                    ///< "mu", as experiment files and results have it
  std::string symbol;                                  ///< "μ"
  std::string meaning;                                 ///< "friction coefficient"
  std::function<bool(const SamplerSpec&)> belongs_to;  ///< whether piles of such a sampler depend on it
  std::function<double&(SamplerSpec&)> in;             ///< where it is

  double value(SamplerSpec spec) const { return in(spec); }
  /// "μ = 0.3".
  std::string at(const SamplerSpec& spec) const;
  /// "mu-0.3", for files.
  std::string file_part(const SamplerSpec& spec) const;
  /// "friction coefficient μ".
  std::string label() const { return meaning + " " + symbol; }
};

/// The friction coefficient of beads.
const ScanParameter& friction_parameter();

/// The one that is varied where nothing else is said: friction of beads, else the first of the model.
const ScanParameter& usual_parameter(const SamplerSpec& spec);

/// Throws InputError naming those that belong to the sampler.
const ScanParameter& scan_parameter_named(const std::string& name, const SamplerSpec& spec);

/// The split H_R of a bead whose number of [0, 1) is `uniform`: the variable that the law draws (DrawnVariable) is
/// uniform on what the interval leaves of it. Other variables than the force use half of the numbers for each of the
/// two contacts.
double split_at(DrawnVariable drawn, Outgoing out, double H, Interval interval, double uniform);

/// The density of the split of a bead that draws on `interval`, over a bound that it nowhere exceeds: with this
/// probability a split that was drawn uniformly is kept, where a repair must draw it by the bead's own law.
double kept_share(DrawnVariable drawn, Outgoing out, double H, Interval interval, double H_R);

/// Without the mathematical library, whose last bit depends on the instruction set. Radians; |angle| below pi / 2.
double portable_arctangent(double x);
double portable_tangent(double angle);
}  // namespace granuscope
