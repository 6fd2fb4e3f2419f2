#include "bench/suites.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <barrier>
#include <chrono>
#include <cmath>
#include <functional>
#include <numeric>
#include <thread>

#include "ensemble/ensemble_runner.h"
#include "sampling/group_kernels.h"
#include "sampling/layer_kernels.h"
#include "sampling/sampler.h"
#include "support/error.h"
#include "support/plain_text.h"
#include "support/progress.h"
#include "support/provenance.h"

namespace granuscope {
std::string with_measured_with(const std::string& suite_json) {
  const Provenance provenance = collect_provenance();
  const nlohmann::ordered_json measured = {
      {"program", provenance.program_version}, {"commit", provenance.git_commit},
      {"changed", provenance.git_dirty},       {"compiler", provenance.compiler},
      {"processor", provenance.host_cpu},      {"threads", provenance.hardware_threads},
      {"date", current_time().substr(0, 10)}};
  std::string text = suite_json;
  return text.insert(text.find('{') + 1, "\n  \"measured\": " + measured.dump() + ",");
}

OwnProcess in_own_process(const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child < 0) throw EnvironmentError("no child process can be started; try again");
  if (child == 0) {
    try {
      work();
    } catch (...) {
      ::_exit(1);
    }
    ::_exit(0);
  }
  int status = 0;
  rusage used{};
  const bool ended = ::wait4(child, &status, 0, &used) == child && WIFEXITED(status);
  return {ended && WEXITSTATUS(status) == 0, static_cast<double>(used.ru_maxrss) * 1024};
}

EnsembleMemory measure_ensemble_memory(int threads) {
  EnsembleSpec spec;
  spec.sampler.mu = 0.1;
  spec.lattice = {500, 200};
  spec.response.samples = 3461;
  spec.layers.resize(static_cast<std::size_t>(Lattice(spec.lattice).usable_layers()));
  std::iota(spec.layers.begin(), spec.layers.end(), 0);
  const OwnProcess drawing = in_own_process([&] { run_ensemble(spec, threads, nullptr); });
  if (!drawing.done) {
    throw EnvironmentError("the ensemble whose memory was to be measured could not be drawn; free some memory");
  }
  return {spec.response.samples, threads, drawing.peak_bytes};
}

namespace {

/// Errors of beads that are not repaired grow with depth. Every so many layers the pile starts anew from the load, so
/// that the numbers stay of the size that a solver works with.
constexpr int layers_in_a_row = 16;

}  // namespace

StraightLine::StraightLine(double mu, Lattice lattice)
    : lattice_(lattice),
      cone_(mu),
      uniforms_(static_cast<std::size_t>(lattice.columns()) + uniform_padding),
      half_load_(static_cast<std::size_t>(lattice.columns()), 0.5),
      no_force_(static_cast<std::size_t>(lattice.columns())),
      H_(static_cast<std::size_t>(lattice.columns())),
      slack_(static_cast<std::size_t>(lattice.columns())) {}

void StraightLine::fill(std::uint64_t seed, std::uint64_t sample, Pile& pile) {
  const auto columns = static_cast<std::size_t>(lattice_.columns());
  for (int layer = 0; layer < lattice_.layers(); ++layer) {
    fill_first_uniforms(seed, static_cast<std::uint32_t>(sample), layer, uniforms_.data(), columns);
    const std::size_t here = lattice_.index(layer, 0);
    const auto row = [&](std::size_t from) {
      return LowerRow{&pile.V_R[here + from], &pile.V_L[here + from], &H_[from],
                      &pile.H_R[here + from], &pile.H_L[here + from], &slack_[from]};
    };
    if (layer % layers_in_a_row == 0) {
      const double* const half = half_load_.data();
      draw_beads(cone_, {half, half, no_force_.data(), no_force_.data()}, uniforms_.data(), columns, row(0));
      continue;
    }
    const std::size_t up = lattice_.index(layer - 1, 0);
    const auto above = [&](std::size_t upper_left, std::size_t upper_right) {
      return UpperRow{&pile.V_R[up + upper_left], &pile.V_L[up + upper_right], &pile.H_R[up + upper_left],
                      &pile.H_L[up + upper_right]};
    };
    // Away from the seam the parents of a bead stand side by side; the seam's bead is a run of its own.
    const std::size_t first = layer % 2 == 0 ? 1 : 0, seam = layer % 2 == 0 ? 0 : columns - 1;
    draw_beads(cone_, above(0, 1), &uniforms_[first], columns - 1, row(first));
    draw_beads(cone_, above(columns - 1, 0), &uniforms_[seam], 1, row(seam));
  }
}

