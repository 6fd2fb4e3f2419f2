// Tables of the report that need more than the common fixture: windows, shape, laws, loads.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/synthetic_analysis.h"
#include "report/page.h"
#include "report/page_overlays.h"
#include "report/page_reader.h"
#include "report/report.h"
#include "report/report_data.h"
#include "report/summary_json.h"

using namespace granuscope;
using Json = nlohmann::ordered_json;
using synthetic::known;
using synthetic::unknown;
using test::contains;
using test::count;

namespace {

ReportData numbers() {
  ReportData data;
  data.columns = 500;
  data.layers = 200;
  data.analysis = synthetic::analysis();
  return data;
}

FitVariation variation(const std::string& change, std::array<int, 2> layers, const Estimate& c_shift,
                       const Estimate& D_shift) {
  FitVariation made;
  made.change = change;
  made.layers = layers;
  made.depths = layers[1] > 0 ? 30 : 0;
  made.c = made.D = known(0.5, 0.01);
  made.c_shift = c_shift;
  made.D_shift = D_shift;
  return made;
}

}  // namespace

TEST_CASE("Shifts of the window stand with their layers, and a systematic error only where there is one") {
  ReportData data = numbers();
  Transport& result = data.analysis.results[1];
  result.c.systematic = 0.00031;
  result.D.systematic = 0;  // no farther than the scatter accounts for
  const Estimate missing = unknown("no depth just above the window can be fitted");
  result.variations = {
      variation("without_shallowest_quarter", {89, 179}, known(-0.00011, 0.00005), known(7e-5, 0.00012)),
      variation("longer_above", {0, 0}, missing, missing)};
  data.analysis.results[2].variations = {variation("longer_above", {0, 0}, missing, missing)};
  const Page page(data);
  const std::string table = table_of(page.html, "shifts");
  CHECK(page.texts.at("/results/1/variations/0/c_shift") == "−0.000110(50)");
  CHECK(page.texts.at("/results/1/variations/0/D_shift") == "0.00007(12)");
  CHECK(page.texts.at("/results/1/variations/0/window_layers/0") == "89");
  CHECK(page.texts.at("/results/1/variations/0/window_layers/1") == "179");
  CHECK_FALSE(page.texts.contains("/results/1/variations/1/window_layers/0"));
  CHECK(count(table, "<tr class=\"first\"") == 2);  // one for each friction coefficient
  CHECK(count(table, "without the shallowest quarter") == 1);
  CHECK(count(table, "<tbody>") == 2);  // none without a row: WeasyPrint would leave the heading alone on its page
  // Paper has no such table, whose caption takes no number on screens: the others have the same ones. Facts are lines
  // there.
  const test::TemporaryFolder run;
  const std::string printed =
      report_page(data, nlohmann::ordered_json::parse(summary_json(data)), run.path(), PageMedium::print);
  CHECK(table_of(printed, "shifts").empty());
  const auto numbered = [](const std::string& html) {
    return count(html.substr(0, html.find("id=\"provenance\"")), "<span class=\"caption\">");
  };
  CHECK(numbered(page.html) == numbered(printed) + 1);
  CHECK(contains(page.html, ".shifts caption { counter-increment: none; }"));
  CHECK(count(table, "extended upwards by up to a quarter") == 2);
  CHECK(page.texts.at("/results/1/c/systematic") == "31");  // beside 0.57480(20)
  CHECK(contains(page.html, "(<span data-key=\"/results/1/c/systematic\">31</span>)"));
  CHECK_FALSE(page.texts.contains("/results/1/D/systematic"));
  // Two friction coefficients lack it for the same reason, which is said once.
  CHECK(count(page.html, "no depth just above the window can be fitted") == 1);
  CHECK(contains(page.html, "n/a at μ = 0.1 and 0.15: "));
}

