#include "report/fixture.h"

#include <cmath>
#include <string>

#include "plot/depth_figures.h"
#include "plot/main_finding.h"
#include "plot/scaling_figures.h"
#include "plot/synthetic_analysis.h"
#include "support/files.h"
#include "support/process.h"

namespace granuscope::synthetic {

namespace {

/// A raster picture in the place of the rendered force chains; gnuplot writes PNG too.
Figure raster_picture(const std::filesystem::path& run_folder) {
  make_folder(run_folder / "figures");
  ProcessSpec process;
  process.arguments = {"gnuplot", "-d", "-e",
                       "set terminal pngcairo size 800,700; set output 'force-chains.png'; unset key; "
                       "plot [-35:35] [60:0] abs(x) / 0.57 with lines lw 6 lc rgb '#444444'"};
  process.working_folder = run_folder / "figures";
  process.environment = {{"LC_ALL", "C.UTF-8"}};
  run_process(process);
  Figure figure;
  figure.id = "force-chains";
  figure.title = "Force chains under a point load";
  figure.caption =
      "Contact forces of one pile of 70 × 60 beads at μ = 0.1 under a point load (sample 0). Wider and darker lines "
      "carry "
      "more force.";
  figure.alternative = "Two oblique dark lines run down from the overloaded bead, to the left and to the right.";
  figure.paper_says = "Fig. 1 (right) of the paper: the forces due to a localised overload form two oblique branches.";
  figure.screen = figure.print = "figures/force-chains.png";
  figure.redraw = "granuscope render piles/force-chains.h5 --image figures/force-chains.png --width 800 --dpi 300";
  return figure;
}

constexpr const char* experiment = R"([experiment]
name = "synthetic"
description = "made up for tests"

[lattice]
columns = 500
layers = 200

[friction]
mu = [0.0, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6]

[sampling]
law = "granusolve"
seed = 20020604
effort = 200.0
max_tries = 1000000

[response]
estimator = "point"
overload = 1.0
samples = 3456
blocks = 32

[fit]
first_layer = 58
last_layer = 179
layer_step = 3
shallow_layer = 16
min_identifiable_width = 0.5
scaling_window = [0.1, 0.3]
other_scaling_windows = [[0.15, 0.6]]
)";

}  // namespace

