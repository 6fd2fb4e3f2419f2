#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/bead_forces.h"
#include "plot/depth_figures.h"
#include "plot/figure_captions.h"
#include "plot/plot.h"
#include "plot/plot_texts.h"
#include "plot/scaling_figures.h"
#include "plot/synthetic_analysis.h"
#include "sampling/sampler.h"
#include "support/error.h"
#include "support/files.h"
#include "support/process.h"

using namespace granuscope;
using test::contains;
using test::TemporaryFolder;

namespace {

/// Every figure comes with all its files, captions, and a command that makes the same bytes again.
void check_whole(const Figure& figure, const std::filesystem::path& run_folder) {
  INFO(figure.id);
  CHECK_FALSE(figure.title.empty());
  CHECK_FALSE(figure.caption.empty());
  CHECK_FALSE(figure.alternative.empty());
  CHECK(contains(figure.paper_says, "of the paper"));
  CHECK_FALSE(contains(figure.details, "{{"));
  CHECK_FALSE(contains(figure.details, " ."));
  CHECK_FALSE(contains(figure.details, "nan"));
  REQUIRE_FALSE(figure.data.empty());
  for (const auto& file : figure.data) {
    INFO(file);
    REQUIRE(std::filesystem::exists(run_folder / file));
    // Names, then a unit of each, then numbers.
    std::stringstream csv(read_file(run_folder / file));
    std::string names, units, numbers;
    std::getline(csv, names);
    std::getline(csv, units);
    std::getline(csv, numbers);
    CHECK(std::count(names.begin(), names.end(), ',') == std::count(units.begin(), units.end(), ','));
    CHECK(units.starts_with('#'));
    CHECK((contains(units, "bead diameter") || contains(units, "dimensionless")));
    CHECK((std::isdigit(static_cast<unsigned char>(numbers.back())) != 0 || numbers.ends_with("NaN")));
  }
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
  // But for the label, which gnuplot does not know.
  const auto drawn = [](const std::string& plot) { return plot.substr(plot.find("</desc>")); };
  CHECK((drawn(read_file(run_folder / figure.screen)) == drawn(svg)));
}

}  // namespace

TEST_CASE("The response profiles explain the paper's depths") {
  const TemporaryFolder run;
  const Analysis analysis = synthetic::analysis();
  const Figure figure = plot_response_profiles(analysis.results, {}, run.path());
  check_whole(figure, run.path());
  CHECK(figure.data.size() == 2);
  CHECK(contains(figure.details, "z = 95.8 (layer 110, 90 layers above the bottom)"));
  CHECK(contains(figure.details, "z = 147.7 (layer 170, 30 layers above the bottom)"));
  CHECK(contains(figure.details, "opposite order"));
  const std::string svg = read_file(run.path() / figure.screen);
  CHECK(contains(svg, "position x  (bead diameters)"));
  CHECK(contains(svg, "response P(x)"));
  CHECK(contains(svg, "χ²/dof = "));
  CHECK(contains(svg, "residual / σ"));
  const std::string csv = read_file(run.path() / "figures/response-profiles-layer-110.csv");
  CHECK(csv.starts_with("x,P,standard_error,fit,residual_in_standard_errors\n#bead diameters,1/bead diameter,"));
}

TEST_CASE("Many depths are shown without close views") {
  const TemporaryFolder run;
  Analysis analysis = synthetic::analysis();
  for (Transport& result : analysis.results) {
    if (result.profiles.empty()) continue;
    result.profiles.push_back(result.profiles.front());
    result.profiles.back().layer = 140;
  }
  ResponseProfilesSpec spec;
  spec.layers = {110, 140, 170};
  const Figure figure = plot_response_profiles(analysis.results, spec, run.path());
  check_whole(figure, run.path());
  CHECK(figure.data.size() == 3);
  CHECK_FALSE(contains(read_file(run.path() / figure.screen), "residual"));
}

TEST_CASE("Where a profile is missing the nearest one is plotted and the caption says so") {
  const TemporaryFolder run;
  const Analysis analysis = synthetic::analysis();
  ResponseProfilesSpec spec;
  spec.mu = 0.33;
  spec.layers = {112};
  spec.layers_computed = 220;
  const Figure figure = plot_response_profiles(analysis.results, spec, run.path());
  check_whole(figure, run.path());
  CHECK(contains(figure.details, "the nearest measured value to μ = 0.33"));
  CHECK(contains(figure.details, "Layer 112 was not measured; the nearest one, 110, stands for it"));
  CHECK_FALSE(contains(figure.details, "opposite order"));
}

