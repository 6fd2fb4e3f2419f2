#include "plot/power_law_panel.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "kit/temporary_folder.h"
#include "plot/depth_figures.h"
#include "plot/main_finding.h"
#include "plot/scaling_figures.h"
#include "plot/synthetic_analysis.h"
#include "support/files.h"

using namespace granuscope;
using test::TemporaryFolder;

namespace {

Analysis analysis_over(std::array<double, 2> window) {
  Analysis analysis = synthetic::analysis();
  analysis.scaling = synthetic::scaling(window);
  for (OtherReading& reading : analysis.readings) reading.fits = synthetic::scaling(window);
  return analysis;
}

/// The exponent of each dotted triangle of a script: its longest side is a line on logarithmic axes.
std::vector<double> triangle_exponents(const std::string& script) {
  std::vector<double> exponents;
  const auto decades = [&](std::size_t at, const std::string& axis) {
    double low = 0, high = 0;
    const std::size_t range = script.rfind("set " + axis + "range [", at);
    REQUIRE(std::sscanf(script.c_str() + range + 12, "%lf:%lf", &low, &high) == 2);
    return std::log(high / low);
  };
  const std::string side = "set arrow from graph ", longest = "nohead linewidth 1.6 dashtype 3";
  for (std::size_t at = script.find(side); at != std::string::npos; at = script.find(side, at + 1)) {
    if (script.substr(0, script.find('\n', at)).find(longest, at) == std::string::npos) continue;
    double x = 0, y = 0, to_x = 0, to_y = 0;
    REQUIRE(std::sscanf(script.c_str() + at + side.size(), "%lf, graph %lf to graph %lf, graph %lf", &x, &y, &to_x,
                        &to_y) == 4);
    exponents.push_back((to_y - y) * decades(at, "y") / ((to_x - x) * decades(at, "x")));
  }
  return exponents;
}

}  // namespace

TEST_CASE("The middle of a window is that of its points on logarithmic axes") {
  const std::vector<PowerLawPoint> points = {
      {0, 0, 0, 5, 0}, {0.1, 1, 0, 2, 0}, {0.2, 4, 0, 8, 0}, {0.2, 4, 0, -1, 0}, {0.9, 100, 0, 100, 0}};
  const WindowMiddle middle = middle_of_window(points, {0, 0.3});
  CHECK(middle.x == Approx(2));
  CHECK(middle.y == Approx(4));
  CHECK(middle.extent.low == 1);
  CHECK(middle.extent.high == 4);
  CHECK(middle_of_window(points, {0.4, 0.5}).extent.empty);
  CHECK(middle_of_window(points, {0, 0.05}).extent.empty);  // what is at zero has no place there
}

TEST_CASE("A window from zero or far beyond the points leaves every curve of the figures against friction visible") {
  for (const std::array<double, 2> window : {std::array<double, 2>{0, 1.73}, {0, 1e6}, {0.1, 1e9}, {1e-12, 0.3}}) {
    CAPTURE(window[0], window[1]);
    const TemporaryFolder run;
    const Analysis analysis = analysis_over(window);
    CHECK_NOTHROW(plot_transport_with_depth(analysis, {}, run.path()));
    CHECK_NOTHROW(plot_scaling_with_friction(analysis, run.path()));
    CHECK_NOTHROW(plot_propagation_against_diffusion(analysis, run.path()));
  }
}

TEST_CASE("The slope of each of the paper's exponents stands once, as a triangle at no height of its own") {
  for (const double low : {0.0, 0.1}) {
    CAPTURE(low);
    const TemporaryFolder run;
    const Analysis analysis = analysis_over({low, 0.3});
    const auto exponents = [&](const Figure& figure) {
      return triangle_exponents(read_file(run.path() / figure.script));
    };
    const std::vector<double> main = exponents(plot_main_finding(analysis, run.path()));
    REQUIRE(main.size() == 2);
    CHECK(main[0] == Approx(1));
    CHECK(main[1] == Approx(0.4));
    const std::vector<double> diffusion = exponents(plot_scaling_with_friction(analysis, run.path()));
    REQUIRE(diffusion.size() == 1);
    CHECK(diffusion[0] == Approx(2.5));
    CHECK(exponents(plot_propagation_against_diffusion(analysis, run.path())).empty());
  }
}

TEST_CASE("A triangle keeps off points, lines and texts, and lies near them rather than far away") {
  LabelledPanel panel{2.7, 2.1, {{{0.1, 0.1}, {0.9, 0.9}}}, {}};
  panel.add_text("slopes: γ = 1.65 (χ² 30/2)", 0.98, 0.07);
  const SlopeTriangle triangle = place_slope_triangle(0.5, "the paper: γ = 1", panel);
  CHECK((triangle.high.y - triangle.low.y) / (triangle.high.x - triangle.low.x) == Approx(0.5));
  CHECK(std::min(triangle.text.y, triangle.low.y) > 0.13);
  const auto above_the_line = [](const PanelPlace& place) { return place.y - place.x; };
  const bool upper = above_the_line(triangle.low) > 0;
  for (const PanelPlace& place : {triangle.low, triangle.high, triangle.corner}) {
    CHECK((above_the_line(place) > 0.03) == upper);
    CHECK(std::min({place.x, place.y, 1 - place.x, 1 - place.y}) > 0);
  }
  CHECK(std::abs(above_the_line(triangle.high)) < 0.5);
}

TEST_CASE("A law none of whose points are shown is not plotted either") {
  const TemporaryFolder run;
  Analysis analysis = analysis_over({0.1, 0.2});
  analysis.readings.clear();
  for (Transport& result : analysis.results) {
    if (result.scanned() < 0.25 && !result.exact) result.c = result.D = synthetic::unknown("too uncertain for a point");
  }
  const Figure figure = plot_scaling_with_friction(analysis, run.path());
  CHECK(read_file(run.path() / figure.script).find("exp(") == std::string::npos);
}
