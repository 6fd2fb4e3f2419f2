// The page as a reader touches it: Chromium shows a copy to which a driver is appended that sends pointer and keyboard
// events and writes down what the page then says.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
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
#include "report/touched_pile.h"
#include "sampling/sampler.h"
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

/// Chromium without a window, told to do what `arguments` say.
ProcessSpec chromium(const test::TemporaryFolder& folder, const std::vector<std::string>& arguments) {
  ProcessSpec process;
  process.arguments = {"chromium", "--headless", "--no-sandbox", "--disable-gpu",
                       "--user-data-dir=" + (folder / "profile").string()};
  process.arguments.insert(process.arguments.end(), arguments.begin(), arguments.end());
  process.environment = {{"HOME", folder.path().string()}, {"LC_ALL", "C.UTF-8"}};
  return process;
}

/// The lines that a driver has written in a window of that size; none where there is no Chromium.
std::vector<std::string> driven(const std::string& html, const std::string& driver, const std::string& size,
                                bool dark = false) {
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
  const std::string shown =
      run_process(chromium(folder, {dark ? "--force-dark-mode" : "--disable-features=WebContentsForceDark",
                                    "--window-size=" + size, "--virtual-time-budget=5000", "--dump-dom",
                                    "file://" + (folder / "page.html").string()}))
          .standard_output;
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

TEST_CASE("Arrow keys and pointers go through depths and friction, and the numbers shown are those of summary.json",
          "[unsanitized]") {
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
  std::string all;
  for (std::size_t i = 0; i + 2 < lines.size(); ++i) {
    INFO(lines[i]);
    const std::vector<std::string> fields = fields_of(lines[i]);
    REQUIRE(fields.size() == 9);
    const std::string html = keyed_numbers(fields, summary);
    CHECK(!html.empty());
    all += html;
    told[fields[0]] = fields;
    seen.insert(fields[1] + " at layer " + fields[2]);
  }
  for (const std::string& line : synthetic::differences(all, page.summary)) FAIL_CHECK(line);
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

TEST_CASE("Claims are filtered and ordered, pictures looked at closely, and sections fold on a phone alone",
          "[unsanitized]") {
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
    const fold = one('details.fold'); fold.open = false; lines.push(fold.lastElementChild.checkVisibility({contentVisibilityAuto: true}));
  )";
  const std::string all = std::to_string(count(page.html, "class=\"fold"));
  const std::string first = "c₀ − c is pr, c₀ − c grows, Without fric, D grows as μ",
                    misses = "c₀ − c is pr, c₀ − c grows", hits = "Without fric, D grows as μ",
                    by_name = "c₀ − c grows, c₀ − c is pr, D grows as μ, Without fric";
  const std::vector<std::string> desk = driven(page.html, driver, "1280,900");
  if (desk.empty()) return;
  CHECK(desk == std::vector<std::string>{first, hits, by_name, "true", "false", all, all, all, all, "true", "false"});
  const std::vector<std::string> phone = driven(page.html, driver, "500,844");
  CHECK(phone == std::vector<std::string>{misses, hits, by_name, "true", "false", "0", all, "0", "1", "true", "false"});
}

TEST_CASE("Who cannot see or point finds names, an order of headings and contrasts, light and dark, wide and narrow",
          "[unsanitized]") {
  // What axe-core, which Debian does not package, asks of a page, as far as this page has it.
  const std::string driver = R"(
    document.querySelectorAll('details').forEach((one) => { one.open = true; });
    const shown = [...document.body.querySelectorAll('*')].filter((one) => one.getClientRects().length);
    const say = (what, one) => lines.push(what + ': ' + one.outerHTML.slice(0, 120));
    const ids = [...document.querySelectorAll('[id]')].map((one) => one.id);
    ids.filter((id, i) => ids.indexOf(id) !== i).forEach((id) => lines.push('twice: ' + id));
    for (const link of document.querySelectorAll('a[href^="#"], [aria-labelledby]')) {
      const to = link.getAttribute('aria-labelledby') || decodeURIComponent(link.getAttribute('href').slice(1));
      if (!document.getElementById(to)) say('leads nowhere', link);
    }
    let level = 0;
    for (const heading of shown.filter((one) => /^H[1-6]$/.test(one.tagName))) {
      if (Number(heading.tagName[1]) > level + 1) say('skips a level', heading);
      level = Number(heading.tagName[1]);
    }
    for (const one of shown) {
      const named = one.textContent.trim() || one.getAttribute('aria-label') || one.title || (one.labels && one.labels.length);
      if (['A', 'BUTTON', 'INPUT', 'SELECT', 'SUMMARY'].includes(one.tagName) && !named && !one.querySelector('img[alt]')) say('has no name', one);
      if (one.tagName === 'IMG' && !one.alt) say('has no text', one);
      if (one.getAttribute('role') === 'img' && !one.getAttribute('aria-label')) say('has no text', one);
      if (one.scrollWidth > one.clientWidth + 1 && getComputedStyle(one).overflowX === 'auto' && one.tabIndex < 0) say('scrolls for pointers alone', one);
    }
    const colour = (text) => { const [r, g, b, a = 1] = text.match(/[\d.]+/g).map(Number); return {rgb: [r, g, b], a}; };
    const light = ({rgb}) => rgb.map((v) => v / 255).map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
      .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
    let texts = 0;
    for (const one of shown) {
      if (one.closest('svg') || ![...one.childNodes].some((node) => node.nodeType === 3 && node.data.trim())) continue;
      let ground = one;
      while (ground && colour(getComputedStyle(ground).backgroundColor).a < 1) ground = ground.parentElement;
      const [a, b] = [light(colour(getComputedStyle(one).color)), light(colour(getComputedStyle(ground || document.body).backgroundColor))];
      if ((Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05) < 4.5) say('is hard to read', one);
      ++texts;
    }
    lines.push(matchMedia('(prefers-color-scheme: dark)').matches + ' ' + (texts > 300));
  )";
  for (const char* size : {"1280,900", "500,844"}) {
    for (const bool dark : {false, true}) {
      const std::vector<std::string> lines = driven(made_page().html, driver, size, dark);
      if (lines.empty()) return;
      INFO(size << (dark ? ", dark" : ", light"));
      CHECK(lines == std::vector<std::string>{dark ? "true true" : "false true"});
    }
  }
}

