#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "model/lattice.h"
#include "sampling/sampler_spec.h"
#include "support/error.h"
#include "support/key.h"

namespace granuscope {
/// How the top is loaded.
enum class Load {
  uniform,  ///< 1 on every top bead
  point,    ///< 1 on every top bead, 1 + overload on the middle one
};

/// How the response to a load is measured.
enum class EstimatorName {
  point,        ///< the paper's procedure: overloaded piles minus the uniform load
  paired,       ///< the standard procedure: each pile solved with and without the overload, keeping its random numbers
  multiplexed,  ///< every top load raised or lowered at random; the linear response by cross-correlation
  fluctuation,  ///< no load at all: how the fluctuations of uniformly loaded piles travel down
};

/// Consecutive samples that share the order in which their layers are solved, and therefore the block.
inline constexpr std::uint64_t group_size = 8;

// Limits of ResponseSpec.
inline constexpr double least_epsilon = 1e-6, epsilon_limit = 1;  ///< the latter is outside
inline constexpr int most_overloads = 64;                         ///< of a pile
inline constexpr int shallow_response = 20;                       ///< layers: peaks above are hardly wider than a bead
inline constexpr int min_blocks = 8;                              ///< fewest that give a standard error
inline constexpr int most_blocks = 10'000;                        ///< more give no better one
inline constexpr std::uint64_t most_samples = 1'000'000'000;      ///< of one seed
inline constexpr int most_reference_lag = 1000, most_base_step = 1000, most_first_base = 1'000'000;  ///< layers
/// Largest sign_run: several runs must fit into a layer.
int longest_run(const LatticeSpec& lattice);

/// How the response of an ensemble is measured, and on how many samples.
struct ResponseSpec {
  EstimatorName estimator = EstimatorName::point;
  double overload = 1.0;  ///< extra force on the middle top bead (point, paired)
  int overloads = 1;      ///< point: so many top beads have it, evenly spaced; 0: as many as fit (overloads_of)
  bool coupled = false;   ///< point: the piles of a group share their numbers, and their loads stand apart
  double epsilon = 0.25;  ///< share by which each top load is raised or lowered (multiplexed)
  bool opposite = false;  ///< multiplexed: each pile once more with all variations reversed, from the same numbers
  int sign_run = 1;       ///< multiplexed: neighbouring top beads varied alike, see estimator.h
  // Of the estimator fluctuation, in layers; see estimator.h.
  int reference_lag = 24;        ///< distance from a base to the layer that others are referred to
  int first_base = 0;            ///< shallowest base; 0: where the fluctuations are saturated
  int base_step = 6;             ///< distance of the bases
  std::uint64_t samples = 3456;  ///< numbers 0 .. samples-1 of the seed
  int blocks = 32;               ///< each of whole groups of eight samples (the last group may be incomplete)
};

/// The same response on another ring: with shorter runs where its own do not fit.
ResponseSpec on_ring(ResponseSpec spec, const LatticeSpec& lattice);

constexpr ResponseSpec multiplexed_response(double epsilon, bool opposite = false, int sign_run = 1) {
  return {.estimator = EstimatorName::multiplexed, .epsilon = epsilon, .opposite = opposite, .sign_run = sign_run};
}

/// Whether the estimator lays a load on a single top bead.
inline bool loads_one_bead(EstimatorName estimator) {
  return estimator == EstimatorName::point || estimator == EstimatorName::paired;
}

/// The load that the response is one to: epsilon (multiplexed) or the overload, in loads of one top bead; 0 where there
/// is none.
inline double load_size(const ResponseSpec& spec) {
  if (spec.estimator == EstimatorName::fluctuation) return 0;
  return spec.estimator == EstimatorName::multiplexed ? spec.epsilon : spec.overload;
}

/// [response], bound to the spec.
std::vector<Key> keys_of(ResponseSpec& spec);

/// The first number out of range on this lattice, or that would change nothing.
Problem find_problem(const ResponseSpec& spec, const LatticeSpec& lattice);

std::string name_of(Load load);
Load load_named(const std::string& name);

/// "point", "paired", "multiplexed", "fluctuation".
std::string name_of(EstimatorName estimator);
/// Throws InputError naming the known estimators.
EstimatorName estimator_named(const std::string& name);

/// One ensemble: piles of one law at one friction coefficient, how they are loaded, and what is measured on them.
struct EnsembleSpec {
  SamplerSpec sampler;
  LatticeSpec lattice;
  ResponseSpec response;
  Load load = Load::point;      ///< of the estimator point; under a uniform load it has no response to measure
  std::vector<int> layers;      ///< recorded layers, ascending; empty: all
  bool record_profiles = true;  ///< record the response [layers, columns] beside the numbers per layer
  /// Of the estimator multiplexed: record the response of H beside that of w. Layers whose depths differ by factors
  /// tell twice as much with it; those of a window hand their noise on to each other with the response, and tell c and
  /// D as well without.
  bool record_H = false;
  /// Of the estimator point under a uniform load: count how the forces of the recorded layers are distributed, see
  /// force_counts.h.
  bool record_forces = false;
};

/// What an ensemble is told by, but for its model and what is recorded, bound to the spec: the keys of its parts, and
/// mu and the load, which experiments have elsewhere. In the order of its configuration.
std::vector<Key> keys_of(EnsembleSpec& spec);

/// Why the estimator cannot measure beads that have a weight of their own, if it cannot.
Problem find_gravity_problem(const SamplerSpec& sampler, const ResponseSpec& response);

/// What is wrong with the sampler, the lattice or the response, or with what they are together (a layer outside the
/// lattice, ...).
Problem find_problem(const EnsembleSpec& spec);
/// Throws InputError with it.
void validate(const EnsembleSpec& spec);

/// Canonical text of everything the ensemble's numbers depend on. Equal text, equal numbers.
std::string configuration_text(const EnsembleSpec& spec);

/// The ensemble of such a text, whose lines of another meaning are skipped. Throws InputError "key: what is wrong".
EnsembleSpec ensemble_configured(const std::string& configuration);

/// The layers whose sums are kept, ascending: those asked for, or all; multiplexed always keeps layer 0, which holds
/// the spectrum of its loads. Of the estimator fluctuation they are lags, of which it always keeps 0.
std::vector<int> recorded_layers(const EnsembleSpec& spec);

/// Samples first .. end-1 of one group.
struct SampleRange {
  std::uint64_t first = 0, end = 0;
  std::uint64_t size() const { return end - first; }
};

/// The samples of the group number `group`, of which the last one may be incomplete. Group g belongs to block g mod
/// blocks: blocks differ by at most one group, and an ensemble of fewer whole groups is the beginning of one of more,
/// with the same samples in the same blocks.
SampleRange samples_of(const EnsembleSpec& spec, std::uint64_t group);

/// Groups of the ensemble, an incomplete one included.
std::uint64_t groups_of(const EnsembleSpec& spec);

/// The first group of a block from the group `from` on.
std::uint64_t group_of_block(const EnsembleSpec& spec, int block, std::uint64_t from);

/// Samples of a block that are in the first `groups` groups of the ensemble.
std::uint64_t samples_in_block(const EnsembleSpec& spec, int block, std::uint64_t groups);

/// The load on every top bead of the estimator point, shape [columns], with its first overload on a bead; or on the
/// middle one.
std::vector<double> top_load(const EnsembleSpec& spec, int bead);
std::vector<double> top_load(const EnsembleSpec& spec);

/// Expected width W of a response peak in bead diameters at depth z, for making sure that the two peaks stay apart:
/// W^2 = 1 + D z with D = 2.2 mu^2.5, which lies above every D measured on 500 x 200 beads up to mu = 0.5.
double expected_width(double mu, double z);

/// Expected speed x_p/z of a peak, for the same purpose: tan 30 degrees, which no peak exceeds up to mu = 1, and
/// 0.8 (mu - 1)^2 more beyond. Lies above what 800 x 200 beads show: 0.61 at mu = 1.3, 0.68 at 1.5, 0.89 at 1.7.
double expected_speed(double mu);

/// Columns of a ring on which the two peaks of the response are still apart down to `layer`; of any model.
double columns_needed(double mu, int layer);
double columns_needed(const SamplerSpec& sampler, int layer);

/// The sampler with the friction at 30 degrees that suits as many columns and layers (FrictionCone::mu_at_30).
SamplerSpec like_at_30(SamplerSpec sampler, double angle);
inline SamplerSpec like_at_30(const EnsembleSpec& spec) { return like_at_30(spec.sampler, spec.lattice.angle); }

/// How many overloads a pile of the estimator point carries, a divisor of the columns. With overloads = 0 as many as
/// stand so far apart that the response to each is the same as to one alone: beads of the law granusolve up to
/// mu = 0.5, whose repairs carry hardly anything beyond the cone |x| <= layer/2, and 32 beads on either side of it.
int overloads_of(const EnsembleSpec& spec);

/// Columns that several overloads need, so that their responses do not meet down to the deepest layer recorded; 0 where
/// there is one, or as many as fit.
double columns_of_overloads(const EnsembleSpec& spec);

/// Columns of the ring that the response is one of: a pile of several overloads is as many such rings, laid on each
/// other.
int response_columns(const EnsembleSpec& spec);

/// Whether the loads of the estimator point do not stand on the middle bead of every pile, so that its sums are
/// "moved_weight" (estimator.h).
bool moves_loads(const EnsembleSpec& spec);

/// The random numbers that a sample of the estimator point is drawn from: those of the first one of its group if they
/// are coupled; and the first of its overloaded beads.
std::uint64_t numbers_of(const EnsembleSpec& spec, std::uint64_t sample);
int overloaded_bead(const EnsembleSpec& spec, std::uint64_t sample);

/// The command that draws one pile of the ensemble again.
std::string replay_command(const EnsembleSpec& spec, std::uint64_t sample);

}  // namespace granuscope
