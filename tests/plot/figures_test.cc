#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "plot/propagation_against_diffusion.h"
#include "plot/response_profiles.h"
#include "plot/synthetic_analysis.h"
#include "plot/temporary_folder.h"
#include "plot/transport_with_depth.h"
#include "support/atomic_file.h"
#include "support/child_process.h"
#include "support/error.h"

using namespace granuscope;
using synthetic::TemporaryFolder;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Every figure comes with all its files, words, and a command that draws the same bytes again.
void check_whole(const Figure& figure, const std::filesystem::path& run_folder) {
  INFO(figure.id);
  CHECK_FALSE(figure.title.empty());
  CHECK_FALSE(figure.caption.empty());
  CHECK_FALSE(figure.alternative.empty());
  CHECK(contains(figure.paper_says, "of the paper"));
  CHECK_FALSE(contains(figure.caption, "{{"));
  CHECK_FALSE(contains(figure.caption, " ."));
  CHECK_FALSE(contains(figure.caption, "nan"));
  REQUIRE_FALSE(figure.data.empty());
  for (const auto& file : figure.data) CHECK(std::filesystem::exists(run_folder / file));
  CHECK(figure.redraw == "cd figures && gnuplot -d " + figure.script.filename().string());

  const std::string svg = read_file(run_folder / figure.screen);
  const std::string script = read_file(run_folder / figure.script);
  CHECK_FALSE(contains(script, run_folder.string()));
  std::filesystem::remove(run_folder / figure.screen);
  ProcessSpec process;
  process.arguments = {"gnuplot", "-d", figure.script.filename().string()};
  process.working_folder = run_folder / "figures";
  process.environment = {{"LC_ALL", "C.UTF-8"}};
  const ProcessResult result = run_process(process);
  CHECK(result.exit_code == 0);
  CHECK(result.standard_error.empty());
  CHECK(read_file(run_folder / figure.screen) == svg);
}

}  // namespace

TEST_CASE("The response profiles explain the paper's depths") {
  const TemporaryFolder run;
  const Analysis analysis = synthetic::analysis();
  const Figure figure = draw_response_profiles(analysis.results, {}, run.path());
  check_whole(figure, run.path());
  CHECK(figure.data.size() == 2);
  CHECK(contains(figure.caption, "z = 95.8 (layer 110, 90 layers above the bottom)"));
  CHECK(contains(figure.caption, "z = 147.7 (layer 170, 30 layers above the bottom)"));
  CHECK(contains(figure.caption, "opposite order"));
  const std::string svg = read_file(run.path() / figure.screen);
  CHECK(contains(svg, "position x  (bead diameters)"));
  CHECK(contains(svg, "response P(x)  per unit overload"));
}

TEST_CASE("Where a profile is missing the nearest one is drawn and the caption says so") {
  const TemporaryFolder run;
  const Analysis analysis = synthetic::analysis();
  ResponseProfilesSpec spec;
  spec.mu = 0.33;
  spec.layers = {112};
  spec.layers_computed = 220;
  const Figure figure = draw_response_profiles(analysis.results, spec, run.path());
  check_whole(figure, run.path());
  CHECK(contains(figure.caption, "the nearest measured value to μ = 0.33"));
  CHECK(contains(figure.caption, "Layer 112 was not measured; the nearest one, 110, stands for it"));
  CHECK_FALSE(contains(figure.caption, "opposite order"));
  CHECK(contains(figure.title, "one depth"));
}

TEST_CASE("A profile without a fit is drawn without one") {
  const TemporaryFolder run;
  Analysis analysis = synthetic::analysis();
  for (Transport& result : analysis.results) {
    for (ResponseProfile& profile : result.profiles) {
      if (profile.layer == 170) std::fill(profile.fit.begin(), profile.fit.end(), std::nan(""));
    }
    for (DepthFit& fit : result.depths) {
      if (fit.layer == 170) fit.identifiable = false;
    }
  }
  const Figure figure = draw_response_profiles(analysis.results, {}, run.path());
  check_whole(figure, run.path());
  CHECK(contains(figure.caption, "layer 170"));
  CHECK(contains(read_file(run.path() / figure.screen), "peaks not identified by the fit"));
}

