#include "report/report.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "report/fixture.h"
#include "report/made_page.h"
#include "report/page_reader.h"
#include "report/summary_json.h"
#include "support/error.h"
#include "support/templates.h"

using namespace granuscope;
using Json = nlohmann::ordered_json;
using test::contains;

namespace {

std::vector<std::size_t> places(const std::string& text, const std::string& part) {
  std::vector<std::size_t> found;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) found.push_back(at);
  return found;
}

double channel(const std::string& hex, std::size_t at) {
  const double value = std::stoi(hex.substr(at, 2), nullptr, 16) / 255.0;
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

/// WCAG 2.1, relative luminance and contrast ratio.
double contrast(const std::string& one, const std::string& other) {
  const auto luminance = [](const std::string& hex) {
    return 0.2126 * channel(hex, 1) + 0.7152 * channel(hex, 3) + 0.0722 * channel(hex, 5);
  };
  const double a = luminance(one), b = luminance(other);
  return (std::max(a, b) + 0.05) / (std::min(a, b) + 0.05);
}

std::map<std::string, std::string> custom_colours(const std::string& css) {
  std::map<std::string, std::string> colours;
  for (const std::size_t at : places(css, "  --")) {
    const std::size_t colon = css.find(": #", at);
    colours[css.substr(at + 2, colon - at - 2)] = css.substr(colon + 2, 7);
  }
  return colours;
}

}  // namespace

TEST_CASE("Every keyed number of the page is the one in summary.json") {
  const MadePage& page = made_page();
  for (const std::string& line : synthetic::differences(page.html, page.summary)) FAIL_CHECK(line);

  std::set<std::string> keys;
  for (const auto& [key, text] : synthetic::keyed_texts(page.html)) {
    keys.insert(key);
    if (key == "/claims/1/measured") CHECK(contains(text, "("));  // with its error
  }
  const Json summary = Json::parse(page.summary);
  for (std::size_t i = 0; i < summary["results"].size(); ++i) {
    for (const char* name :
         {"mu", "samples", "c", "D", "c_thrust", "position_offset", "width_offset", "c_minus_c_thrust",
          "sampler/draws_per_bead", "sampler/repaired_per_bead", "sampler/backtracked_per_bead"}) {
      INFO(i << name);
      CHECK(keys.contains("/results/" + std::to_string(i) + "/" + name));
    }
  }
  for (const char* name : {"/scaling/beta", "/scaling/gamma", "/scaling/alpha", "/scaling/beta/window/0",
                           "/scaling/other_windows/0/alpha", "/scaling/readings/1/gamma", "/claims/1/measured",
                           "/claims/1/paper", "/claims/1/z_score", "/results/4/failed/0/replay",
                           "/results/1/exponents/noise", "/mean_exponents/position", "/figures/1/caption", "/seed"}) {
    INFO(name);
    CHECK(keys.contains(name));
  }
}

TEST_CASE("The comparison of page and summary sees a wrong digit") {
  const MadePage& page = made_page();
  std::string altered = page.summary;
  altered.replace(altered.find("\"value\": 2.538"), 14, "\"value\": 2.548");
  CHECK_FALSE(synthetic::differences(page.html, altered).empty());
  Json without = Json::parse(page.summary);
  without["scaling"].erase("beta");
  CHECK_FALSE(synthetic::differences(page.html, without.dump()).empty());
}

TEST_CASE("The page opens with what was found, then figures, causes, method, and the appendices last") {
  const MadePage& page = made_page();
  std::size_t at = 0;
  for (const char* id : {"class=\"headline\"", "id=\"claims\"", "id=\"figures\"", "id=\"fig-force-chains\"",
                         "id=\"fig-scaling-with-friction\"", "id=\"causes\"", "id=\"method\"", "id=\"numbers\"",
                         "id=\"decided\"", "id=\"numerics\"", "id=\"provenance\"", "id=\"experiment\""}) {
    INFO(id);
    const std::size_t next = page.html.find(id, at);
    REQUIRE(next != std::string::npos);
    at = next;
  }
  CHECK(contains(page.html, "granuscope sample --mu 0.3"));
  CHECK(contains(page.html, "2 reproduced, 2 not reproduced, 0 not decided"));
  CHECK(contains(page.html, "Claims not tested in this run: amplitude"));
  CHECK(contains(page.html, "00112233445566aa"));
  CHECK(contains(page.html, "max_tries = 1000000"));
  CHECK(page.html.size() < 4'000'000);
}

TEST_CASE("The page is self-contained") {
  const MadePage& page = made_page();
  for (const char* forbidden :
       {"<script src", "<link", "<iframe", "http:", "https:", "file:", "@import", "url(", "onload=", "onclick="}) {
    INFO(forbidden);
    CHECK_FALSE(contains(page.html, forbidden));
  }
  CHECK(places(page.html, "<script").size() == 2);  // the depths as data, and the one that reads them
  for (const std::size_t at : places(page.html, "src=\"")) CHECK(page.html.substr(at, 16) == "src=\"data:image/");
  for (const std::size_t at : places(page.html, "srcset=\"")) {
    CHECK(page.html.substr(at, 19) == "srcset=\"data:image/");
  }
  // Each plot, and the same for a phone with its panels one above the other.
  CHECK(places(page.html, "data:image/svg+xml,").size() == 8);
  CHECK(places(page.html, "<source media=\"screen and").size() == 3);
  CHECK(places(page.html, "data:image/png;base64,").size() == 1);
}

