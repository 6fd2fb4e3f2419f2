#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bench/sampler_suite.h"
#include "sampling/group_kernels.h"

namespace granuscope {
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
    for (std::size_t p = 0; p < phases; ++p) {
      parts += fmt::format(R"(, "{}": {})", phase_names[p], c.ns_per_bead[p]);
    }
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
  for (const SamplerRatio& r : bench.ratios) {
    ratios.push_back(fmt::format(R"(    "{}": {})", r.name, r.value));
    if (!r.limit) continue;
    targets.push_back(fmt::format(R"(    {{"name": "{}", "measured": {}, "{}": {}, "met": {}}})", r.name, r.value,
                                  r.at_most ? "at_most" : "at_least", *r.limit, r.met()));
  }
  const EnsembleMemory& m = bench.memory;
  const std::string memory = m.samples == 0 ? "null"
                                            : fmt::format(R"({{"samples": {}, "threads": {}, "peak_bytes": {:.0f}}})",
                                                          m.samples, m.threads, m.peak_bytes);
  return fmt::format(
      "{{\n  \"suite\": \"sampler\",\n  \"lanes\": {},\n  \"instruction_set\": \"{}\",\n  \"cases\": [\n{}\n  ],\n"
      "  \"batch_ns_per_bead_by_phase\": [\n{}\n  ],\n  \"scaling\": [\n{}\n  ],\n  \"memory\": {},\n  \"ratios\": "
      "{{\n{}\n  }},\n  "
      "\"targets\": [\n{}\n  ]\n}}\n",
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
  for (const SamplerRatio& r : bench.ratios) {
    text += r.limit ? fmt::format("{:<4}{}: {:.2f}, {} {:g}\n", r.met() ? "ok" : "--", r.name, r.value,
                                  r.at_most ? "at most" : "at least", *r.limit)
                    : fmt::format("    {}: {:.2f}\n", r.name, r.value);
  }
  return text;
}

}  // namespace granuscope
