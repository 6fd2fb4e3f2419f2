// Source: the top layer's variance of the weights under a uniform load is 0; rejection on 6 x 6 beads has known values
// elsewhere (tests/sampling/rejection_test.cc): here only the bookkeeping is held.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"
#include "kit/estimates.h"
#include "kit/linear_response.h"
#include "kit/small_piles.h"
#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/figure_texts.h"
#include "studies/law_comparison.h"
#include "studies/study_page.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using test::chained_piles;
using test::contains;
using test::count;
using test::known;
using test::piles_of;
using test::TemporaryFolder;
using test::unknown;

TEST_CASE("The comparison of laws keeps each law's name, size, work and its means over the middle third") {
  EnsembleSpec spec = piles_of(Law::granusolve, 0.3, {6, 6}, 512);
  spec.sampler.rules = RepairRules::no_pair;
  const EnsembleRecord record = run_ensemble(spec, 1, nullptr);
  const LawOnPiles measured = measure_law({spec, record});
  CHECK(configuration_text(measured.spec) == configuration_text(spec));
  CHECK(measured.samples == 512);
  CHECK(measured.failed == 0);
  CHECK(measured.pair_per_bead == 0);
  CHECK(measured.arc_per_bead > 0);
  CHECK(measured.draws_per_bead > 1);
  REQUIRE(measured.depths.size() == 6);
  CHECK(measured.depths.front().weight_variance.value == Approx(0).margin(1e-12));
  CHECK(measured.first_layer == 2);
  CHECK(measured.last_layer == 3);
  CHECK(measured.alpha_thrust.value ==
        Approx((measured.depths[2].thrust_ratio.value + measured.depths[3].thrust_ratio.value) / 2));
  CHECK(measured.c_thrust.value == Approx(std::sqrt(measured.alpha_thrust.value / 3)));
  CHECK(measured.weight_variance.value ==
        Approx((measured.depths[2].weight_variance.value + measured.depths[3].weight_variance.value) / 2));
}

TEST_CASE("What a chain ran for is kept with its piles") {
  const EnsembleSpec spec = chained_piles(3, 256);
  const EnsembleRecord record = run_ensemble(spec, 2, nullptr);
  const LawOnPiles measured = measure_law({spec, record});
  CHECK(measured.burn_in == 50);
  CHECK(measured.thinning == 3);
  const LawOnPiles without_chain = measure_law({piles_of(Law::granusolve), record});
  CHECK(std::isnan(without_chain.burn_in));
}

// Source: c and D of the linear response at this friction (numbers on record, over deep layers); near the top the
// slopes differ from those by a few percent and some tens of percent.
TEST_CASE("The response under a law has its slopes over the layers between the top and the bottom margin") {
  EnsembleSpec spec = piles_of(Law::granusolve);
  spec.load = Load::point;
  spec.response.estimator = EstimatorName::multiplexed;
  spec.response.epsilon = 0.5;
  spec.record_profiles = true;
  spec.lattice = {24, 27};
  spec.layers = layers_to_record(law_response_fit(spec.lattice), {});
  const LawResponse response = measure_law_response({spec, run_ensemble(spec, 2, nullptr)}, 1);
  CHECK(configuration_text(response.spec) == configuration_text(spec));
  CHECK(response.first_layer == 4);
  CHECK(response.last_layer == 6);
  REQUIRE(response.c.known());
  CAPTURE(response.c.value, response.c.standard_error, response.D.value, response.D.standard_error);
  const test::LinearResponse& deep = test::linear_response[2];
  REQUIRE(deep.mu == spec.sampler.mu);
  CHECK(std::abs(response.c.value - deep.c) < 0.02 + 5 * response.c.standard_error);
  CHECK(response.c.standard_error < 0.006);
  CHECK(std::abs(response.D.value - deep.D) < 0.03 + 5 * response.D.standard_error);
  CHECK(response.D.standard_error < 0.015);
}

TEST_CASE("Work of the laws against size leaves out and names what was not completed") {
  const TemporaryFolder run;
  std::vector<LawOnPiles> costs;
  for (const Law law : {Law::granusolve, Law::eloy_clement}) {
    for (const int size : {4, 6, 8}) {
      LawOnPiles one;
      one.spec.sampler.law = law;
      one.spec.sampler.mu = 0.3;
      one.spec.lattice.columns = one.spec.lattice.layers = size;
      one.samples = 64;
      one.draws_per_bead = law == Law::granusolve ? 1.4 : std::exp(size);
      costs.push_back(one);
    }
  }
  costs.back().failed = 5;
  const Figure figure = plot_law_cost(costs, run.path());
  check_at_widths_of_journals(run / "figures", figure.id);
  CHECK(figure.data.size() == 2);
  CHECK(contains(figure.details, "5 of 69 piles of 8 × 8 beads under eloy-clement at μ = 0.3"));
  CHECK(contains(figure.details,
                 "Means of 64 piles. From 4 × 4 to 8 × 8 beads a bead takes: eloy-clement 54.6 to 403 at μ = "
                 "0.3 up to 6 × 6 beads; granusolve 1.40 to 1.40 at μ = 0.3."));
  CHECK(contains(read_file(run.path() / figure.screen), "eloy-clement, μ = 0.3"));
  CHECK_THROWS_AS(plot_law_cost({}, run.path()), InputError);
}