TEST_CASE("A profile without a fit is plotted without one") {
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
  const Figure figure = plot_response_profiles(analysis.results, {}, run.path());
  check_whole(figure, run.path());
  CHECK(contains(figure.details, "layer 170"));
  CHECK(contains(figure.caption, "has two peaks. Thin"));
  CHECK(contains(figure.caption, "Not fitted: layer 170."));
  CHECK(contains(read_file(run.path() / figure.screen), "peaks not identified by the fit"));
}

TEST_CASE("An exact profile is plotted without a fit, whatever width rounding gave it") {
  const TemporaryFolder run;
  Analysis analysis = synthetic::analysis();
  for (Transport& result : analysis.results) {
    for (ResponseProfile& profile : result.profiles) {
      std::fill(profile.standard_error.begin(), profile.standard_error.end(), 0.0);
    }
  }
  check_whole(plot_response_profiles(analysis.results, {}, run.path()), run.path());
}

TEST_CASE("Transport with depth shows ratios and lines") {
  const TemporaryFolder run;
  const Analysis analysis = synthetic::analysis();
  const Figure figure = plot_transport_with_depth(analysis, {}, run.path());
  check_whole(figure, run.path());
  const std::string svg = read_file(run.path() / figure.screen);
  for (const char* label : {"depth z  (bead diameters)", "xₚ/z", "W²/z", "xₚ − c₀ z", ">W²<", "c from thrust"}) {
    INFO(label);
    CHECK(contains(svg, label));
  }
}

TEST_CASE("Where no slope is known the scaling shows none") {
  const TemporaryFolder run;
  Analysis analysis = synthetic::analysis();
  Transport& last = analysis.results.back();
  last.spec.sampler.mu = 1.7;
  last.c = last.D = synthetic::unknown("the noise leaves open whether there are two peaks");
  last.c_thrust = synthetic::known(0.9033, 0.0004);
  plot_scaling_with_friction(analysis, run.path());
  for (const char* part : {"D-of-mu-slopes", "D-of-mu-slopes-outside"}) {
    const std::filesystem::path file = run.path() / fmt::format("figures/scaling-with-friction-{}.csv", part);
    if (std::filesystem::exists(file)) CHECK_FALSE(contains(read_file(file), "\n1.7,"));
  }
}

TEST_CASE("Points too far from their law for the narrow panel are arrows at its edge, and named") {
  const TemporaryFolder run;
  Analysis analysis = synthetic::analysis();
  for (Transport& result : analysis.results) {
    if (result.scanned() == 0.4) result.c.value = 0.5770;  // c₀ − c a hundred times too small for its D
  }
  const Figure figure = plot_propagation_against_diffusion(analysis, run.path());
  CHECK(contains(figure.details, "too far from the fit for it, μ = 0.4."));
  CHECK(contains(read_file(run.path() / figure.script), ", graph 0.3 to first "));
  for (Transport& result : analysis.results) {
    if (result.scanned() == 0.3) result.D.value = 0.01;
  }
  CHECK(contains(plot_scaling_with_friction(analysis, run.path()).details, "too far from the fit, μ = 0.3."));
}

TEST_CASE("Deep peaks far out keep their names inside the frame") {
  const TemporaryFolder run;
  Analysis analysis = synthetic::analysis();
  for (Transport& result : analysis.results) {
    for (DepthFit& fit : result.depths) {
      if (fit.layer == 170) {
        fit.peak_position.value = 200;
        fit.width.value = 0.6;
      }
    }
  }
  plot_response_profiles(analysis.results, {}, run.path());
  CHECK(contains(read_file(run.path() / "figures/response-profiles.gp"), "set xrange [-220:220]"));
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
  const Figure depth = plot_transport_with_depth(analysis, {}, run.path());
  check_whole(depth, run.path());
  CHECK(contains(depth.details, "The slope c is unknown: too few depths."));
  CHECK(contains(depth.caption, "too few depths give a slope"));
  CHECK_FALSE(contains(depth.caption, "1/z"));
  CHECK_FALSE(contains(read_file(run.path() / depth.screen), "fitted:"));
  CHECK_THROWS_AS(plot_propagation_against_diffusion(analysis, run.path()), InputError);
  analysis.results[1].c = {0.57, 0.001, ""};
  analysis.results[1].D = {0.004, 0.01, ""};  // its bar reaches 0, which has no place on the axis
  const Figure against = plot_propagation_against_diffusion(analysis, run.path());
  check_whole(against, run.path());
  CHECK_FALSE(contains(against.details, "α = 0"));
  CHECK_FALSE(contains(against.alternative, "c falls"));
}