TEST_CASE("Transport with depth shows slopes, window, insets, and names what it leaves out") {
  const TemporaryFolder run;
  const Analysis analysis = synthetic::analysis();
  const Figure figure = draw_transport_with_depth(analysis, {}, run.path());
  check_whole(figure, run.path());
  CHECK(contains(figure.caption, "μ = 0 (exact)"));
  CHECK(contains(figure.caption, "D at μ = 0.6 (the widths at 7 of 41 depths are not identified)"));
  const std::string svg = read_file(run.path() / figure.screen);
  for (const char* label : {"depth z  (bead diameters)", "peak position over depth  xₚ/z",
                            "squared width over depth  W²/z", "friction coefficient μ", "left inset: c from thrust"}) {
    INFO(label);
    CHECK(contains(svg, label));
  }
  // The exact point stands in the linear inset and not on logarithmic axes.
  CHECK(contains(read_file(run.path() / "figures/transport-with-depth-c-of-mu.csv"), "\n0,0.577"));
  CHECK_FALSE(contains(read_file(run.path() / "figures/transport-with-depth-D-of-mu-inside.csv"), "\n0,"));
  CHECK(contains(read_file(run.path() / "figures/transport-with-depth-D-of-mu-outside.csv"), "\n0.4,"));
}

TEST_CASE("Unknown slopes and exponents leave their curves out with a reason") {
  const TemporaryFolder run;
  Analysis analysis = synthetic::analysis();
  for (Transport& result : analysis.results) {
    if (result.exact) continue;
    result.c = synthetic::unknown("too few depths");
    result.D = synthetic::unknown("too few depths");
  }
  analysis.scaling.beta.exponent = analysis.scaling.gamma.exponent = analysis.scaling.alpha.exponent =
      synthetic::unknown("too few points");
  const Figure depth = draw_transport_with_depth(analysis, {}, run.path());
  check_whole(depth, run.path());
  CHECK(contains(depth.caption, "The slope c is unknown: too few depths."));
  const Figure against = draw_propagation_against_diffusion(analysis, run.path());
  check_whole(against, run.path());
  CHECK_FALSE(contains(against.caption, "Inset"));
}

TEST_CASE("c against D shows the fit, the paper's exponent, and both kinds of points") {
  const TemporaryFolder run;
  const Analysis analysis = synthetic::analysis();
  const Figure figure = draw_propagation_against_diffusion(analysis, run.path());
  check_whole(figure, run.path());
  CHECK(contains(figure.caption, "μ = 0 (exact)"));
  CHECK(contains(figure.caption, "μ = 0.6"));
  const std::string svg = read_file(run.path() / figure.screen);
  for (const char* label : {"diffusion coefficient D  (bead diameters)", "propagation coefficient c", "c₀ − c",
                            "inset: exponent 0.4 of the paper", "inset: outside the window"}) {
    INFO(label);
    CHECK(contains(svg, label));
  }
}

TEST_CASE("A figure with nothing to show says so") {
  const TemporaryFolder run;
  CHECK_THROWS_AS(draw_response_profiles({}, {}, run.path()), InputError);
  CHECK_THROWS_AS(draw_transport_with_depth({}, {}, run.path()), InputError);
  CHECK_THROWS_AS(draw_propagation_against_diffusion({}, run.path()), InputError);
}

TEST_CASE("The frictionless pile alone can still be drawn") {
  const TemporaryFolder run;
  Analysis analysis;
  analysis.results.push_back(synthetic::frictionless());
  for (DepthFit& fit : analysis.results[0].depths) fit.identifiable = true;
  check_whole(draw_transport_with_depth(analysis, {}, run.path()), run.path());
  check_whole(draw_propagation_against_diffusion(analysis, run.path()), run.path());
}