TEST_CASE("A systematic error stands in the last digits of its value, one of them at least") {
  ReportData data = numbers();
  const auto bracket = [&](double value, double error, double systematic) {
    data.analysis.results[1].c = known(value, error);
    data.analysis.results[1].c.systematic = systematic;
    return Page(data).texts.at("/results/1/c/systematic");
  };
  CHECK(bracket(0.5771085, 0.0000019, 9.1e-7) == "9");
  CHECK(bracket(0.5771085, 0.0000019, 2e-9) == "1");
  CHECK(bracket(0.5356, 0.0030, 0.0033) == "33");
  CHECK(bracket(2.08, 0.37, 0.456) == "46");
  CHECK(bracket(12.3, 2.5, 1.44) == "1.4");  // 12.3(2.5)(1.4)
  // Behind a sign where the value has a power of ten.
  data.analysis.results[1].c = known(3.2e-6, 1.4e-7);
  data.analysis.results[1].c.systematic = 2e-8;
  const test::TemporaryFolder run;
  CHECK(contains(html_report(data, nlohmann::ordered_json::parse(summary_json(data)), run.path()),
                 "3.20(14) × 10⁻⁶</span> ± <span data-key=\"/results/1/c/systematic\">2.0 × 10⁻⁸"));
}

TEST_CASE("An exponent stands beside the chi squared of its points") {
  ReportData data = numbers();
  data.analysis.scaling.beta.scatter = {32.104, 3, 5, {}};
  const Page page(data);
  CHECK(page.texts.at("/scaling/beta/about_law/chi2") == "32.1");
  CHECK(contains(table_of(page.html, "exponents"), "32.1</span> / 3</td>"));
  CHECK_FALSE(page.texts.contains("/scaling/gamma/about_law/chi2"));  // not known
}

