#include <catch2/catch.hpp>
#include <cmath>

#include "kit/temporary_folder.h"
#include "plot/nonlinearity.h"
#include "plot/synthetic_analysis.h"
#include "support/atomic_file.h"
#include "support/error.h"

using namespace granuscope;
using test::TemporaryFolder;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

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