namespace {

constexpr std::uint64_t seed = 1;
constexpr int fewest_runs = 3;
constexpr int kept_every = 3;  // layers

// The limits the ratios are held against, for machines with AVX-512.
constexpr double low_friction = 0.3, middle_friction = 0.8;
constexpr double batch_gain_small = 2.5, batch_gain_middle = 4;
constexpr double scalar_cost_0_1 = 10, scalar_cost_0_3 = 17, batch_cost_0_3 = 5;
constexpr double growth_with_size = 1.2;
constexpr double most_memory = 200;  // MB
constexpr int memory_threads = 2;

// Where the scaling with threads is measured.
constexpr double scaling_mu = 0.3;
constexpr LatticeSpec scaling_lattice = {500, 200};
constexpr int scaling_runs = 5, scaling_groups = 8;
constexpr std::uint64_t arithmetic_steps = 40'000'000;

struct Seconds {
  double processor = 0, wall = 0;
};

template <typename Work>
Seconds seconds_of(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  const double processor = processor_seconds();
  work();
  return {processor_seconds() - processor,
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()};
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

/// As many piles as the law draws at once at any friction.
constexpr std::size_t piles_together = 2 * group_lanes;

/// Room for some piles, and every engine to draw the same samples.
class Piles {
 public:
  Piles(double mu, const LatticeSpec& lattice)
      : lattice_(lattice),
        spec_{.mu = mu, .seed = seed, .model = {}},
        sampler_(make_sampler(spec_, lattice_)),
        straight_line_(mu, lattice_),
        load_(static_cast<std::size_t>(lattice.columns), 1.0),
        loads_(piles_together, load_),
        pile_(lattice_),
        samples_(piles_together),
        failures_(piles_together) {
    KeptLayers kept;
    for (int layer = 0; layer < lattice.layers; layer += kept_every) kept.layers.push_back(layer);
    sampler_->keep_layers(kept);
  }

  SamplerCounts take_counts() { return sampler_->take_counts(); }
  double beads() const { return static_cast<double>(piles_together * lattice_.beads()); }

  void draw(SamplerEngine engine, std::uint64_t group) {
    const std::uint64_t first = group * piles_together;
    std::ranges::fill(failures_, std::nullopt);
    if (engine == SamplerEngine::batch) {
      std::iota(samples_.begin(), samples_.end(), first);
      const std::size_t at_once = piles_at_once(spec_, lattice_);
      for (std::size_t done = 0; done < piles_together; done += at_once) {
        sampler_->draw_groups({samples_.data() + done, at_once}, {loads_.data() + done, at_once},
                              {failures_.data() + done, at_once});
      }
    } else {
      // One pile after the other into the same memory, which stays in the caches where it fits.
      for (std::size_t k = 0; k < piles_together; ++k) {
        if (engine == SamplerEngine::beads) failures_[k] = sampler_->draw(first + k, load_, pile_);
        if (engine == SamplerEngine::scalar) {
          const PlainKernels plain;
          failures_[k] = sampler_->draw(first + k, load_, pile_);
        }
        if (engine == SamplerEngine::no_rejection) straight_line_.fill(seed, first + k, pile_);
      }
    }
    for (const auto& failure : failures_) {
      if (failure) throw EnvironmentError("a pile of the suite could not be completed, so its time means nothing");
    }
  }

 private:
  Lattice lattice_;
  SamplerSpec spec_;
  std::unique_ptr<Sampler> sampler_;
  StraightLine straight_line_;
  std::vector<double> load_;
  std::vector<std::span<const double>> loads_;
  Pile pile_;
  std::vector<std::uint64_t> samples_;
  std::vector<std::optional<SamplingFailure>> failures_;
};

void time_engines(double mu, const LatticeSpec& lattice, double beads_per_case, SamplerBench& bench) {
  Piles piles(mu, lattice);
  const int runs = std::max(fewest_runs, static_cast<int>(beads_per_case / piles.beads()));
  std::vector<double> processor[all_engines.size()], wall[all_engines.size()];
  for (int run = 0; run <= runs; ++run) {
    for (std::size_t e = 0; e < all_engines.size(); ++e) {
      const Seconds took = seconds_of([&] { piles.draw(all_engines[e], static_cast<std::uint64_t>(run)); });
      if (run == 0) continue;  // the first one is handed its memory by the system
      processor[e].push_back(1e9 * took.processor / piles.beads());
      wall[e].push_back(1e9 * took.wall / piles.beads());
    }
  }
  // The engines that draw numbers draw the same ones.
  const SamplerCounts drawn = piles.take_counts();
  const double draws_per_bead = static_cast<double>(drawn.uniforms) / static_cast<double>(drawn.beads);
  for (std::size_t e = 0; e < all_engines.size(); ++e) {
    const bool rejects = all_engines[e] != SamplerEngine::no_rejection;
    bench.cases.push_back({.mu = mu,
                           .lattice = lattice,
                           .engine = all_engines[e],
                           .ns_per_bead = median(processor[e]),
                           .wall_ns_per_bead = median(wall[e]),
                           .draws_per_bead = rejects ? draws_per_bead : 1,
                           .runs = runs});
    if (all_engines[e] != SamplerEngine::batch) continue;
    const PhaseTimes times;
    for (int run = 0; run < fewest_runs; ++run) piles.draw(SamplerEngine::batch, static_cast<std::uint64_t>(run));
    const SamplerCounts counts = piles.take_counts();
    const auto per_bead = [&](std::uint64_t count) {
      return static_cast<double>(count) / static_cast<double>(counts.beads);
    };
    PhaseCase where{mu, lattice, times.shares(), per_bead(counts.pairs), per_bead(counts.backtracks)};
    for (double& part : where.ns_per_bead) part *= median(processor[e]);
    bench.phase_cases.push_back(where);
  }
}

/// A chain of multiplications and additions in registers; returns its end so that it has to be gone through.
double compute() {
  double x = 0.5;
  for (std::uint64_t step = 0; step < arithmetic_steps; ++step) x = 3.7 * x * (1 - x);
  return x;
}

/// Every thread does `work(thread)` at the same time; what the slowest took by the clock and the mean of processor
/// time.
Seconds seconds_on_threads(int threads, const std::function<void(int)>& work) {
  std::vector<Seconds> took(static_cast<std::size_t>(threads));
  std::barrier start(threads);
  std::vector<std::jthread> workers;
  workers.reserve(static_cast<std::size_t>(threads));
  for (int thread = 0; thread < threads; ++thread) {
    workers.emplace_back([&, thread] {
      start.arrive_and_wait();
      took[static_cast<std::size_t>(thread)] = seconds_of([&] { work(thread); });
    });
  }
  workers.clear();  // waits
  Seconds all;
  for (const Seconds& one : took) {
    all.wall = std::max(all.wall, one.wall);
    all.processor += one.processor / threads;
  }
  return all;
}

std::vector<ThreadScaling> time_threads(int most) {
  std::vector<int> counts;
  for (int threads = 1; threads < most; threads *= 2) counts.push_back(threads);
  counts.push_back(most);
  std::vector<std::unique_ptr<Piles>> piles;
  for (int thread = 0; thread < most; ++thread) {
    piles.push_back(std::make_unique<Piles>(scaling_mu, scaling_lattice));
    piles.back()->draw(SamplerEngine::batch, 0);
  }
  std::vector<std::vector<double>> processor(counts.size()), wall(counts.size()), arithmetic(counts.size());
  std::vector<double> ends(static_cast<std::size_t>(most));
  for (int run = 0; run < scaling_runs; ++run) {
    for (std::size_t c = 0; c < counts.size(); ++c) {
      const Seconds drawing = seconds_on_threads(counts[c], [&](int thread) {
        for (std::uint64_t group = 0; group < scaling_groups; ++group) {
          piles[static_cast<std::size_t>(thread)]->draw(SamplerEngine::batch, group);
        }
      });
      const double beads = piles.front()->beads() * scaling_groups;
      processor[c].push_back(1e9 * drawing.processor / beads);
      wall[c].push_back(1e9 * drawing.wall / beads);
      arithmetic[c].push_back(
          seconds_on_threads(counts[c], [&](int thread) { ends[static_cast<std::size_t>(thread)] = compute(); }).wall);
    }
  }
  if (!std::ranges::all_of(ends, [](double end) { return std::isfinite(end); })) {
    throw std::logic_error("the arithmetic loop left its interval");
  }
  std::vector<ThreadScaling> scaling;
  for (std::size_t c = 0; c < counts.size(); ++c) {
    scaling.push_back({counts[c], scaling_runs, median(processor[c]), median(wall[c]),
                       counts[c] * median(wall[0]) / median(wall[c]),
                       counts[c] * median(arithmetic[0]) / median(arithmetic[c])});
  }
  return scaling;
}

const SamplerCase* find(const SamplerBench& bench, double mu, const LatticeSpec& lattice, SamplerEngine engine) {
  const auto found = std::ranges::find_if(bench.cases, [&](const SamplerCase& c) {
    return c.mu == mu && c.lattice.columns == lattice.columns && c.lattice.layers == lattice.layers &&
           c.engine == engine;
  });
  return found == bench.cases.end() ? nullptr : &*found;
}

void add_ratios(SamplerBench& bench, const SamplerBenchOptions& options) {
  for (const double mu : options.mus) {
    for (const LatticeSpec& lattice : options.lattices) {
      const double scalar = find(bench, mu, lattice, SamplerEngine::scalar)->ns_per_bead,
                   batch = find(bench, mu, lattice, SamplerEngine::batch)->ns_per_bead,
                   limit = find(bench, mu, lattice, SamplerEngine::no_rejection)->ns_per_bead;
      const std::string where = fmt::format("mu={:g} {}x{}", mu, lattice.columns, lattice.layers);
      BenchNumber gain{where + " scalar/batch", scalar / batch, std::nullopt, false};
      if (mu <= low_friction) gain.limit = batch_gain_small;
      if (mu == middle_friction) gain.limit = batch_gain_middle;
      BenchNumber scalar_cost{where + " scalar/no-rejection", scalar / limit, std::nullopt};
      if (mu == 0.1) scalar_cost.limit = scalar_cost_0_1;
      if (mu == 0.3) scalar_cost.limit = scalar_cost_0_3;
      BenchNumber batch_cost{where + " batch/no-rejection", batch / limit, std::nullopt};
      if (mu == 0.3) batch_cost.limit = batch_cost_0_3;
      bench.ratios.insert(bench.ratios.end(), {gain, scalar_cost, batch_cost});
    }
    for (const SamplerEngine engine : {SamplerEngine::scalar, SamplerEngine::beads, SamplerEngine::batch}) {
      const SamplerCase *const large = find(bench, mu, {1000, 1000}, engine), *const small =
                                                                                  find(bench, mu, {250, 250}, engine);
      if (large == nullptr || small == nullptr) continue;
      // Deeper piles backtrack more often, and draw more numbers, under the law itself, whatever the machine.
      const std::string name = fmt::format("mu={:g} {} 1000x1000/250x250", mu, name_of(engine));
      bench.ratios.push_back({name + " per bead", large->ns_per_bead / small->ns_per_bead, std::nullopt});
      bench.ratios.push_back({name + " per draw", large->ns_per_draw() / small->ns_per_draw(), growth_with_size});
    }
  }
}

}  // namespace

std::string name_of(SamplerEngine engine) {
  static constexpr Names<SamplerEngine, 4> names{{{SamplerEngine::scalar, "scalar"},
                                                  {SamplerEngine::beads, "beads"},
                                                  {SamplerEngine::batch, "batch"},
                                                  {SamplerEngine::no_rejection, "no-rejection"}}};
  return name_in(names, engine);
}

SamplerBench run_sampler_suite(const SamplerBenchOptions& options, const std::function<void(const std::string&)>& say) {
  SamplerBench bench;
  bench.instruction_set = instruction_set();
  if (options.memory) {  // first, while there is one thread
    say("memory of an ensemble");
    bench.memory = measure_ensemble_memory(memory_threads);
    bench.ratios.push_back({fmt::format("{} samples of 500x200 with {}, peak memory in MB", bench.memory.samples,
                                        how_many(bench.memory.threads, "thread")),
                            bench.memory.peak_bytes / 1e6, most_memory});
  }
  for (const LatticeSpec& lattice : options.lattices) {
    for (const double mu : options.mus) {
      say(fmt::format("{} x {} beads at mu = {:g}", lattice.columns, lattice.layers, mu));
      time_engines(mu, lattice, options.beads_per_case, bench);
    }
  }
  say("scaling with threads");
  bench.scaling_mu = scaling_mu;
  bench.scaling_lattice = scaling_lattice;
  bench.scaling = time_threads(worker_count(options.threads));
  add_ratios(bench, options);
  return bench;
}

namespace {

constexpr std::array<const char*, phases> phase_names = {"first_draws", "search", "pairs", "one_by_one", "finishing"};

/// `draws`: what follows the times, if anything.
std::string case_json(double mu, const LatticeSpec& lattice, const std::string& engine, int threads, double ns,
                      double wall_ns, const std::string& draws, int runs) {
  return fmt::format(
      R"(    {{"mu": {}, "columns": {}, "layers": {}, "engine": "{}", "threads": {}, "ns_per_bead": {}, )"
      R"("wall_ns_per_bead": {},{} "runs": {}}})",
      mu, lattice.columns, lattice.layers, engine, threads, ns, wall_ns, draws, runs);
}

}  // namespace

std::string BenchNumber::json() const {
  return fmt::format(R"(    {{"name": "{}", "measured": {}, "{}": {}, "met": {}}})", name, value,
                     at_most ? "at_most" : "at_least", *limit, met());
}

std::string sampler_bench_json(const SamplerBench& bench) {
  std::vector<std::string> cases, scaling, ratios, targets;
  for (const SamplerCase& c : bench.cases) {
    const std::string draws =
        fmt::format(R"( "draws_per_bead": {}, "ns_per_draw": {},)", c.draws_per_bead, c.ns_per_draw());
    cases.push_back(case_json(c.mu, c.lattice, name_of(c.engine), 1, c.ns_per_bead, c.wall_ns_per_bead, draws, c.runs));
  }
  std::vector<std::string> where;
  for (const PhaseCase& c : bench.phase_cases) {
    std::string parts;
    for (std::size_t p = 0; p < phases; ++p) parts += fmt::format(R"(, "{}": {})", phase_names[p], c.ns_per_bead[p]);
    where.push_back(fmt::format(
        R"(    {{"mu": {}, "columns": {}, "layers": {}{}, "pairs_per_bead": {}, "backtracks_per_bead": {}}})", c.mu,
        c.lattice.columns, c.lattice.layers, parts, c.pairs_per_bead, c.backtracks_per_bead));
  }
  for (const ThreadScaling& s : bench.scaling) {
    if (s.threads > 1) {
      cases.push_back(case_json(bench.scaling_mu, bench.scaling_lattice, name_of(SamplerEngine::batch), s.threads,
                                s.ns_per_bead, s.wall_ns_per_bead, "", s.runs));
    }
    scaling.push_back(fmt::format(R"(    {{"threads": {}, "batch": {}, "arithmetic": {}, "runs": {}}})", s.threads,
                                  s.batch, s.arithmetic, s.runs));
  }
  for (const BenchNumber& r : bench.ratios) {
    ratios.push_back(fmt::format(R"(    "{}": {})", r.name, r.value));
    if (!r.limit) continue;
    targets.push_back(r.json());
  }
  const EnsembleMemory& m = bench.memory;
  const std::string memory = m.samples == 0 ? "null"
                                            : fmt::format(R"({{"samples": {}, "threads": {}, "peak_bytes": {:.0f}}})",
                                                          m.samples, m.threads, m.peak_bytes);
  return fmt::format(
      "{{\n  \"suite\": \"sampler\",\n  \"lanes\": {},\n  \"instruction_set\": \"{}\",\n  \"cases\": [\n{}\n  ],\n"
      "  \"batch_ns_per_bead_by_phase\": [\n{}\n  ],\n  \"scaling\": [\n{}\n  ],\n  \"memory\": {},\n  \"ratios\": "
      "{{\n{}\n  }},\n  \"targets\": [\n{}\n  ]\n}}\n",
      group_lanes, bench.instruction_set, fmt::join(cases, ",\n"), fmt::join(where, ",\n"), fmt::join(scaling, ",\n"),
      memory, fmt::join(ratios, ",\n"), fmt::join(targets, ",\n"));
}

std::string sampler_bench_table(const SamplerBench& bench) {
  std::string text = fmt::format(
      "nanoseconds per bead, one thread, vectors of {}\n{:<14}{:>6}{:<2}{:<14}{:>10}{:>10}{:>12}{:>10}{:>6}\n",
      bench.instruction_set, "beads", "mu", "", "engine", "processor", "clock", "draws/bead", "per draw", "runs");
  for (const SamplerCase& c : bench.cases) {
    text += fmt::format("{:<14}{:>6g}{:<2}{:<14}{:>10.2f}{:>10.2f}{:>12.4f}{:>10.2f}{:>6}\n",
                        fmt::format("{} x {}", c.lattice.columns, c.lattice.layers), c.mu, "", name_of(c.engine),
                        c.ns_per_bead, c.wall_ns_per_bead, c.draws_per_bead, c.ns_per_draw(), c.runs);
  }
  text += fmt::format("\nwhere the time of batch goes, in nanoseconds per bead\n{:<14}{:>6}", "beads", "mu");
  for (const char* name : phase_names) text += fmt::format("{:>13}", name);
  text += fmt::format("{:>13}{:>13}\n", "pairs/bead", "backtracks/bead");
  for (const PhaseCase& c : bench.phase_cases) {
    text += fmt::format("{:<14}{:>6g}", fmt::format("{} x {}", c.lattice.columns, c.lattice.layers), c.mu);
    for (const double part : c.ns_per_bead) text += fmt::format("{:>13.2f}", part);
    text += fmt::format("{:>13.4f}{:>13.5f}\n", c.pairs_per_bead, c.backtracks_per_bead);
  }
  text += "\n";
  for (const ThreadScaling& s : bench.scaling) {
    text += fmt::format("{} thread{}: {:.2f} times the beads per second of one, {:.2f} times the arithmetic\n",
                        s.threads, s.threads == 1 ? "" : "s", s.batch, s.arithmetic);
  }
  for (const BenchNumber& r : bench.ratios) {
    text += r.limit ? fmt::format("{:<4}{}: {:.2f}, {} {:g}\n", r.met() ? "ok" : "--", r.name, r.value,
                                  r.at_most ? "at most" : "at least", *r.limit)
                    : fmt::format("    {}: {:.2f}\n", r.name, r.value);
  }
  return text;
}

}  // namespace granuscope
