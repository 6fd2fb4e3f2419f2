#include "plot/power_law_panel.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "kit/temporary_folder.h"
#include "model/lattice.h"
#include "plot/depth_figures.h"
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

/// y / x^exponent of each guide of a script, "y * ($1 / x)**exponent".
std::vector<double> guide_factors(const std::string& script) {
  std::vector<double> factors;
  const std::string begin = "'+' using 1:(", middle = " * ($1 / ";
  for (std::size_t at = script.find(begin); at != std::string::npos; at = script.find(begin, at + 1)) {
    if (script.substr(0, script.find('\n', at)).find(middle, at) == std::string::npos) continue;
    double y = 0, x = 0, exponent = 0;
    REQUIRE(std::sscanf(script.c_str() + at + begin.size(), "%lf * ($1 / %lf)**%lf", &y, &x, &exponent) == 3);
    factors.push_back(y / std::pow(x, exponent));
  }
  return factors;
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

TEST_CASE("A window ends where the axis ends") {
  Range axis;
  axis.add(0.5);
  axis.add(2);
  CHECK(window_on_axis({0, 1e9}, axis).low == 0.5);
  CHECK(window_on_axis({0, 1e9}, axis).high == 2);
  CHECK(window_on_axis({0.6, 1}, axis).low == 0.6);
  CHECK(window_on_axis({0.6, 1}, axis).high == 1);
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

TEST_CASE("The paper's laws stand at the points of the window, wherever the window begins") {
  for (const double low : {0.0, 0.1}) {
    CAPTURE(low);
    const TemporaryFolder run;
    plot_scaling_with_friction(analysis_over({low, 0.3}), run.path());
    const std::string script = read_file(run.path() / "figures/scaling-with-friction.gp");
    double log_D = 0, log_slowing = 0;
    for (const synthetic::Row& row : synthetic::rows()) {
      if (row.mu > 0.31) continue;
      log_D += std::log(row.D / std::pow(row.mu, 2.5)) / 4;
      log_slowing += std::log((tan30 - row.c) / row.mu) / 4;
    }
    const std::vector<double> factors = guide_factors(script);
    REQUIRE(factors.size() == 2);
    CHECK(factors[0] == Approx(std::exp(log_D)));
    CHECK(factors[1] == Approx(std::exp(log_slowing)));
  }
}

TEST_CASE("A law none of whose points are shown is not plotted either") {
  const TemporaryFolder run;
  Analysis analysis = analysis_over({0.1, 0.2});
  for (Transport& result : analysis.results) {
    if (result.scanned() < 0.25 && !result.exact) result.c = result.D = synthetic::unknown("too uncertain for a point");
  }
  const Figure figure = plot_scaling_with_friction(analysis, run.path());
  CHECK(guide_factors(read_file(run.path() / figure.script)).empty());
}