TEST_CASE("The page is accessible") {
  const MadePage& page = made_page();
  CHECK(contains(page.html, "<html lang=\"en\">"));
  CHECK(contains(page.html, "name=\"viewport\""));
  CHECK(places(page.html, "<img").size() == places(page.html, " alt=\"").size());
  CHECK_FALSE(contains(page.html, "alt=\"\""));
  int last = 0;
  for (std::size_t at = page.html.find("<h"); at != std::string::npos; at = page.html.find("<h", at + 1)) {
    const char level = page.html[at + 2];
    if (level < '1' || level > '6') continue;
    CHECK(level - '0' <= last + 1);  // no level is left out on the way down
    last = level - '0';
  }
  CHECK(places(page.html, "<h1").size() == 1);
  for (const std::size_t at : places(page.html, "<th ")) CHECK(page.html.substr(at, 11) == "<th scope=\"");
  CHECK_FALSE(contains(page.html, "<th>"));
  CHECK(places(page.html, "<table").size() == places(page.html, "<caption>").size());
  // A table scrolls where it is wide, and the keyboard reaches it; nothing else is a stop of its own.
  CHECK(places(page.html, "<table").size() == places(page.html, "tabindex=\"0\"").size());
  CHECK(places(page.html, "<details").size() >= 4);
}

TEST_CASE("Text contrasts with its background in light and dark") {
  const std::string css(template_file("screen.css"));
  const std::size_t dark = css.find("prefers-color-scheme: dark");
  REQUIRE(dark != std::string::npos);
  for (const std::string& scheme : {css.substr(0, dark), css.substr(dark)}) {
    const auto colours = custom_colours(scheme);
    for (const auto& [text, back] : std::vector<std::pair<std::string, std::string>>{{"--ink", "--page"},
                                                                                     {"--quiet", "--page"},
                                                                                     {"--link", "--page"},
                                                                                     {"--link", "--panel"},
                                                                                     {"--ink", "--panel"},
                                                                                     {"--yes", "--yes-back"},
                                                                                     {"--no", "--no-back"},
                                                                                     {"--no", "--page"},
                                                                                     {"--open", "--open-back"}}) {
      INFO(text << " on " << back);
      CHECK(contrast(colours.at(text), colours.at(back)) >= 4.5);  // WCAG AA for text
    }
  }
}

TEST_CASE("Hostile text stays text everywhere") {
  const test::TemporaryFolder run;
  ReportData data = synthetic::report_data(run.path());
  const std::string hostile = synthetic::hostile_text();
  data.experiment_name = data.description = data.resolved_experiment = hostile;
  data.law_description.push_back(hostile);
  data.skipped.push_back(hostile);
  data.environment.emplace_back(hostile, hostile);
  data.timings.push_back({hostile, 1, false});
  data.analysis.results[6].D.reason = hostile;
  data.analysis.results[4].failed[0].replay = hostile;
  data.analysis.results[1].depths[0].identifiable = false;
  data.analysis.results[1].depths[0].reason = hostile;
  data.analysis.claims[0].statement = data.analysis.claims[0].explanation = hostile;
  Figure& figure = data.figures[0];
  figure.title = figure.caption = figure.alternative = figure.paper_says = figure.redraw = hostile;
  const std::string summary = summary_json(data);
  const std::string html = html_report(data, nlohmann::ordered_json::parse(summary), run.path());
  CHECK(places(html, "<script").size() == 2);
  CHECK(places(html, "</script").size() == 2);
  CHECK_FALSE(contains(html, "<script>alert"));
  CHECK_FALSE(contains(html, "\xff"));
  CHECK_FALSE(contains(html, "\x01"));
  CHECK(contains(html, "&lt;script&gt;alert(1)&lt;/script&gt; {{x}} {{{y}}} {{#z}}"));
  CHECK(contains(html, "\xEF\xBF\xBD"));
  for (const std::string& line : synthetic::differences(html, summary)) FAIL_CHECK(line);
}

TEST_CASE("Ten thousand failures do not bury the report: the first are named, the rest counted") {
  const test::TemporaryFolder run;
  ReportData data = synthetic::report_data(run.path());
  std::vector<FailedSample>& failed = data.analysis.results[4].failed;
  failed.assign(10'000, failed.front());
  const std::string summary = summary_json(data);
  const std::string html = html_report(data, nlohmann::ordered_json::parse(summary), run.path());
  CHECK(contains(html, "/results/4/failed/7/replay"));
  CHECK_FALSE(contains(html, "/results/4/failed/8/replay"));
  CHECK(contains(html, ": 9992 more, all of them in summary.json"));
  CHECK(contains(markdown_summary(data, nlohmann::ordered_json::parse(summary_json(data))),
                 " 9992 more failed: summary.json names them all."));
  CHECK(nlohmann::json::parse(summary)["results"][4]["failed"].size() == 10'000);
  for (const std::string& line : synthetic::differences(html, summary)) FAIL_CHECK(line);
}

TEST_CASE("A run with almost nothing in it still has a page") {
  const test::TemporaryFolder run;
  const ReportData data;
  const std::string summary = summary_json(data);
  const std::string html = html_report(data, nlohmann::ordered_json::parse(summary), run.path());
  CHECK(contains(html, "untitled experiment"));
  CHECK(contains(html, "none failed"));
  for (const std::string& line : synthetic::differences(html, summary)) FAIL_CHECK(line);
}

TEST_CASE("A figure that is not there or of another kind is an error") {
  const test::TemporaryFolder run;
  ReportData data;
  data.figures.resize(1);
  data.figures[0].id = "gone";
  data.figures[0].screen = "figures/gone.svg";
  CHECK_THROWS_AS(html_report(data, nlohmann::ordered_json::parse(summary_json(data)), run.path()), InputError);
  data.figures[0].screen = "figures/gone.bmp";
  CHECK_THROWS_AS(html_report(data, nlohmann::ordered_json::parse(summary_json(data)), run.path()), InputError);
}
