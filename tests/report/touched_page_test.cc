// The page as a reader touches it: Chromium shows a copy to which a driver is appended that sends pointer and keyboard
// events and writes down what the page then says.
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "report/fixture.h"
#include "report/made_page.h"
#include "report/page_reader.h"
#include "report/report.h"
#include "report/summary_json.h"
#include "support/files.h"
#include "support/process.h"
#include "support/templates.h"

using namespace granuscope;
using Json = nlohmann::ordered_json;
using test::contains;
using test::count;

namespace {

constexpr const char* tools = R"(
const one = (what) => document.querySelector(what), lines = [];
const value = (name) => one(`[data-value="${name}"]`).textContent;
const tell = (what) => lines.push([what, one('#explore-scanned input:checked').value,
  ...['layer', 'z', 'x_p', 'W', 'chi2', 'c', 'D'].map(value)].join('|'));
const key = (name, to = one('#explore-depth')) =>
  to.dispatchEvent(new KeyboardEvent('keydown', {key: name, bubbles: true, cancelable: true}));
const point = (type, to, x, y) =>
  to.dispatchEvent(new PointerEvent(type, {clientX: x, clientY: y, pointerId: 7, buttons: 1, bubbles: true}));
)";

/// The lines that a driver has written in a window of that size; none where there is no Chromium.
std::vector<std::string> driven(const std::string& html, const std::string& driver, const std::string& size) {
  if (!find_program("chromium")) {
    WARN("no chromium here: the page was not touched");
    return {};
  }
  const test::TemporaryFolder folder;
  write_file(folder / "page.html", html +
                                       "<script>addEventListener('error', (event) => document.title = event.message);"
                                       "addEventListener('load', () => setTimeout(() => {" +
                                       std::string(tools) + driver +
                                       "document.documentElement.innerHTML = '<pre></pre>';"
                                       "one('pre').textContent = lines.join('\\n');}, 50));</script>");
  ProcessSpec process;
  process.arguments = {"chromium",
                       "--headless",
                       "--no-sandbox",
                       "--disable-gpu",
                       "--user-data-dir=" + (folder / "profile").string(),
                       "--window-size=" + size,
                       "--virtual-time-budget=5000",
                       "--dump-dom",
                       "file://" + (folder / "page.html").string()};
  process.environment = {{"HOME", folder.path().string()}, {"LC_ALL", "C.UTF-8"}};
  const std::string shown = run_process(process).standard_output;
  const std::size_t start = shown.find("<pre>"), end = shown.find("</pre>");
  INFO(shown.substr(0, 2000));
  REQUIRE(start != std::string::npos);
  std::istringstream text(shown.substr(start + 5, end - start - 5));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  REQUIRE(!lines.empty());
  return lines;
}

std::vector<std::string> fields_of(const std::string& line) {
  std::istringstream text(line);
  std::vector<std::string> fields;
  for (std::string field; std::getline(text, field, '|');) fields.push_back(field);
  return fields;
}

std::string keyed(const std::string& key, const std::string& text) {
  return "<span data-key=\"" + key + "\">" + text + "</span>";
}

/// What a line of `tell` says, each number with the place of summary.json that it is held against.
std::string keyed_numbers(const std::vector<std::string>& fields, const Json& summary) {
  std::string html;
  for (std::size_t i = 0; i < summary["results"].size(); ++i) {
    const Json& result = summary["results"][i];
    const std::string place = "/results/" + std::to_string(i);
    if (result["mu"].get<double>() != std::stod(fields[1])) continue;
    html += keyed(place + "/c", fields[7]) + (result["D"]["value"].is_null() ? "" : keyed(place + "/D", fields[8]));
    for (std::size_t k = 0; k < result["depths"].size(); ++k) {
      const Json& depth = result["depths"][k];
      if (depth["layer"].dump() != fields[2]) continue;
      const std::string at = place + "/depths/" + std::to_string(k);
      html += keyed(at + "/z", fields[3]);
      if (!depth["identifiable"].get<bool>()) return contains(fields[4], "–") ? html : "";
      html += keyed(at + "/peak_position", fields[4]) + keyed(at + "/width", fields[5]) +
              keyed(at + "/chi2_per_dof", fields[6]);
      return html;
    }
  }
  return "";
}

}  // namespace