ReportData report_data(const std::filesystem::path& run_folder) {
  ReportData data;
  data.experiment_name = "Synthetic numbers for tests";
  data.description = "Nothing here was computed from a pile: the page is laid out with made-up numbers.";
  data.columns = 500;
  data.layers = 200;
  data.seed = 20020604;
  data.overload = 1;
  data.resolved_experiment = experiment;
  data.resolved_experiment_key = "00112233445566aa";
  data.law_description = {
      "Layer by layer from the top, each bead draws H_R uniformly from its admissible interval.",
      "Each layer starts at a random bead and runs in a random direction.",
      "A bead whose interval is empty makes its two parents draw again, jointly, within what their other children "
      "allow; "
      "if nothing is left, an arc of parents, then the ring, then its ancestors.",
  };
  data.analysis = analysis();
  data.figures.push_back(raster_picture(run_folder));
  data.studies["numerical_stability"] = nlohmann::ordered_json::parse(R"([
    {"mu": 1.73, "columns": 64, "layers": 60, "load": "half of the beads unloaded", "outcome": "solved",
     "residual": 3.2e-15, "rounded_per_bead": 0.00012, "depths": []},
    {"mu": 0.001, "columns": 64, "layers": 60, "load": "half of the beads unloaded", "outcome": "refused",
     "reason": "there is no load on top bead 0"}])");
  data.parts.push_back({.page = "studies/numerical_stability.html",
                        .base = "/studies",
                        .needs = "numerical_stability",
                        .place = ReportPart::Place::numerics});
  data.studies["law_comparison"]["laws"] = nlohmann::ordered_json::parse(R"([
    {"law": "granusolve", "repair_rules": "all", "mu": 0.3, "columns": 12, "layers": 30, "samples": 512, "failed": 0,
     "effective_samples": {"value": 500, "stderr": 120}, "draws_per_bead": 1.25, "pair_per_bead": 0.125,
     "arc_per_bead": 0, "backtracked_per_bead": 0, "window_layers": [0, 0],
     "alpha_thrust": {"value": 0.93, "stderr": 0.001}, "c_thrust": {"value": 0.557, "stderr": 0.0003},
     "weight_variance": {"value": 0.157, "stderr": 0.0013}, "depths": []},
    {"law": "polytope", "lambda": 1, "burn_in": 4000, "thinning": 500, "mu": 0.3, "columns": 12, "layers": 30,
     "samples": 512, "failed": 3, "effective_samples": {"value": 500, "stderr": 120}, "draws_per_bead": 1.25,
     "pair_per_bead": 0.125, "arc_per_bead": 0, "backtracked_per_bead": 0, "window_layers": [0, 0],
     "alpha_thrust": {"value": 0.93, "stderr": 0.001}, "c_thrust": {"value": 0.557, "stderr": 0.0003},
     "weight_variance": {"value": 0.157, "stderr": 0.0013}, "depths": []}])");
  data.parts.push_back({.page = "studies/law_comparison.html",
                        .base = "/studies/law_comparison",
                        .needs = "laws",
                        .overlay = nlohmann::ordered_json::parse(R"({
         "chains": [{"key": "/studies/law_comparison/laws/1", "last": true}]})")});
  data.studies["law_comparison"]["responses"] = nlohmann::ordered_json::parse(R"([
    {"law": "polytope", "lambda": 0, "burn_in": 20000, "thinning": 2000, "mu": 0.3, "columns": 0, "layers": 0,
     "epsilon": 0.5, "samples": 0, "failed": 0,
     "effective_samples": {"value": null, "stderr": null, "reason": "made up"}, "window_layers": [4, 6],
     "c": {"value": 0.46, "stderr": 0.01}, "D": {"value": null, "stderr": null, "reason": "made up"}}])");
  data.parts.push_back(
      {.page = "studies/law_responses.html",
       .base = "/studies/law_comparison",
       .needs = "responses",
       .overlay = nlohmann::ordered_json::parse(R"({"responses": [{"c_apart": "–", "D_apart": "–"}]})")});
  data.analysis.results[2].chained = true;
  data.analysis.results[2].burn_in = 800;
  data.analysis.results[2].thinning = 100;
  data.analysis.results[2].effective_samples = {300, 70, ""};
  data.figures.insert(data.figures.begin(), plot_main_finding(data.analysis, run_folder));
  data.key_figure = main_finding_id;
  data.figures.push_back(plot_response_profiles(data.analysis.results, {}, run_folder));
  data.figures.push_back(plot_transport_with_depth(data.analysis, {}, run_folder));
  data.figures.push_back(plot_propagation_against_diffusion(data.analysis, run_folder));
  data.figures.push_back(plot_scaling_with_friction(data.analysis, run_folder));
  data.provenance.program_version = "granuscope 0.0.0";
  data.provenance.git_commit = std::string(40, 'a');
  data.provenance.git_dirty = true;
  data.provenance.compiler = "g++ 12.2.0";
  data.provenance.compiler_flags =
      "-O2 -DNDEBUG -ffp-contract=off -march=x86-64-v2 -Wall -Wextra -Wconversion -Wshadow -Werror";
  data.provenance.build_type = "Release";
  data.provenance.libraries = {{"HDF5", "1.10.8"},   {"GSL", "2.7.1"},       {"Eigen", "3.4.0"},  {"fmt", "9.1.0"},
                               {"libpng", "1.6.39"}, {"FreeType", "2.12.1"}, {"Highway", "1.0.3"}};
  data.provenance.host_cpu = "a processor";
  data.provenance.operating_system = "an operating system";
  data.provenance.hardware_threads = 2;
  data.environment = {{"OpenGL renderer", "llvmpipe"}, {"gnuplot", "5.4"}, {"WeasyPrint", "57.2"}};
  data.timings = {{"ensemble μ = 0", 0.4, true}, {"ensemble μ = 0.1", 9.1, false}, {"report", 2.4, false}};
  for (Transport& result : data.analysis.results) {
    if (result.exact) continue;
    result.profiles.clear();
    for (const DepthFit& fit : result.depths) result.profiles.push_back(profile_at(fit.layer, result.c.value, 0.05, 1));
  }
  data.skipped = {"Layers deeper than 199 were not computed, because no figure or fit asks for them."};
  return data;
}

std::string hostile_text() {
  return "<script>alert(1)</script> {{x}} {{{y}}} {{#z}} \"double\" 'single' `rm -rf /` $(id) & &amp;\nsecond line | "
         "[a](b) \xff\xfe \xc3( \xed\xa0\x80 \x01 --> ]]>";
}

}  // namespace granuscope::synthetic
