#include "report/mustache_page.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>

using namespace granuscope;
using Json = nlohmann::ordered_json;

TEST_CASE("A page is filled and escaped") {
  const Json values = {{"x", "<b> & 'c' \"d\""},
                       {"raw", "<i>"},
                       {"list", {{{"n", "1"}}, {{"n", "2"}}}},
                       {"names", {"a", "b"}},
                       {"yes", true},
                       {"no", false},
                       {"empty", Json::array()},
                       {"cell", {{"text", "t"}}},
                       {"absent", Json::object()}};
  CHECK(fill_page("{{x}}", values) == "&lt;b&gt; &amp; &apos;c&apos; &quot;d&quot;");
  CHECK(fill_page("{{{raw}}}", values) == "<i>");
  CHECK(fill_page("{{#list}}{{n}},{{/list}}", values) == "1,2,");
  CHECK(fill_page("{{#names}}{{.}};{{/names}}", values) == "a;b;");
  CHECK(fill_page("{{#yes}}y{{/yes}}{{#no}}n{{/no}}{{^no}}N{{/no}}{{^empty}}E{{/empty}}", values) == "yNE");
  CHECK(fill_page("{{#cell}}{{text}} {{{raw}}}{{/cell}}{{^absent}}A{{/absent}}{{#absent}}x{{/absent}}", values) ==
        "t <i>A");
}

TEST_CASE("Text that looks like a template stays text") {
  CHECK(fill_page("{{x}}", Json{{"x", "{{y}} {{#z}}"}}) == "{{y}} {{#z}}");
}

TEST_CASE("A key without a value, or a value that does not fit, is an error and not an empty place") {
  CHECK_THROWS_AS(fill_page("{{x}}", Json::object()), std::logic_error);
  CHECK_THROWS_AS(fill_page("{{#x}}a{{/x}}", Json::object()), std::logic_error);
  CHECK_THROWS_AS(fill_page("{{^x}}a{{/x}}", Json::object()), std::logic_error);
  // Visited in each element of a list, not only in the first.
  CHECK_THROWS_AS(fill_page("{{#l}}{{n}}{{/l}}", Json{{"l", {{{"n", "1"}}, {{"m", "2"}}}}}), std::logic_error);
  CHECK_THROWS_AS(fill_page("{{x}}", Json{{"x", 1}}), std::logic_error);
  CHECK_THROWS_AS(fill_page("{{x}}", Json{{"x", {{"y", "z"}}}}), std::logic_error);
  CHECK_THROWS_AS(fill_page("{{#x}}", Json{{"x", true}}), std::logic_error);
  CHECK_THROWS_AS(fill_page("{{#x}}{{/y}}", Json{{"x", true}, {"y", true}}), std::logic_error);
  CHECK_THROWS_AS(fill_page("{{x", Json{{"x", "1"}}), std::logic_error);
}
