#include <catch2/catch.hpp>
#include <cmath>

#include "kit/temporary_folder.h"
#include "plot/counted_work.h"
#include "plot/nonlinearity.h"
#include "plot/small_friction.h"
#include "plot/synthetic_analysis.h"
#include "support/atomic_file.h"
#include "support/error.h"

using namespace granuscope;
using test::TemporaryFolder;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Made-up piles at small friction: variance 1 - exp(-n/saturation), deficit of the thrust ratio proportional to mu^2.
SmallFriction small_friction(double mu) {
  SmallFriction made;
  made.spec.sampler.mu = mu;
  made.spec.lattice.columns = 32;
  made.spec.lattice.layers = static_cast<int>(2.4 / (mu * mu));
  made.samples = 256;
  made.depth_over_saturation = 4;
  made.first_layer = made.spec.lattice.layers / 2;
  made.last_layer = made.spec.lattice.layers - 21;
  const double saturation = made.spec.lattice.layers / 4.0, deficit = 0.5 * mu * mu;
  for (int layer = 0; layer <= made.last_layer; layer += 1 + layer / 8) {
    ThrustAtDepth depth;
    depth.layer = layer;
    depth.z = Lattice::depth(layer);
    depth.thrust_ratio = synthetic::known(1 - deficit, 0.02 * deficit);
    depth.weight_variance = synthetic::known(0.1 * (1 - std::exp(-layer / saturation)), 0.002);
    made.depths.push_back(depth);
  }
  made.alpha_thrust = synthetic::known(1 - deficit, 0.01 * deficit);
  made.c_thrust = synthetic::known(tan30 * std::sqrt(1 - deficit), 0.003 * deficit);
  made.c0_minus_c = synthetic::known(tan30 - made.c_thrust.value, 0.003 * deficit);
  return made;
}

}  // namespace

TEST_CASE("Small friction shows saturation and the law that the deep piles follow") {
  const TemporaryFolder run;
  Analysis analysis = synthetic::analysis();
  for (const double mu : {0.03, 0.05, 0.1}) analysis.side.small_friction.push_back(small_friction(mu));
  analysis.side.small_friction_scaling = synthetic::power_law(2.0, 0.01, std::log(0.25 * tan30), {0.03, 0.1});
  const Figure figure = draw_small_friction(analysis, run.path());
  CHECK(figure.redraw == "cd figures && gnuplot -d small-friction.gp");
  CHECK(contains(figure.caption, "exponent 2.000(10) fitted over μ = 0.03 to 0.1"));
  CHECK(contains(figure.caption, "32 columns, at least 4 times"));
  CHECK_FALSE(contains(figure.caption, " ."));
  const std::string svg = read_file(run.path() / figure.screen);
  for (const char* label : {"layer  in units of 0.6/μ²", "narrow deep piles: 2.000(10)", "right: the main piles"}) {
    INFO(label);
    CHECK(contains(svg, label));
  }
  CHECK(std::filesystem::exists(run.path() / "figures/small-friction-mu-0.03.csv"));
  CHECK(std::filesystem::exists(run.path() / "figures/small-friction-slowing-narrow-piles-inside-over-law.csv"));
  analysis.side.small_friction_scaling = {};
  analysis.side.small_friction_scaling.exponent = synthetic::unknown("only two points");
  CHECK(contains(draw_small_friction(analysis, run.path()).caption, "unknown: only two points"));
  CHECK_THROWS_AS(draw_small_friction(synthetic::analysis(), run.path()), InputError);
}

TEST_CASE("The loads are drawn against the linear response, and what cannot be compared is left out") {
  const TemporaryFolder run;
  Nonlinearity measured;
  for (const double mu : {0.1, 0.3}) {
    for (const double load : {0.1, 0.25, 0.5, 1.0, 4.0}) {
      LoadResponse one;
      one.spec.sampler.mu = mu;
      one.spec.response = load < 0.6 ? multiplexed_response(load) : point_response(load);
      one.reference = load == 0.25;
      one.samples = 256;
      one.D_shift = synthetic::known(-0.25 * load, 0.03);
      one.c_shift = synthetic::known(0.001 * mu * load, 0.0001);
      one.c = synthetic::known(0.57, 0.001);
      one.D = synthetic::known(0.03, 0.001);
      if (load == 4 && mu == 0.1) one.D_shift = one.c_shift = synthetic::unknown("too narrow");
      measured.responses.push_back(one);
    }
    LoadResponse uniform;
    uniform.spec.sampler.mu = mu;
    uniform.spec.load = Load::uniform;
    uniform.D_shift = uniform.c_shift = synthetic::unknown("no response");
    measured.responses.push_back(uniform);
  }
  const Figure figure = draw_nonlinearity(measured, run.path());
  CHECK(figure.data.size() == 4);
  CHECK(contains(figure.caption, "varied by ±0.25 of"));
  CHECK(contains(figure.caption, "−25.0(3.0) % at μ = 0.1 and −25.0(3.0) % at μ = 0.3"));
  CHECK_FALSE(contains(figure.caption, " ."));
  const std::string svg = read_file(run.path() / figure.screen);
  for (const char* label : {"size of the load", "all loads ±ε (multiplexed)", "μ = 0.3"}) CHECK(contains(svg, label));
  const std::string points = read_file(run.path() / "figures/nonlinearity-point-mu-0.1.csv");
  CHECK(std::count(points.begin(), points.end(), '\n') == 2);  // the header and the overload 1
  CHECK_THROWS_AS(draw_nonlinearity({}, run.path()), InputError);
}

TEST_CASE("Counted work is drawn per bead and names what was not completed") {
  const TemporaryFolder run;
  std::vector<CountedWork> work;
  for (const double mu : {0.1, 1.7}) {
    for (const int size : {100, 200, 400}) {
      CountedWork one;
      one.spec.sampler.mu = mu;
      one.spec.lattice.columns = one.spec.lattice.layers = size;
      one.samples = 64;
      one.draws_per_bead = 1 + 2 * mu + 0.0005 * size;
      work.push_back(one);
    }
  }
  work.back().failed = 3;
  const Figure figure = draw_counted_work(work, run.path());
  CHECK(figure.data.size() == 2);
  CHECK(contains(figure.caption, "by a factor of 1.12"));  // 1.4 / 1.25
  CHECK(contains(figure.caption, "means of 64 piles"));
  CHECK(contains(figure.caption, "3 of 67 piles of 400 × 400 beads at μ = 1.7"));
  const std::string svg = read_file(run.path() / figure.screen);
  CHECK(contains(svg, "random numbers per bead"));
  CHECK(contains(svg, "μ = 1.7"));
  CHECK_THROWS_AS(draw_counted_work({}, run.path()), InputError);

  // Without friction nothing is drawn, whatever the size.
  for (CountedWork& one : work) {
    EnsembleSpec frictionless = one.spec;
    frictionless.sampler.mu = 0;
    one = {.spec = frictionless, .samples = 64};
  }
  work.resize(3);
  CHECK(contains(read_file(run.path() / draw_counted_work(work, run.path()).screen), "μ = 0"));
}