TEST_CASE("Five values of something have five blues, each clearly darker than the one before") {
  const TemplateVariables colours = plot_colours();
  double before = 100;
  for (std::size_t i = 0; i < 5; ++i) {
    const std::string hex = colours.at(ink_of_value(i).colour);
    INFO(i << ": " << hex);
    double luminance = 0;  // of sRGB, roughly
    for (std::size_t c = 0; c < 3; ++c) {
      const double share = std::stoi(hex.substr(1 + 2 * c, 2), nullptr, 16) / 255.0;
      luminance += std::array{0.2126, 0.7152, 0.0722}[c] * std::pow(share, 2.2);
    }
    const double lightness = 116 * std::cbrt(luminance) - 16;  // of CIE L*, where 2 is just noticed
    CHECK(lightness < before - 10);
    CHECK(lightness < 75);
    before = lightness;
  }
}

TEST_CASE("c against D shows the fit, both kinds of points, and names every point once") {
  const TemporaryFolder run;
  const Analysis analysis = synthetic::analysis();
  const Figure figure = plot_propagation_against_diffusion(analysis, run.path());
  check_whole(figure, run.path());
  CHECK(contains(figure.details, "μ = 0 (exact)"));
  CHECK(contains(figure.details, "μ = 0.6"));
  CHECK(contains(figure.details, "α = 0.688(43)"));
  CHECK(contains(figure.alternative, "c falls with the diffusion coefficient D"));
  const std::string svg = read_file(run.path() / figure.screen), script = read_file(run.path() / figure.script);
  for (const char* label : {"diffusion coefficient D  (bead diameters)", "propagation coefficient c", "data / fit",
                            "c₀ = tan 30°", "slopes: α = 0.688(43)"}) {
    INFO(label);
    CHECK(contains(svg, label));
  }
  for (const char* mu : {"0.1", "0.15", "0.2", "0.3", "0.4"}) {  // at 0.6 D is unknown
    INFO(mu);
    CHECK(test::count(script, "set label '" + std::string(mu) + "' at graph") == 1);
  }
}

TEST_CASE("The scaling with friction shows slopes beside what is read at one depth, each with its exponent") {
  const TemporaryFolder run;
  const Analysis analysis = synthetic::analysis();
  const Figure figure = plot_scaling_with_friction(analysis, run.path());
  check_whole(figure, run.path());
  CHECK(contains(figure.details, "β = 2.538(81)"));
  CHECK(contains(figure.details, "at z = 95.8, with β = 2.790(70)"));
  const std::string svg = read_file(run.path() / figure.screen);
  for (const char* label :
       {"slopes: β = 2.538(81)", "at z = 95.8: β = 2.790(70)", "the paper: β ≈ 2.5", "data / fit"}) {
    INFO(label);
    CHECK(contains(svg, label));
  }
  const std::string csv = read_file(run.path() / "figures/scaling-with-friction-D-of-mu-at_one_depth.csv");
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 2 + 4);  // of mu = 0.1 to 0.3
}

TEST_CASE("The scaling with friction can do without readings and without laws") {
  const TemporaryFolder run;
  Analysis analysis = synthetic::analysis();
  analysis.readings.clear();
  analysis.scaling.beta.exponent = analysis.scaling.gamma.exponent = synthetic::unknown("too few points");
  analysis.results.erase(analysis.results.begin() + 2, analysis.results.end());  // mu = 0 and 0.1
  const Figure figure = plot_scaling_with_friction(analysis, run.path());
  check_whole(figure, run.path());
  CHECK(contains(figure.details, "β = unknown (too few points)"));
  CHECK_FALSE(contains(figure.details, "Diamonds"));
}

TEST_CASE("The two speeds stand beside their difference") {
  const TemporaryFolder run;
  const Figure figure = plot_propagation_and_thrust(synthetic::analysis(), run.path());
  check_whole(figure, run.path());
  CHECK(contains(figure.details, "by more than three standard errors at μ = 0.3, 0.4 and 0.6"));
}