TEST_CASE("Without scripts the page has every table and number, folded on a phone alone, and says where figures are",
          "[unsanitized]") {
  const MadePage& page = made_page();
  std::string still = page.html;
  for (std::size_t at = still.find("<script"); at != std::string::npos; at = still.find("<script")) {
    still.erase(at, still.find("</script>", at) + 9 - at);
  }
  CHECK(synthetic::keyed_texts(still) == synthetic::keyed_texts(page.html));
  CHECK(count(still, "<table") == count(page.html, "<table"));
  CHECK(count(still, "<noscript>") == 1);
  // What only scripts fill is not there without them: the depths, the choices of claims, what a point says, its ring,
  // and the layers of a pile, without a table in them.
  CHECK(count(still, " hidden>") == 5);
  const std::size_t depths = still.find("id=\"explore\" hidden"), claims = still.find("<table class=\"claims\"");
  REQUIRE(depths < claims);
  CHECK_FALSE(contains(still.substr(depths, claims - depths), "<table"));
  CHECK(template_file("report.js").size() < 60'000);

  // In a frame that runs no script.
  std::string quoted;
  for (const char c : still) quoted += c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
  std::vector<std::string> lines;
  for (const char* width : {"390", "1280"}) {
    const auto seen =
        driven("<iframe sandbox=\"allow-same-origin\" style=\"border: 0; height: 844px; width: " + std::string(width) +
                   "px\" srcdoc=\"" + quoted + "\"></iframe>",
               R"(
      const page = one('iframe').contentDocument, folds = [...page.querySelectorAll('details.fold')];
      const inside = folds.map((fold) => fold.lastElementChild.checkVisibility({contentVisibilityAuto: true}));
      const before = page.querySelector('table.claims').getBoundingClientRect().bottom <= folds[0].getBoundingClientRect().y;
      const screens = page.documentElement.scrollHeight / 844, first = page.querySelector('details.fold summary');
      lines.push(inside.filter(Boolean).length, page.documentElement.scrollWidth <= page.documentElement.clientWidth, before, screens <= 12 && screens > 2);
      first.click();
      lines.push(folds[0].open && folds[0].lastElementChild.checkVisibility());
    )",
               "1400,900");
    lines.insert(lines.end(), seen.begin(), seen.end());
  }
  if (lines.empty()) return;
  const std::string all = std::to_string(count(still, "class=\"fold"));
  CHECK(lines == std::vector<std::string>{"0", "true", "true", "true", "true", all, "true", "true", "false", "true"});

  const test::TemporaryFolder folder;
  write_file(folder / "still.html", still);
  run_process(chromium(folder, {"--no-pdf-header-footer", "--print-to-pdf=" + (folder / "still.pdf").string(),
                                "file://" + (folder / "still.html").string()}));
  ProcessSpec reader;
  reader.arguments = {"pdftotext", (folder / "still.pdf").string(), "-"};
  reader.environment = {{"LC_ALL", "C.UTF-8"}};
  const std::string printed = run_process(reader).standard_output;
  for (const char* part : {"Redraw", "The model.", "fitted on logarithmic axes", "What sampling and fitting took"}) {
    INFO(part);
    CHECK(contains(printed, part) == (std::string(part) != "Redraw"));
  }
}