TEST_CASE("Times are summed, and take no more digits than they have") {
  ReportData data = numbers();
  data.timings = {{"plot", 0.01, false},
                  {"analyse", 12, true},
                  {"sample mu = 0.1", 30, true, 1'000'000'000},
                  {"sample mu = 0.2", 60, false, 1'000'000'000}};
  const Page page(data);
  CHECK(contains(page.html, "<td class=\"num\">&lt; 0.1 s</td>"));
  CHECK(contains(page.html, "<td class=\"num\">12 s</td>"));
  CHECK(contains(
      page.html,
      "sampling, main ensembles</th><td class=\"num\">1 min 30 s</td><td class=\"num\">45</td><td>1 of 2 reused"));
}

TEST_CASE("Laws that the run compares are told beside its own, and the experiment line by line") {
  ReportData data = numbers();
  data.law_description = {"Layers are solved from top to bottom."};
  data.other_law_descriptions = {{"rejection", {"The whole pile is thrown away.", "Tiny piles only."}}};
  data.resolved_experiment = "[lattice]\n# beads per layer\ncolumns = 500\n\n[figures]\n\n[fit]\nlast_layer = 9\n";
  const Page page(data);
  CHECK(contains(page.html, "The law <em>rejection</em>"));
  CHECK(contains(page.html, "<li>Tiny piles only.</li>"));
  CHECK(contains(page.html,
                 "<span class=\"line\"># beads per layer</span><span class=\"line\">columns = 500</span></span><span "
                 "class=\"block\">"
                 "<span class=\"line\">[fit]</span><span class=\"line\">last_layer = 9</span></span></pre>"));
  CHECK_FALSE(contains(Page(numbers()).html, "The law <em>"));
}

TEST_CASE("A run without neighbouring windows has no table of them") {
  const Page page(numbers());
  CHECK(table_of(page.html, "shifts").empty());
  CHECK(table_of(page.html, "windows shapes").empty());
  CHECK_FALSE(table_of(page.html, "transport").empty());
}

TEST_CASE("What the shape leaves out stands with its window, for the friction coefficients where it is known") {
  ReportData data = numbers();
  for (Transport& result : data.analysis.results) result.fitted_area = result.centre_background = unknown("not fitted");
  Transport& result = data.analysis.results[3];
  result.fitted_area = known(1.0071, 0.003);
  result.centre_background = known(0.0237, 0.0077);
  result.largest_misfit = 0.214;
  result.chi2_per_dof = 1.523;
  result.chi2_beside_per_dof = 1.018;
  result.c_beside = known(0.5340, 0.0051);
  result.D_beside = known(0.502, 0.066);
  const Page page(data);
  const std::string table = table_of(page.html, "windows shapes");
  CHECK(count(table, "<tr>") == 2);  // the heading and one friction coefficient
  CHECK(page.texts.at("/results/3/fitted_area") == "1.0071(30)");
  CHECK(page.texts.at("/results/3/centre_background") == "0.0237(77)");
  CHECK(page.texts.at("/results/3/largest_misfit") == "0.21");
  CHECK(page.texts.at("/results/3/chi2_per_dof") == "1.52");
  CHECK(page.texts.at("/results/3/chi2_beside_background_per_dof") == "1.02");
  CHECK(contains(table, "0.5340(51)"));
  CHECK(contains(table, "0.502(66)"));
  // The share is 3.08 errors above 0: that is said in words, too.
  const std::string words = "more than three errors above 0";
  CHECK(contains(page.html, words));
  const auto told_with = [&](auto change) {
    ReportData other = data;
    change(other.analysis.results[3]);
    return contains(Page(other).html, words);
  };
  CHECK(told_with([](Transport&) {}));
  CHECK_FALSE(told_with([](Transport& of) { of.centre_background = known(0.0237, 0.0080); }));
  CHECK_FALSE(told_with([](Transport& of) { of.centre_background = known(-0.0237, 0.0077); }));
  CHECK_FALSE(told_with([](Transport& of) { of.chi2_beside_per_dof = std::nan(""); }));
  CHECK_FALSE(told_with([](Transport& of) { of.D_beside = unknown("not fitted"); }));
  CHECK_FALSE(page.texts.contains("/results/1/fitted_area"));
}

TEST_CASE("Estimator and law stand once where all rows share them, and in each row where they do not") {
  ReportData data = numbers();
  const Page shared(data);
  CHECK(shared.texts.at("/results/0/law") == "granusolve");
  CHECK_FALSE(shared.texts.contains("/results/1/law"));
  data.analysis.results[2].spec.sampler.law = Law::polytope;
  const Page mixed(data);
  CHECK(mixed.texts.at("/results/1/law") == "granusolve");
  CHECK(mixed.texts.at("/results/2/law") == "polytope");
}

TEST_CASE("Rounding of an exact result stands as 0, a small number with an error does not") {
  ReportData data = numbers();
  REQUIRE(data.analysis.results[0].exact);
  data.analysis.results[0].D = data.analysis.results[0].c_minus_c_thrust = known(-2.5e-15, 0);
  data.analysis.results[1].D = known(0.00003, 0.00001);
  const std::string summary = summary_json(data);
  const test::TemporaryFolder run;
  std::map<std::string, std::string> texts;
  for (const auto& [key, text] :
       synthetic::keyed_texts(html_report(data, nlohmann::ordered_json::parse(summary), run.path())))
    texts[key] = text;
  CHECK(texts.at("/results/0/D") == "0");
  CHECK(texts.at("/results/0/c_minus_c_thrust") == "0");
  CHECK(texts.at("/results/1/D") == "3.0(1.0) × 10⁻⁵");
}

TEST_CASE("Exponents without a value leave no empty tables, and their reasons are one sentence") {
  ReportData data = numbers();
  const Estimate missing = unknown("one friction coefficient is no law");
  ScalingFits none = synthetic::scaling({0.1, 0.3});
  none.beta.exponent = none.gamma.exponent = none.alpha.exponent = missing;
  data.analysis.scaling = none;
  data.analysis.other_windows = {none};
  const Page page(data);
  CHECK_FALSE(contains(page.html, "The same exponents"));
  CHECK(count(page.html, "one friction coefficient is no law") == 2);  // on page 1 and in section A
  CHECK(contains(page.html, "Unknown: β, γ and α; β, γ and α over μ = 0.1 to 0.3. Why: "));
  const Page usual(numbers());
  CHECK(count(usual.html, "The same exponents") == 1);
}

TEST_CASE("Powers that could not be taken have their reason below the table") {
  ReportData data = numbers();
  for (Transport& result : data.analysis.results) {
    result.exponents.position = result.exponents.width = result.exponents.amplitude = result.exponents.noise =
        known(1, 0.1);
  }
  Exponents& exponents = data.analysis.results[2].exponents;
  exponents.position = exponents.width = exponents.amplitude = exponents.noise = unknown("the window is too short");
  const Page page(data);
  CHECK(count(page.html, "the window is too short") == 1);
  CHECK(contains(page.html, "n/a at μ = 0.15: "));
  CHECK_FALSE(contains(page.html, "for the reasons that stand under"));

  // A reason that c and D share stands with them alone.
  Transport& result = data.analysis.results[2];
  result.c = result.D = unknown("the window is too short");
  Exponents& others = data.analysis.results[3].exponents;
  others.position = others.width = others.amplitude = others.noise = unknown("the peaks are too wide");
  data.analysis.results[3].c = data.analysis.results[3].D = unknown("the peaks are too wide");
  const Page shared(data);
  CHECK(count(shared.html, "the window is too short") == 2);  // and on page 1
  CHECK(count(shared.html, "the peaks are too wide") == 2);
  CHECK(contains(shared.html, "n/a at <var>μ</var> = 0.15 and 0.2: for the reasons given under"));
}

TEST_CASE("Page 1 names the values without c and D, and those that no power has, each with its reason") {
  ReportData data = numbers();
  data.analysis.results[2].c = unknown(
      "from the end of the window, layers 32 to 99, upwards one depth can be fitted, and a slope needs 3; at layer 96: "
      "two Gaussians miss 17 % of the response: it has another shape");
  data.analysis.results[3].c = known(0.588, 0.011);
  const std::string html = Page(data).html;
  CHECK(
      contains(html, "Without <var>c</var> and <var>D</var>: μ = 0.15 (two Gaussians miss 17 % of the response).</p>"));
  CHECK(contains(html, "In no power: μ = 0.2 (c is not below c₀).</p>"));
  CHECK(contains(found_text(summary_json(data)), "in no power: μ = 0.2 (c is not below c₀)\n"));
  const std::string usual = Page(numbers()).html;
  CHECK_FALSE(contains(usual, "Without <var>c</var>"));
  CHECK_FALSE(contains(usual, "In no power"));
}

TEST_CASE("A power that the points refuse is reproduced on average only") {
  ReportData data = numbers();
  const auto told = [&] { return found_text(summary_json(data)); };
  CHECK_FALSE(contains(told(), "on average"));
  data.analysis.scaling.beta.scatter = {39, 1, 3, {}};
  for (const char* verdict : {"reproduced", "not reproduced", "not decided", "not tested"}) {
    for (Claim& claim : data.analysis.claims) {
      if (claim.id == "D-of-mu") claim.verdict = verdict;
    }
    const bool tested = std::string(verdict).ends_with("reproduced");
    CHECK(contains(told(), verdict + std::string(tested ? ", on average\n" : "\n")));
    CHECK(contains(table_of(Page(data).html, "exponents"), "</span>, on average") == tested);
  }
}

TEST_CASE("What does not change within its errors is not said to go anywhere") {
  ReportData data = numbers();
  data.analysis.scaling.gamma.exponent = unknown("no law");
  std::erase_if(data.analysis.results, [](const Transport& one) { return one.exact; });
  const auto told = [&](double c, double D) {
    for (std::size_t i = 0; i < data.analysis.results.size(); ++i) {
      data.analysis.results[i].c = known(i == 0 ? 0.558 : c, 0.005);
      data.analysis.results[i].D = known(i == 0 ? 0.08 : D, 0.01);
    }
    const std::string html = Page(data).html;
    return std::pair(contains(html, "<var>c</var> does not change within the errors"),
                     contains(html, "<var>D</var> does not within theirs"));
  };
  CHECK(told(0.565, 0.08) == std::pair(true, true));
  CHECK(told(0.565, 0.01) == std::pair(true, false));
  CHECK(told(0.5, 0.08) == std::pair(false, true));
}

TEST_CASE("A run of studies alone ends with what they found") {
  ReportData data = numbers();
  std::erase_if(data.analysis.results, [](const Transport& one) { return !one.exact; });
  CHECK(contains(found_text(summary_json(data)), "c_thrust"));
  data.studies = {{"deep_response", {{{"mu", 0.3}}}}, {"law_comparison", {{"laws", Json::array()}}}};
  Claim& claim = data.analysis.claims.back();
  claim.id = "spreading-deep";
  claim.verdict = "not decided";
  claim.measured = known(1.07, 0.1);
  const std::string told = found_text(summary_json(data));
  CHECK(contains(told, "The numbers of the studies stand in the report"));
  CHECK(contains(told, "not decided:"));
  CHECK(contains(told, "spreading-deep"));
  CHECK_FALSE(contains(told, "c_thrust"));
}

TEST_CASE("Page 1 counts what was not decided apart from what was not tested") {
  ReportData data = numbers();
  CHECK(contains(Page(data).html, "0 not decided"));
  CHECK(contains(Page(data).html, "Claims not tested in this run: amplitude"));
  data.analysis.claims.back().verdict = "not decided";
  const std::string html = Page(data).html;
  CHECK(contains(html, "1 not decided"));
  CHECK_FALSE(contains(html, "Claims not tested in this run"));
}

TEST_CASE("Page 1 shows the exponents as they are read, as slopes and at small friction, and misses first") {
  ReportData data = numbers();
  ScalingFit& gamma = data.analysis.readings[0].fits.gamma;
  gamma.scatter = {50.1, 2, 4, {}};
  std::string html = Page(data).html;
  // Without an error where there is no power law.
  CHECK(contains(html, "<span data-key=\"/scaling/readings/0/gamma\">0.980</span>"));
  CHECK(contains(html, "<span data-key=\"/scaling/readings/1/alpha\">0.950(30)</span>"));
  CHECK(contains(html, "the discrepancy with the stochastic theory all but vanishes"));
  CHECK(html.find("#claim-c-of-mu\"") < html.find("#claim-frictionless\""));
  CHECK_FALSE(contains(html, "Beyond the paper"));
  data.analysis.readings[1].fits.beta.exponent = known(2.5, 0.02);
  data.analysis.claims[0].beyond_paper = true;
  const std::string other = Page(data).html;
  CHECK_FALSE(contains(other, "all but vanishes"));
  CHECK(other.find("Beyond the paper") < other.find("#claim-frictionless\""));
  CHECK(contains(other, "1 reproduced, 2 not reproduced"));
  CHECK(contains(html, "aria-label=\"pull 8.1\""));
  CHECK_FALSE(contains(html, "M9 -1L10.8 0L9 1Z"));
  data.analysis.claims[2].z_score = 17;
  html = Page(data).html;
  CHECK(contains(html, "M9 -1L10.8 0L9 1Z"));
  // A number without its error says so beside it.
  CHECK_FALSE(contains(html, "no single power;"));
  data.analysis.claims[2].power_law = false;
  data.analysis.claims[2].measured = known(1.65, 0.0301);
  html = Page(data).html;
  CHECK(contains(html, "/measured\">1.65</span></span>\n<span class=\"chi2\">(no single power; piles alone ± 0.030)"));
  data.headline = "Nothing <b>was</b> found.";
  html = Page(data).html;
  CHECK(contains(html, "Nothing &lt;b&gt;was&lt;/b&gt; found."));
  CHECK_FALSE(contains(html, "class=\"regimes\""));
}