namespace {

/// The rows of a CSV file below its heading.
std::vector<std::vector<double>> rows_of(const std::filesystem::path& file) {
  std::stringstream lines(read_file(file));
  std::string line;
  std::getline(lines, line);
  std::getline(lines, line);  // units
  std::vector<std::vector<double>> rows;
  while (std::getline(lines, line)) {
    rows.emplace_back();
    std::stringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

}  // namespace

TEST_CASE("One bead's forces balance and stay inside their cones") {
  const TemporaryFolder run;
  SamplerSpec spec;
  spec.mu = 0.3;
  spec.seed = 7;
  const Lattice lattice({40, 50});
  Pile pile(lattice);
  const std::vector<double> load(40, 1.0);
  REQUIRE_FALSE(make_sampler(spec, lattice)->draw(3, load, pile));
  const Figure figure = plot_bead_forces(pile, {}, run.path());
  check_whole(figure, run.path());
  CHECK(contains(figure.details, "16.7°"));
  CHECK(contains(figure.details, "sample 3 of seed 7"));
  const auto rows = rows_of(run.path() / "figures/bead-forces-contacts.csv");
  REQUIRE(rows.size() == 4);
  double fx = 0, fz = 0, torque = 0;
  for (const auto& row : rows) {
    fx += row[3];
    fz += row[4];
    torque += row[6];
    CHECK(std::abs(row[6]) <= 0.3 * row[5] * (1 + 1e-12));
    CHECK(std::hypot(row[3], row[4]) == Approx(std::hypot(row[5], row[6])));
    // The normal part presses towards the middle of the bead, which lies half a diameter from each contact.
    CHECK(-2 * (row[3] * row[1] + row[4] * row[2]) == Approx(row[5]));
    CHECK(std::hypot(row[1], row[2]) == Approx(0.5));
  }
  CHECK(std::abs(fx) < 1e-12);
  CHECK(std::abs(fz) < 1e-12);
  CHECK(std::abs(torque) < 1e-12);
  const std::string svg = read_file(run.path() / figure.screen);
  for (const char* label : {"θ₁", "θ₄", "normal force N", "tangential force T"}) CHECK(contains(svg, label));
  CHECK_THROWS_AS(plot_bead_forces(pile, {50}, run.path()), InputError);
}

TEST_CASE("Without friction a bead's forces lie along its contacts") {
  const TemporaryFolder run;
  Pile pile(Lattice({10, 24}));
  for (std::size_t k = 0; k < pile.lattice.beads(); ++k) {
    pile.V_R[k] = pile.V_L[k] = 0.5;
    pile.H_R[k] = 0.5 * tan30;
    pile.H_L[k] = -0.5 * tan30;
  }
  check_whole(plot_bead_forces(pile, {}, run.path()), run.path());
  for (const auto& row : rows_of(run.path() / "figures/bead-forces-contacts.csv")) CHECK(std::abs(row[7]) < 1e-12);
}

TEST_CASE("A figure with nothing to show says so") {
  const TemporaryFolder run;
  CHECK_THROWS_AS(plot_response_profiles({}, {}, run.path()), InputError);
  CHECK_THROWS_AS(plot_transport_with_depth({}, {}, run.path()), InputError);
  CHECK_THROWS_AS(plot_propagation_against_diffusion({}, run.path()), InputError);
  CHECK_THROWS_AS(plot_scaling_with_friction({}, run.path()), InputError);
  CHECK_THROWS_AS(plot_propagation_and_thrust({}, run.path()), InputError);
}

TEST_CASE("The frictionless pile alone can still be plotted") {
  const TemporaryFolder run;
  Analysis analysis;
  analysis.results.push_back(synthetic::frictionless());
  for (DepthFit& fit : analysis.results[0].depths) fit.identifiable = true;
  check_whole(plot_transport_with_depth(analysis, {}, run.path()), run.path());
  CHECK_THROWS_AS(plot_propagation_against_diffusion(analysis, run.path()), InputError);  // its D is no power of ten
  check_whole(plot_propagation_and_thrust(analysis, run.path()), run.path());
}

TEST_CASE("What is left out for the same reason is said once") {
  CHECK(with_reasons({}).empty());
  CHECK(with_reasons({{"a", "x"}, {"b", "y"}, {"c", "x"}}) == "a and c (x) and b (y)");
}