TEST_CASE("Arrow keys and pointers go through depths and friction, and the numbers shown are those of summary.json") {
  const MadePage& page = made_page();
  const Json summary = Json::parse(page.summary);
  const std::vector<std::string> lines = driven(page.html, R"(
    tell('first');
    key('Home'); tell('top');
    key('ArrowRight'); key('ArrowUp'); key('ArrowRight'); tell('three down');
    key('ArrowLeft'); tell('one back');
    key('End'); tell('deepest');
    key('PageDown'); tell('ten up');
    one('#explore-depth').value = 5; one('#explore-depth').dispatchEvent(new Event('input')); tell('slid');
    for (const friction of document.querySelectorAll('#explore-scanned input')) {
      friction.click();
      key('Home');
      for (let i = 0; i <= one('#explore-depth').max; ++i) { tell('each'); key('ArrowRight'); }
    }
    const growth = document.querySelectorAll('#explore-plot circle.point')[2].getBoundingClientRect();
    point('pointerdown', one('#explore-plot'), growth.x + growth.width / 2, growth.y); tell('pointed');
    lines.push(document.querySelectorAll('#explore-plot path.fit, #explore-plot path.dot').length);
    point('pointermove', one('#explore-plot'), one('#explore-plot path.dot').getBoundingClientRect().x + 300,
      one('#explore-plot path.dot').getBoundingClientRect().y + 5);
    lines.push(one('#explore-note').textContent);
  )",
                                                "1280,900");
  if (lines.empty()) return;
  std::map<std::string, std::vector<std::string>> told;
  std::set<std::string> seen;
  for (std::size_t i = 0; i + 2 < lines.size(); ++i) {
    INFO(lines[i]);
    const std::vector<std::string> fields = fields_of(lines[i]);
    REQUIRE(fields.size() == 9);
    const std::string html = keyed_numbers(fields, summary);
    CHECK(!html.empty());
    for (const std::string& line : synthetic::differences(html, page.summary)) FAIL_CHECK(line);
    told[fields[0]] = fields;
    seen.insert(fields[1] + " at layer " + fields[2]);
  }
  CHECK(told["top"][2] == "16");
  CHECK(told["three down"][2] == "25");
  CHECK(told["one back"][2] == "22");
  CHECK(told["deepest"][2] == "178");
  CHECK(told["ten up"][2] == "151");
  CHECK(told["slid"][2] == "31");
  CHECK(told["pointed"][2] == "22");
  std::size_t measured = 0;
  for (const Transport& result : page.data.analysis.results) measured += result.exact ? 0 : result.depths.size();
  CHECK(seen.size() == measured);
  CHECK(lines[lines.size() - 2] == "6");  // three panels of the profile, two of them with its fit, and the line of c
  CHECK(contains(lines.back(), "x = "));
}

TEST_CASE("Claims are filtered and ordered, pictures looked at closely, and sections fold on a phone alone") {
  const MadePage& page = made_page();
  const std::string driver = R"(
    const rows = () => [...document.querySelectorAll('table.claims tbody tr:not(.group)')].filter((row) => row.offsetParent)
      .map((row) => row.querySelector('.statement').textContent.slice(0, 12).trim()).join(', ');
    lines.push(rows());
    one('[data-look=yes]').click(); lines.push(rows());
    one('[data-look=""]').click();
    one('#claim-tools select').value = 'name'; one('#claim-tools select').dispatchEvent(new Event('change')); lines.push(rows());
    one('.picture a').click(); lines.push(one('#close-look').open);
    point('pointerdown', one('.view'), 200, 200); point('pointermove', one('.view'), 260, 200); point('pointerup', one('.view'), 260, 200);
    one('[data-do=close]').click(); lines.push(one('#close-look').open);
    const folds = () => [...document.querySelectorAll('details.fold')].filter((one) => one.open).length;
    lines.push(folds());
    dispatchEvent(new Event('beforeprint')); lines.push(folds()); dispatchEvent(new Event('afterprint')); lines.push(folds());
    location.hash = 'claim-c-of-mu'; dispatchEvent(new Event('hashchange')); lines.push(folds());
    lines.push(document.documentElement.scrollWidth <= innerWidth);
  )";
  const std::string all = std::to_string(count(page.html, "class=\"fold"));
  const std::string first = "c₀ − c is pr, c₀ − c grows, Without fric, D grows as μ",
                    misses = "c₀ − c is pr, c₀ − c grows", hits = "Without fric, D grows as μ",
                    by_name = "c₀ − c grows, c₀ − c is pr, D grows as μ, Without fric";
  const std::vector<std::string> desk = driven(page.html, driver, "1280,900");
  if (desk.empty()) return;
  CHECK(desk == std::vector<std::string>{first, hits, by_name, "true", "false", all, all, all, all, "true"});
  const std::vector<std::string> phone = driven(page.html, driver, "500,844");
  CHECK(phone == std::vector<std::string>{misses, hits, by_name, "true", "false", "0", all, "0", "1", "true"});
}

TEST_CASE("Without scripts the page has every table and number, open, and says where the figures are") {
  const MadePage& page = made_page();
  std::string still = page.html;
  for (std::size_t at = still.find("<script"); at != std::string::npos; at = still.find("<script")) {
    still.erase(at, still.find("</script>", at) + 9 - at);
  }
  CHECK(synthetic::keyed_texts(still) == synthetic::keyed_texts(page.html));
  CHECK(count(still, "<table") == count(page.html, "<table"));
  CHECK(count(still, "class=\"fold") == count(still, "class=\"fold\" open") + count(still, "class=\"fold lead\" open"));
  CHECK(count(still, "<noscript>") == 1);
  // What only scripts fill is not there without them: the depths and the choices of claims, without a table in them.
  CHECK(count(still, " hidden>") == 2);
  const std::size_t depths = still.find("id=\"explore\" hidden"), claims = still.find("<table class=\"claims\"");
  REQUIRE(depths < claims);
  CHECK_FALSE(contains(still.substr(depths, claims - depths), "<table"));
  CHECK(template_file("report.js").size() < 60'000);
}

TEST_CASE("A run in which nothing has scatter has no depths to go through") {
  const test::TemporaryFolder run;
  ReportData data = synthetic::report_data(run.path());
  data.analysis.results.resize(1);
  for (ResponseProfile& profile : data.analysis.results[0].profiles) {
    for (double& error : profile.standard_error) error = 1e-17;  // as sums of coupled piles leave it
  }
  const std::string html = html_report(data, Json::parse(summary_json(data)), run.path());
  CHECK_FALSE(contains(html, "id=\"explore-data\""));
  CHECK_FALSE(contains(html, "<noscript>"));
}
