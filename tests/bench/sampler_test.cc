#include "bench/suites.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sampling/sampler.h"

using namespace granuscope;

TEST_CASE("the sampler suite times every engine at every friction and size, and holds its ratios against limits",
          "[unsanitized]") {
  SamplerBenchOptions options;
  options.mus = {0.1, 0.3};
  options.lattices = {{64, 16}, {40, 20}};
  options.beads_per_case = 1;
  options.threads = 2;
  options.memory = false;  // takes seconds
  int said = 0;
  const SamplerBench bench = run_sampler_suite(options, [&](const std::string&) { ++said; });
  CHECK(said == 5);
  REQUIRE(bench.cases.size() == 2 * 2 * 4);
  for (const SamplerCase& c : bench.cases) {
    CHECK(c.ns_per_bead > 0);
    CHECK(c.wall_ns_per_bead > 0);
    CHECK((c.engine == SamplerEngine::no_rejection ? c.draws_per_bead == 1 : c.draws_per_bead > 1));
    CHECK(c.ns_per_draw() == Approx(c.ns_per_bead / c.draws_per_bead));
    CHECK(c.runs == 3);
  }
  const auto json = nlohmann::json::parse(sampler_bench_json(bench));
  CHECK(json.at("lanes") == 8);
  CHECK_FALSE(json.at("instruction_set").get<std::string>().empty());
  REQUIRE(json.at("batch_ns_per_bead_by_phase").size() == 4);
  CHECK(json.at("batch_ns_per_bead_by_phase")[0].at("pairs_per_bead") > 0);
  CHECK(json.at("batch_ns_per_bead_by_phase")[0].at("backtracks_per_bead") > 0);
  double of_phases = 0;
  for (const char* phase : {"first_draws", "search", "pairs", "one_by_one", "finishing"}) {
    CHECK(json.at("batch_ns_per_bead_by_phase")[0].at(phase) > 0);
    of_phases += json.at("batch_ns_per_bead_by_phase")[0].at(phase).get<double>();
  }
  CHECK(of_phases == Approx(json.at("cases")[2].at("ns_per_bead").get<double>()));
  CHECK(json.at("cases").size() == 17);  // and the batch engine on two threads
  const auto& first = json.at("cases")[0];
  CHECK(first.at("mu") == 0.1);
  CHECK(first.at("columns") == 64);
  CHECK(first.at("layers") == 16);
  CHECK(first.at("engine") == "scalar");
  CHECK(first.at("threads") == 1);
  CHECK(json.at("cases")[16].at("threads") == 2);
  REQUIRE(json.at("scaling").size() == 2);
  CHECK(json.at("scaling")[0].at("batch") == 1);
  CHECK(json.at("scaling")[0].at("arithmetic") == 1);
  const double scalar = first.at("ns_per_bead"), batch = json.at("cases")[2].at("ns_per_bead");
  CHECK(json.at("ratios").at("mu=0.1 64x16 scalar/batch").get<double>() == Approx(scalar / batch));
  CHECK(json.at("targets").size() == 2 * 2 + 2 * 2 + 2);
  CHECK_THAT(sampler_bench_table(bench), Catch::Contains("no-rejection"));
}

TEST_CASE("a ratio meets its limit from the right side") {
  CHECK(SamplerRatio{"", 2, 3, true}.met());
  CHECK_FALSE(SamplerRatio{"", 4, 3, true}.met());
  CHECK(SamplerRatio{"", 4, 3, false}.met());
  CHECK_FALSE(SamplerRatio{"", 2, 3, false}.met());
  CHECK(SamplerRatio{"", 2, std::nullopt, false}.met());
}

TEST_CASE("the straight-line limit begins as the sampler does and stays finite") {
  const Lattice lattice({130, 200});
  for (const double mu : {0.1, 0.3, 0.8, 1.3}) {
    Pile straight(lattice), drawn(lattice);
    StraightLine(mu, lattice).fill(1, 5, straight);
    const std::vector<double> load(130, 1.0);
    REQUIRE_FALSE(make_sampler({.mu = mu, .seed = 1, .model = {}}, lattice)->draw(5, load, drawn));
    // No bead of the top layer fails; what repairs below changed there are splits, not vertical forces.
    for (std::size_t i = 0; i < 130; ++i) {
      CHECK(straight.V_R[i] == drawn.V_R[i]);
      CHECK(straight.V_L[i] == drawn.V_L[i]);
    }
    for (std::size_t i = 0; i < lattice.beads(); ++i) REQUIRE(std::isfinite(straight.H_R[i]));
  }
}

namespace {

/// What this process holds; a child begins with it.
double resident_bytes() {
  std::ifstream pages("/proc/self/statm");
  double all = 0, resident = 0;
  pages >> all >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

}  // namespace

TEST_CASE("an ensemble of 3461 piles of 500 x 200 beads stays below 200 MB with two threads", "[long]") {
  const double before = resident_bytes();
  const EnsembleMemory memory = measure_ensemble_memory(2);
  CHECK(before > 1e6);
  CHECK(memory.samples == 3461);
  CHECK(memory.peak_bytes > 10e6);
  // Sanitizers hold more.
#if !defined(__SANITIZE_ADDRESS__)
  CHECK(memory.peak_bytes - before < 200e6);
#endif
}
