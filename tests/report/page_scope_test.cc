#include "report/page_scope.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <stdexcept>

#include "support/files.h"

using namespace granuscope;
using Json = nlohmann::ordered_json;

namespace {

const Json summary = Json::parse(R"({
  "seed": 7, "name": "<b> & c_d",
  "results": [
    {"mu": 0.1, "samples": 512, "failed": 0, "exact": false, "window_layers": [60, 120],
     "c": {"value": 0.56048, "stderr": 0.0004}, "D": {"value": 0.00003, "stderr": 0.00001}, "chi2": 12.345},
    {"mu": 0.3, "samples": 256, "failed": 3, "exact": true, "window_layers": [60, 120],
     "c": {"value": null, "stderr": null, "reason": "too few"}, "D": {"value": 0.0, "stderr": 0.0}, "chi2": null}
  ],
  "none": [], "nothing": null, "empty": "", "zero": 0.0, "no": false, "object": {"inner": {"x": -1.5}}
})");

std::string filled(const std::string& text, const Json& overlay = Json::object(), Markup markup = Markup::html) {
  return fill_template(text, PageScope(summary, overlay, markup));
}

TEST_CASE("TeX has every sign of the captions") {
  int captions = 0;
  for (const auto& file : std::filesystem::recursive_directory_iterator(GRANUSCOPE_SOURCE_DIR "/templates")) {
    if (file.path().extension() != ".captions") continue;
    ++captions;
    INFO(file.path());
    const std::string text = read_file(file.path());
    const std::string set = escape_tex(text);
    CHECK(std::ranges::count(set, '?') == std::ranges::count(text, '?'));
  }
  CHECK(captions > 50);
}

}  // namespace

TEST_CASE("A name of summary.json is a cell with its key") {
  CHECK(filled("{{seed}}") == "<span data-key=\"/seed\">7</span>");
  CHECK(filled("{{results/0/c}}") == "<span data-key=\"/results/0/c\">0.56048(40)</span>");
  CHECK(filled("{{results/1/c}}") == "<span data-key=\"/results/1/c\">n/a</span>");
  CHECK(filled("{{results/0/window_layers/1|bare}}") == "120");
  CHECK(filled("{{name|bare}} {{{name}}}") == "&lt;b&gt; &amp; c_d <b> & c_d");
  CHECK(filled("{{name}} {{results/0/mu}}", Json::object(), Markup::markdown) == "&lt;b\\> &amp; c\\_d 0.1");
}

TEST_CASE("Formats stand behind bars") {
  CHECK(filled("{{results/0/D|bare}} {{results/0/D|plain|bare}}") == "3.0(1.0) × 10⁻⁵ 0.000030(10)");
  CHECK(
      filled("{{results/0/chi2|fixed 1|bare}} {{results/0/chi2|significant 2|bare}} {{results/1/chi2|fixed 1|bare}}") ==
      "12.3 12 n/a");
  CHECK(filled("{{object/inner/x|fixed 2}}") == "<span data-key=\"/object/inner/x\">−1.50</span>");
  CHECK(filled("{{results/0/c|key}}") == "/results/0/c");
  CHECK(filled("{{text|formulae}}", {{"text", "so x = 1 < 2"}}) ==
        "so <span class=\"formula-text\">x = 1</span> &lt; 2");
  CHECK(filled("{{results/0/mu|class main}}") == "<span class=\"main\" data-key=\"/results/0/mu\">0.1</span>");
  CHECK(filled("{{text|words}}", {{"text", "a b-c"}}) == "a <span class=\"word\">b-c</span>");
  CHECK_THROWS_AS(filled("{{results/0/c|fixed 2}}"), std::logic_error);
  CHECK_THROWS_AS(filled("{{seed|fixed}}"), std::logic_error);
  CHECK_THROWS_AS(filled("{{seed|hexadecimal}}"), std::logic_error);
}

TEST_CASE("A condition is written once, at the same place, or not") {
  CHECK(filled("{{#results}}{{#mu<0.2}}{{mu|bare}}{{/mu<0.2}}{{#failed>2}} many{{/failed>2}}{{/results}}") ==
        "0.1 many");
  CHECK(filled("{{#seed=7}}a{{/seed=7}}{{#seed!=7}}b{{/seed!=7}}{{^seed=8}}c{{/seed=8}}") == "ac");
  CHECK(filled("{{#law!=granusolve?}}a{{/law!=granusolve}}{{^law=granusolve?}}b{{/law=granusolve}}") == "b");
  CHECK(filled("{{#results}}{{#known c D}}{{mu|key}}{{/known c D}}{{/results}}") == "/results/0/mu");
  CHECK(filled("{{#any none}}a{{/any none}}{{^any none}}b{{/any none}}{{#any results}}{{seed|bare}}{{/any results}}") ==
        "b7");
  CHECK(filled("{{#any results known c}}a{{/any results known c}}{{#any none known c}}b{{/any none known c}}") == "a");
  for (const char* wrong : {"{{#laws=a}}{{/laws=a}}", "{{#known E}}{{/known E}}", "{{#any laws}}{{/any laws}}",
                            "{{#any results known E}}{{/any results known E}}", "{{#name>1}}{{/name>1}}",
                            "{{#every results}}{{/every results}}", "{{#any results of c}}{{/any results of c}}"}) {
    CHECK_THROWS_AS(filled(wrong), std::logic_error);
  }
}