TEST_CASE("The thrust under every law has names that leave each other and the curves free") {
  std::vector<LawOnPiles> laws;
  for (const Law law : {Law::granusolve, Law::polytope, Law::eloy_clement, Law::rejection}) {
    for (const LatticeSpec lattice : {LatticeSpec{12, 30}, LatticeSpec{6, 6}}) {
      for (const RepairRules rules : {RepairRules::all, RepairRules::no_pair}) {
        if (rules != RepairRules::all && law != Law::granusolve) continue;
        LawOnPiles one;
        one.spec.sampler.law = law;
        one.spec.sampler.mu = 0.3;
        one.spec.sampler.lambda = -1.5;
        one.spec.sampler.rules = rules;
        one.spec.lattice = lattice;
        one.samples = 512;
        for (int layer = 0; layer < lattice.layers; ++layer) {
          const double share = static_cast<double>(layer) / lattice.layers;
          one.depths.push_back(
              {layer, Lattice::depth(layer), known(1 - 0.08 * share, 0.0012), known(0.4 * share, 0.01)});
        }
        one.alpha_thrust = known(0.9312, 0.0012);
        one.weight_variance = known(0.2345, 0.0067);
        one.draws_per_bead = law == Law::rejection ? 1234.5 : 1.234;
        laws.push_back(one);
      }
    }
  }
  const TemporaryFolder run;
  const Figure figure = plot_laws(laws, run.path());
  CHECK(figure.data.size() == laws.size());
  check_at_widths_of_journals(run / "figures", figure.id);
}

TEST_CASE("Responses under the laws say how far they lie from the first") {
  ComparedLaws measured;
  measured.responses.resize(3);
  for (LawResponse& one : measured.responses) one.spec.sampler.law = Law::rejection;
  measured.responses[0].c = known(0.55, 0.003);
  measured.responses[1].c = known(0.54, 0.004);
  measured.responses[0].D = measured.responses[1].D = known(0.1, 0.01);
  measured.responses[2].c = measured.responses[2].D = unknown("too few");
  measured.on_piles.resize(1);
  measured.on_piles[0].spec.sampler.law = Law::rejection;
  const std::string html = study_page(*law_comparison_study(measured)).html;
  const std::string section = html.substr(html.find("The response under these laws"));
  const std::string body = section.substr(section.find("<tbody>"), section.find("</table>") - section.find("<tbody>"));
  CHECK(count(body, "<td class=\"num\">–</td>") == 2 + 3);  // the first law itself, and no chain has a burn-in
  CHECK(contains(body, "<td class=\"num\">2.0</td>"));
  CHECK(contains(body, "<td class=\"num\">0.0</td>"));
  CHECK(count(body, "<td class=\"num\">n/a</td>") == 2);
}

TEST_CASE("Page 1 says what the laws decide, and only of piles that can be compared") {
  ComparedLaws measured;
  measured.on_piles.resize(3);
  for (LawOnPiles& one : measured.on_piles) {
    one.spec.lattice = {12, 30};
    one.spec.sampler.mu = 0.3;
    one.alpha_thrust = known(0.90, 0.001);
  }
  measured.on_piles[1].spec.sampler.law = Law::rejection;
  measured.on_piles[1].alpha_thrust = known(0.91, 0.001);
  measured.on_piles[2].spec.sampler.rules = RepairRules::no_pair;
  measured.on_piles[2].alpha_thrust = known(0.5, 0.001);
  const auto sentences = [&] {
    const std::string html = study_page(*law_comparison_study(measured)).html;
    const std::size_t from = html.find("class=\"headline\"");
    return from == std::string::npos ? "" : html.substr(from, html.find("</div>", from) - from);
  };
  CHECK(contains(sentences(), "decides the thrust"));
  CHECK(contains(sentences(), "0.9100(10)</span></span> under"));
  CHECK_FALSE(contains(sentences(), "0.5000(10)"));  // its rules are not whole: no law of its own
  CHECK_FALSE(contains(sentences(), "every law can be drawn"));
  measured.on_piles[1].alpha_thrust = known(0.902, 0.001);
  CHECK(contains(sentences(), "same thrust within three standard errors"));
  measured.on_piles.resize(1);
  CHECK(sentences().empty());
}
