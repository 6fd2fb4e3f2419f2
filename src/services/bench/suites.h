#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "analysis/precision.h"
#include "model/lattice.h"
#include "model/pile.h"
#include "render/render_pile.h"
#include "sampling/pile_group.h"

namespace granuscope {
/// The JSON object of a suite with one member more, "measured": by which program and commit, on which processor and
/// day. The machine's name is not in it.
std::string with_measured_with(const std::string& suite_json);

/// How a process of its own ended.
struct OwnProcess {
  bool done = false;  ///< its work was: nothing was thrown
  double peak_bytes = 0;
};

/// Does `work` in a process of its own, whose memory is that of this work. Throws EnvironmentError if none can be
/// started.
OwnProcess in_own_process(const std::function<void()>& work);

/// What an ensemble of piles of 500 x 200 beads holds in memory while it is drawn and summed.
struct EnsembleMemory {
  std::uint64_t samples = 0;
  int threads = 0;
  double peak_bytes = 0;  ///< resident, with the program and its libraries
};

/// Draws the ensemble of the paper's Fig. 2 (3461 piles under an overload, profiles of every layer that a fit may use)
/// in a process of its own. Call it while this process has one thread. Throws EnvironmentError if that process fails.
EnsembleMemory measure_ensemble_memory(int threads);

/// What a sampler would cost if every first draw were accepted: the random numbers, the balance and the split of every
/// bead, layer by layer by the kernels of single piles, and nothing else. No engine can be faster in this form.
/// The numbers it leaves are no solution: beads without an interval are left as they are.
class StraightLine {
 public:
  StraightLine(double mu, Lattice lattice);
  /// Fills `pile` from the random numbers of `sample`, under a uniform load.
  void fill(std::uint64_t seed, std::uint64_t sample, Pile& pile);

 private:
  Lattice lattice_;
  FrictionCone cone_;
  std::vector<double> uniforms_, half_load_, no_force_, H_, slack_;
};

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

/// Where the time of the engine batch goes: nanoseconds per bead of each phase, in the order of sampling/pile_group.h,
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

/// A time, an amount of memory or a quotient of two such numbers, and the limit it is held against if it has one.
struct BenchNumber {
  std::string name;
  double value = 0;
  std::optional<double> limit;
  bool at_most = true;  ///< or at least
  bool met() const { return !limit || (at_most ? value <= *limit : value >= *limit); }
  /// Of one with a limit, as an object in a list of targets.
  std::string json() const;
};

struct SamplerBench {
  std::string instruction_set;  ///< the one the kernels use here
  std::vector<SamplerCase> cases;
  std::vector<PhaseCase> phase_cases;
  double scaling_mu = 0;
  LatticeSpec scaling_lattice;
  std::vector<ThreadScaling> scaling;
  EnsembleMemory memory;
  std::vector<BenchNumber> ratios;
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

struct AccuracyOptions {
  int threads = 1;       ///< blocks drawn at the same time; one at a time disturbs them least
  int repetitions = 32;  ///< at least least_repetitions; the scatter of 32 is known to 13 %
  bool quick = false;    ///< mu = 0.1 and 0.3, only the best estimators, and no laws of small piles
};

/// One estimator at one friction coefficient: all its repetitions in one ensemble.
struct AccuracyCase {
  ErrorCurve curve;    ///< no points and no c and D where peaks were not measured; their reason says why
  double seconds = 0;  ///< processor time of drawing and summing all repetitions
  double wall = 0;     ///< by the clock, times the threads: more where others use the processors, too
  Estimate c_thrust;   ///< of all samples

  int repetitions() const { return curve.spec.response.blocks / repetition_blocks; }
  bool thrust_alone() const { return curve.spec.load == Load::uniform; }
};

/// How many times cheaper than by the estimator point in its literal form D and c of the peaks come at equal scatter by
/// its coupled form, by fluctuation, or by multiplexed with one epsilon and its options, and c_thrust, another
/// quantity, than c of the peaks by point. What a larger epsilon gains in scatter it pays with a bias of the order
/// epsilon^2: see the shifts of the cases.
struct Speedup {
  double mu = 0;
  ResponseSpec response;
  double D = 0, c_peaks = 0, c_thrust = 0;
  bool stated = false;  ///< the one that stands for the linear response
};

struct AccuracyTable {
  std::vector<AccuracyCase> cases;
  std::vector<Speedup> speedups;
};

/// Measures, on 500 x 200 beads (fluctuation: 256 x 1600), what each estimator costs and how its c and D scatter over
/// independent repetitions (precision.h), not what its own error bars say: all of them at mu = 0.1 and 0.3, the best at
/// 0.15, 0.2 and 0.4, too. The first case of each mu is point in its literal form. Laws that do not reach
/// piles in which peaks stand apart are measured on the largest piles they are good for, by the error of c_thrust
/// alone, and say so. Times are processor seconds of all threads that draw and sum, Fourier transforms included; the
/// fits that follow are the same for all estimators and are left out.
AccuracyTable measure_accuracy(const AccuracyOptions& options, std::ostream& messages);

/// Times, samples and the members stderr_* are those of one repetition.
std::string accuracy_json(const AccuracyTable& table);

/// One picture of the suite.
struct RenderCase {
  std::string name;
  int columns = 0, layers = 0;  ///< of the pile, mu = 0.3 under an overload
  SceneSpec spec;
};

/// What it took, in a process of its own; the shortest of several runs.
struct RenderTiming {
  RenderCase picture;
  SceneStatistics statistics;    ///< with the seconds of each step
  double seconds = 0;            ///< from the file to the PNG on disk, wall time; without starting the program
  std::uint64_t peak_bytes = 0;  ///< most memory that the process had
  std::uint64_t image_bytes = 0;
  std::string failure;  ///< why there are no numbers, if so
};

struct RenderBench {
  std::vector<RenderTiming> timings;
  std::vector<BenchNumber> targets;
};

/// Pictures of 70 x 60 to 4000 x 4000 beads at 800 to 8000 pixels, with and without skipping, and a small window of
/// the largest pile. `quick`: without the ones that take minutes.
std::vector<RenderCase> render_cases(bool quick);

/// Renders each case, `say` telling which. Piles and pictures are made in `folder` and removed.
RenderBench run_render_suite(const std::vector<RenderCase>& cases, const std::filesystem::path& folder,
                             const std::function<void(const std::string&)>& say);

/// One JSON object with a final newline.
std::string render_bench_json(const RenderBench& bench);
/// The same as a table for people.
std::string render_bench_table(const RenderBench& bench);

}  // namespace granuscope