TEST_CASE("A point of a plot says the numbers of its row, where the row stands, and the command that draws it",
          "[unsanitized]") {
  const MadePage& page = made_page();
  const std::vector<std::string> lines = driven(page.html, R"(
    for (const link of document.querySelectorAll('.picture a')) {
      const image = link.querySelector('img'), source = image.currentSrc || image.src, box = image.getBoundingClientRect();
      if (!source.startsWith('data:image/svg')) continue;
      const svg = new DOMParser().parseFromString(decodeURIComponent(source.slice(source.indexOf(',') + 1)), 'image/svg+xml'), edge = parseFloat(getComputedStyle(image).paddingLeft) + 1;
      const [, , width, height] = svg.documentElement.getAttribute('viewBox').split(' ').map(Number);
      for (const mark of svg.querySelectorAll('g[id^=gnuplot_plot_] use')) {
        const title = mark.closest('[id^=gnuplot]').querySelector('title').textContent;
        if (!title.startsWith('data ')) continue;
        const [x, y] = /translate\(([^,]*),([^)]*)/.exec(mark.getAttribute('transform')).slice(1).map(Number);
        point('pointermove', link, box.x + edge + x / width * (box.width - 2 * edge), box.y + edge + y / height * (box.height - 2 * edge));
        lines.push([title.split(' | ')[0], ...['b', 'span', 'code', 'i'].map((part) => one('#point-tip ' + part).textContent)].join('|'));
      }
      link.focus();
      link.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowRight', bubbles: true}));
      lines.push('key|' + !one('#point-tip').hidden);
      link.dispatchEvent(new PointerEvent('pointerleave'));
      lines.push('left|' + one('#point-tip').hidden);
    }
  )",
                                                "1280,900");
  if (lines.empty()) return;
  std::map<std::string, std::size_t> told;
  for (const std::string& line : lines) {
    INFO(line);
    const std::vector<std::string> fields = fields_of(line);
    if (fields[0] == "key" || fields[0] == "left") {
      CHECK(fields.at(1) == "true");
      continue;
    }
    REQUIRE(fields.size() == 5);
    // Which series, and where: a friction coefficient, a depth, or the layer of the series.
    CHECK(fields[4].size() > 1);
    const std::string place = fields[4] + ", " + fields[1];
    CHECK((contains(place, "μ = ") || contains(place, "z = ") || contains(place, "layer ")));
    // "figures/NAME.csv:7", and each number shown is one of that line, or half of what lies between two of them.
    const std::size_t colon = fields[2].find(':');
    std::istringstream table(read_file(page.run / fields[2].substr(0, colon)));
    std::string row;
    for (int k = std::stoi(fields[2].substr(colon + 1)); k > 0; --k) REQUIRE(std::getline(table, row));
    std::vector<double> cells;
    std::istringstream values(row);
    for (std::string cell; std::getline(values, cell, ',');) cells.push_back(std::atof(cell.c_str()));
    for (std::size_t at = fields[1].find("= "); at != std::string::npos; at = fields[1].find("= ", at + 1)) {
      std::string number = fields[1].substr(at + 2);
      const bool negative = number.starts_with("\xE2\x88\x92");
      if (negative) number.erase(0, 3);
      const double shown = (negative ? -1 : 1) * std::atof(number.c_str());
      const std::size_t power = number.substr(0, number.find(", ")).find("× 10");
      const auto shows = [&](double cell) {
        const double unit = power == std::string::npos ? 1 : std::pow(10, std::floor(std::log10(std::abs(cell))));
        const std::size_t end = number.find_first_not_of("0123456789."), point = number.substr(0, end).find('.');
        const double decimals = point == std::string::npos ? 0 : static_cast<double>(end - point) - 1;
        return std::abs(cell / unit - shown) <= std::max(0.51 * std::pow(10, -decimals), 1e-5 * std::abs(shown));
      };
      CHECK(std::ranges::any_of(cells, shows));
    }
    CHECK(contains(fields[3], "gnuplot -d "));
    ++told[fields[0]];
  }
  CHECK(told.size() >= 8);
}