TEST_CASE("Names are relative to the section they stand in") {
  CHECK(filled("{{#results}}{{mu|bare}} of {{$/seed|bare}} and {{../seed|key}}, {{/results}}") ==
        "0.1 of 7 and /seed, 0.3 of 7 and /seed, ");
  CHECK(filled("{{#results/0/window_layers}}{{.|bare}} {{.|key}};{{/results/0/window_layers}}") ==
        "60 /results/0/window_layers/0;120 /results/0/window_layers/1;");
  CHECK(filled("{{#object}}{{#inner}}{{x|key}}{{/inner}}{{/object}}") == "/object/inner/x");
  CHECK_THROWS_AS(filled("{{#results}}{{seed}}{{/results}}"), std::logic_error);  // not found by going outwards
  CHECK_THROWS_AS(filled("{{../seed}}"), std::logic_error);
}

TEST_CASE("A section asks whether something is there") {
  for (const char* nothing :
       {"none", "nothing", "empty", "no", "results/0/failed", "results/1/chi2", "results/1/c/value"}) {
    INFO(nothing);
    const std::string name = nothing;
    CHECK(filled("{{#" + name + "}}there{{/" + name + "}}{{^" + name + "}}not{{/" + name + "}}") == "not");
  }
  CHECK(filled("{{#results/1/failed}}{{results/1/failed|bare}}{{/results/1/failed}}") == "3");  // at the same place
  CHECK(filled("{{#zero}}measured{{/zero}}") == "measured");
  CHECK(filled("{{#results/0/reason?}}a{{/results/0/reason}}{{^results/0/reason?}}b{{/results/0/reason}}") == "b");
  CHECK(filled("{{#word=one}}1{{/word=one}}{{#word=two}}2{{/word=two}}{{^word=one}}not 1{{/word=one}}",
               {{"word", "two"}}) == "2not 1");
  CHECK_THROWS_AS(filled("{{#results/0/reason}}a{{/results/0/reason}}"), std::logic_error);
}

TEST_CASE("The overlay is looked up first and needs no key") {
  const Json overlay = Json::parse(R"({
    "time": "< 1 s", "yes": true, "count": 3, "seed": 8,
    "results": [{"first": true, "law": "a_b"}, {"first": false, "law": ""}],
    "notes": [{"what": "c & D", "reason": {"key": "/results/1/c/reason"}}, {"what": "n", "reason": {"key": "/name"}}],
    "chosen": [{"key": "/results/1", "mark": "*"}],
    "D": {"key": "/results/1/D", "text": "exactly 0"}
  })");
  CHECK(filled("{{time}} {{{time}}} {{count}} {{seed}}", overlay) == "&lt; 1 s < 1 s 3 8");
  CHECK(filled("{{#results}}{{#first}}{{mu|bare}} {{law}}{{/first}}{{/results}}", overlay) == "0.1 a_b");
  CHECK(filled("{{#notes}}{{what}}: {{reason}};{{/notes}}", overlay) ==
        "c &amp; D: <span data-key=\"/results/1/c/reason\">too few</span>;"
        "n: <span data-key=\"/name\">&lt;b&gt; &amp; c_d</span>;");
  CHECK(filled("{{#chosen}}{{mu|key}}{{mark}}{{#window_layers}}{{.|bare}} {{/window_layers}}{{/chosen}}", overlay) ==
        "/results/1/mu*60 120 ");
  CHECK(filled("{{D}} {{D/value|bare}}", overlay) == "<span data-key=\"/results/1/D\">exactly 0</span> 0");
  CHECK_THROWS_AS(filled("{{yes}}", overlay), std::logic_error);
  CHECK_THROWS_AS(filled("{{#results}}{{/results}}", Json{{"results", {{{"first", true}}}}}), std::logic_error);
  CHECK_THROWS_AS(filled("{{x}}", Json{{"x", {{"key", "/no/such/place"}}}}), std::logic_error);
}

TEST_CASE("An overlay text that looks like a template or holds control characters stays text") {
  CHECK(filled("{{x}}", {{"x", "{{y}} {{#z}}\x01"}}) == "{{y}} {{#z}}\xEF\xBF\xBD");
}
