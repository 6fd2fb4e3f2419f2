#pragma once
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/measured_with.h"
#include "model/lattice.h"
#include "sampling/group_lanes.h"

namespace granuscope {
/// What draws the piles.
///   scalar        Sampler::draw, one pile after the other, without any vectors of its own.
///   beads         Sampler::draw: the first draws use vectors along the layer; what they leave unsolved is repaired
///                 bead by bead, with numbers drawn eight at a time where several are needed.
///   batch         Sampler::draw_groups, eight or sixteen piles side by side, as ensembles are drawn. Includes the
///                 check of every pile's identities and measuring every third layer, as for an ensemble.
///   no-rejection  StraightLine: every first draw accepted.
enum class SamplerEngine { scalar, beads, batch, no_rejection };
inline constexpr std::array all_engines = {SamplerEngine::scalar, SamplerEngine::beads, SamplerEngine::batch,
                                           SamplerEngine::no_rejection};
std::string name_of(SamplerEngine engine);

/// One engine at one friction coefficient on one lattice. Times are medians over the runs.
struct SamplerCase {
  double mu = 0;
  LatticeSpec lattice;
  SamplerEngine engine = SamplerEngine::scalar;
  double ns_per_bead = 0;       ///< processor time of the drawing thread
  double wall_ns_per_bead = 0;  ///< by the clock: larger where the machine is shared
  double draws_per_bead = 0;    ///< uniform numbers
  int runs = 0;
  double ns_per_draw() const { return ns_per_bead / draws_per_bead; }
};

/// Where the time of the engine batch goes: nanoseconds per bead of each phase, in the order of sampling/group_lanes.h,
/// and how much there was to do. Shares from a pass of its own, with clocks read on the way, of the time measured
/// without them.
struct PhaseCase {
  double mu = 0;
  LatticeSpec lattice;
  std::array<double, phases> ns_per_bead{};
  double pairs_per_bead = 0, backtracks_per_bead = 0;
};

/// The same work on every thread, against one thread.
struct ThreadScaling {
  int threads = 1;
  int runs = 0;
  double ns_per_bead = 0;       ///< batch: processor time of a thread
  double wall_ns_per_bead = 0;  ///< batch: time of the slowest thread by the clock, for the beads of one thread
  double batch = 0;             ///< beads per second of all threads, over those of one thread
  double arithmetic = 0;        ///< the same of a loop that touches no memory: what the machine allows
};

/// A quotient of two times (or of memory and its unit), and the limit it is held against if it has one.
struct SamplerRatio {
  std::string name;
  double value = 0;
  std::optional<double> limit;
  bool at_most = true;  ///< or at least
  bool met() const { return !limit || (at_most ? value <= *limit : value >= *limit); }
};

struct SamplerBench {
  std::string instruction_set;  ///< the one the kernels use here
  std::vector<SamplerCase> cases;
  std::vector<PhaseCase> phase_cases;
  double scaling_mu = 0;
  LatticeSpec scaling_lattice;
  std::vector<ThreadScaling> scaling;
  EnsembleMemory memory;
  std::vector<SamplerRatio> ratios;
};

struct SamplerBenchOptions {
  std::vector<double> mus = {0.1, 0.3, 0.8, 1.3};
  std::vector<LatticeSpec> lattices = {{500, 200}, {1000, 1000}, {250, 250}};
  double beads_per_case = 12e6;  ///< drawn by each engine, in as many runs as they make (at least 3)
  bool memory = true;            ///< measure that of an ensemble, too
  int threads = 0;               ///< most threads of the scaling; 0: as many as the machine has
};

/// Times the law granusolve under a uniform load: run by run the engines take turns, so that what else the machine does
/// meets all of them. `say` is told what is measured next.
SamplerBench run_sampler_suite(const SamplerBenchOptions& options, const std::function<void(const std::string&)>& say);

/// One JSON object with a final newline.
std::string sampler_bench_json(const SamplerBench& bench);
/// The same as a table for people.
std::string sampler_bench_table(const SamplerBench& bench);

}  // namespace granuscope