TEST_CASE("A pile is looked at in layers, and a bead says its weight, its response and its contacts", "[unsanitized]") {
  const MadePage& page = made_page();
  SamplerSpec spec;
  spec.mu = 0.3;
  const Lattice lattice({20, 30});
  Pile pile(lattice), loaded(lattice);
  const auto sampler = make_sampler(spec, lattice);
  std::vector<double> load(20, 1.0);
  REQUIRE_FALSE(sampler->draw(3, load, pile));
  load[10] = 2;
  REQUIRE_FALSE(sampler->draw_again(3, load, pile, loaded));
  ReportData data = page.data;
  for (Figure& figure : data.figures) {
    if (figure.id == "force-chains") figure.touched = touched_pile(loaded, &loaded, &pile, 10);
  }
  const std::vector<std::string> lines = driven(html_report(data, Json::parse(page.summary), page.run.path()), R"(
    one('.touch button').click();
    const canvas = one('#close-look canvas'), box = canvas.getBoundingClientRect();
    const seen = () => { let sum = 0; canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.forEach((v, i) => { sum = (sum * 31 + v) % 1e9; }); return sum; };
    const looks = [seen()];
    for (const layer of document.querySelectorAll('#close-look .layers input')) {
      layer.checked = !layer.checked; layer.dispatchEvent(new Event('change', {bubbles: true}));
      looks.push(seen());
    }
    lines.push(one('#close-look').open, new Set(looks).size);
    for (const part of [0.5, 0.6, 0.7]) {
      point('pointermove', one('#close-look .view'), box.x + part * box.width, box.y + part * box.height);
      lines.push(one('#point-tip b').textContent + ' ' + one('#point-tip span').textContent);
    }
  )",
                                                "1280,900");
  if (lines.empty()) return;
  REQUIRE(lines.size() == 5);
  CHECK(lines[0] == "true");
  CHECK(lines[1] == "5");
  for (const std::size_t k : {2, 3, 4}) {
    INFO(lines[k]);
    double x = 0, z = 0, weight = 0, response = 0;
    std::string plain = lines[k];
    for (std::size_t at = plain.find("\xE2\x88\x92"); at != std::string::npos; at = plain.find("\xE2\x88\x92"))
      plain.replace(at, 3, "-");
    REQUIRE(std::sscanf(plain.c_str(), "x = %lf, z = %lf: weight %lf, response %lf", &x, &z, &weight, &response) == 4);
    const int layer = static_cast<int>(std::lround((z - 0.5) / 0.8660254));
    int bead = 0;
    while (bead < 20 && lattice.x(layer, bead) != x) ++bead;
    REQUIRE(bead < 20);
    const std::size_t i = lattice.index(layer, bead);
    CHECK(weight == Approx(loaded.V_R[i] + loaded.V_L[i]).margin(0.006));
    CHECK(response == Approx(loaded.V_R[i] + loaded.V_L[i] - pile.V_R[i] - pile.V_L[i]).margin(0.006));
  }
}

TEST_CASE("Piles beyond what a page has room for are not looked at in it") {
  const Pile pile{Lattice({200, 100})};
  CHECK(touched_pile(pile, nullptr, nullptr, 51).empty());
  CHECK_FALSE(touched_pile(pile, nullptr, nullptr, 50).empty());
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
