#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "kit/text_parts.h"
#include "report/clean_json.h"
#include "report/number_text.h"
#include "report/pdf_report.h"
#include "support/plain_text.h"

using namespace granuscope;
using Json = nlohmann::ordered_json;

TEST_CASE("Numbers of a column keep plain digits however small they are") {
  const auto summary = nlohmann::ordered_json::parse(
      R"({"a": {"value": -2.3e-5, "stderr": 1.2e-5}, "b": {"value": null, "stderr": null}})");
  CHECK(format_number(summary["a"]) == "−2.3(1.2) × 10⁻⁵");
  CHECK(format_number(summary["a"], "plain") == "−0.000023(12)");
  CHECK(format_number(summary["b"], "plain") == "n/a");
}

TEST_CASE("Clean text is valid UTF-8 without control characters") {
  CHECK(clean_text("plain μ − 例 😀\n\ttab") == "plain μ − 例 😀\n\ttab");
  const std::string bad = "\xEF\xBF\xBD";
  CHECK(clean_text("a\xFF"
                   "b") == "a" + bad + "b");
  CHECK(clean_text("\xC3(") == bad + "(");
  CHECK(clean_text("\xE2\x88") == bad + bad);                      // cut off
  CHECK(clean_text("\xC0\xAF") == bad + bad);                      // overlong '/'
  CHECK(clean_text("\xED\xA0\x80") == bad + bad + bad);            // a surrogate
  CHECK(clean_text("\xF4\x90\x80\x80") == bad + bad + bad + bad);  // beyond U+10FFFF
  CHECK(clean_text(std::string("a\0b", 3)) == "a" + bad + "b");
  CHECK(clean_text("\x1b[31m") == bad + "[31m");
  CHECK(clean_text("\xC2\x85") == bad);  // NEL
  CHECK(clean_text("a\r\nb\rc") == "a\nb\nc");
}

TEST_CASE("Every byte string becomes text that JSON can hold") {
  // Source of the expectation: nlohmann's dump throws on invalid UTF-8 by default.
  for (int first = 0; first < 256; ++first) {
    for (int second = 0; second < 256; second += 5) {
      Json json = std::string{static_cast<char>(first), static_cast<char>(second), '\xA0', 'x'};
      clean_strings(json);
      CHECK_NOTHROW(json.dump());
    }
  }
}

TEST_CASE("Markup is escaped in content and attributes") {
  CHECK(escape_markup("<a href=\"x\">'&'</a>") == "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
}

TEST_CASE("Base64 follows RFC 4648") {
  // The test vectors of section 10 of the RFC.
  CHECK(base64("").empty());
  CHECK(base64("f") == "Zg==");
  CHECK(base64("fo") == "Zm8=");
  CHECK(base64("foo") == "Zm9v");
  CHECK(base64("foob") == "Zm9vYg==");
  CHECK(base64("fooba") == "Zm9vYmE=");
  CHECK(base64("foobar") == "Zm9vYmFy");
  CHECK(base64("\xFF\xFE") == "//4=");
  CHECK(data_uri("image/png", "f") == "data:image/png;base64,Zg==");
  CHECK(text_uri("text/csv", "μ,50% \"a#b\"\n<&:\t'") == "data:text/csv,μ,50%25%20%22a%23b%22%0A%3C%26%3A%09'");
}

TEST_CASE("The width of a PNG follows from its pixels and its resolution") {
  using namespace std::string_literals;
  const std::string signature = "\x89PNG\r\n\x1a\n"s;
  const std::string header = "\0\0\0\x0dIHDR\0\0\x06\x40\0\0\x04\xb0\x08\2\0\0\0crc."s;  // 1600 x 1200
  const std::string resolution = "\0\0\0\x09pHYs\0\0\x2e\x23\0\0\x2e\x23\1crc."s;        // 11811 per metre: 300 dpi
  const std::string end = "\0\0\0\0IDATcrc."s;
  REQUIRE(png_width_mm(signature + header + resolution + end));
  CHECK(*png_width_mm(signature + header + resolution + end) == Approx(25.4 * 1600 / 300).epsilon(1e-4));
  CHECK_FALSE(png_width_mm(signature + header + end));
  CHECK_FALSE(png_width_mm(signature + "\xff\xff\xff\xffIHDR"s));
  CHECK_FALSE(png_width_mm("<svg>"));
}

TEST_CASE("Formulae in captions stay on one line and keep their text") {
  CHECK(unbroken_formulae("at μ = 0.3 and c₀ − c < 1") ==
        "at <span class=\"formula-text\">μ = 0.3</span> and <span class=\"formula-text\">c₀ − c</span> &lt; 1");
  CHECK(unbroken_formulae("a = b − c, d") == "<span class=\"formula-text\">a = b − c,</span> d");
  CHECK(unbroken_formulae("if D ∝ μᵝ") == "if <span class=\"formula-text\">D ∝ μᵝ</span>");
  CHECK(unbroken_formulae("la pente : 1") == "la <span class=\"formula-text\">pente :</span> 1");
  CHECK(unbroken_formulae("no formula").find("span") == std::string::npos);
  CHECK(unbroken_formulae("falls as 1/√z.") == "falls as <span class=\"formula-text\">1/√z.</span>");
  CHECK(unbroken_formulae("the ratio xₚ/z = 3 and") == "the ratio <span class=\"formula-text\">xₚ/z = 3</span> and");
  CHECK(unbroken_formulae("piles of 70 × 60") == "piles of <span class=\"formula-text\">70 × 60</span>");
  CHECK(unbroken_formulae("figures/response-profiles.svg").find("span") == std::string::npos);
  CHECK(unbroken_formulae("2.0 (20 % off)") == "2.0 <span class=\"formula-text\">(20 %</span> off)");
  CHECK(unbroken_formulae("ends with =") == "ends <span class=\"formula-text\">with =</span>");
  CHECK(unbroken_formulae("").empty());
}

TEST_CASE("Commands break at spaces only") {
  CHECK(unbroken_words("render --width 3 <a-b>") ==
        "render <span class=\"word\">--width</span> 3 <span class=\"word\">&lt;a-b&gt;</span>");
  CHECK(unbroken_words(std::string(61, '-')) == std::string(61, '-'));
}

TEST_CASE("Numbers of the report are written from the summary") {
  const Json summary = {{"c", {{"value", 0.07923}, {"stderr", 0.0041}}},
                        {"unknown", {{"value", nullptr}, {"stderr", nullptr}, {"reason", "why"}}},
                        {"mu", 0.3},
                        {"count", 3456},
                        {"seed", 18446744073709551615ULL},
                        {"z", -12.345},
                        {"name", "text"},
                        {"none", nullptr},
                        {"list", {1, 2}}};
  CHECK(format_number(summary["c"]) == "0.0792(41)");
  CHECK(format_number(summary["unknown"]) == "n/a");
  CHECK(format_number(summary["mu"]) == "0.3");
  CHECK(format_number(summary["count"]) == "3456");
  CHECK(format_number(summary["seed"]) == "18446744073709551615");
  CHECK(format_number(summary["z"]) == "−12.35");
  CHECK(format_number(summary["name"]) == "text");
  CHECK(format_number(summary["none"]) == "n/a");
  CHECK(format_number(summary["z"], "fixed 1") == "−12.3");
  CHECK(format_number(summary["none"], "fixed 1") == "n/a");
  CHECK_THROWS_AS(format_number(summary["list"]), std::logic_error);
}

TEST_CASE("Exponents that no power law has are exported without an error, those that claims are judged by, too") {
  const Json summary = {{"results", Json::array()},
                        {"scaling", {{"gamma", {{"value", 1.65}, {"stderr", 0.03}, {"power_law", false}}}}},
                        {"claims",
                         {{{"id", "c-of-mu"}, {"measured", 1.65}, {"stderr", 0.03}, {"power_law", false}},
                          {{"id", "D-of-mu"}, {"measured", 2.54}, {"stderr", 0.04}}}}};
  const Json numbers = Json::parse(list_numbers(summary.dump(), "json", {}));
  CHECK(numbers["gamma"]["stderr"].is_null());
  CHECK(numbers["claims/c-of-mu/measured"]["stderr"].is_null());
  CHECK(numbers["claims/D-of-mu/measured"]["stderr"] == 0.04);
}

TEST_CASE("An unknown number is listed as such, with its reason for TeX, which would stop at it") {
  const Json unknown = {{"value", nullptr}, {"stderr", nullptr}, {"reason", "too few\npiles"}};
  const Json summary = {
      {"results", {{{"mu", 0.1}, {"c", unknown}}, {{"mu", 0.3}, {"c", {{"value", 0.56}, {"stderr", 0.01}}}}}}};
  const Json again = {
      {"results", {{{"mu", 0.3}, {"c", {{"value", 0.5}, {"stderr", 0.1}}}}, {{"mu", 0.3}, {"c", unknown}}}}};
  const Json both = Json::parse(list_numbers(again.dump(), "json", {.all = true, .only = {"c"}}));
  CHECK(both["mu-0.3/c"]["value"] == 0.5);  // not replaced by an unknown one of the same name
  CHECK(both["mu-0.3/c/2"]["value"].is_null());
  const NumberChoice c = {.only = {"c"}};
  const Json numbers = Json::parse(list_numbers(summary.dump(), "json", c));
  CHECK(numbers.size() == 2);
  CHECK(numbers["mu-0.1/c"]["value"].is_null());
  CHECK(list_numbers(summary.dump(), "csv", c) ==
        "name,value,standard_error,text\nmu-0.1/c,nan,nan,n/a\nmu-0.3/c,0.56,0.01,0.560(10)\n");
  const std::string tex = list_numbers(summary.dump(), "tex", c);
  CHECK(test::contains(tex, "\n% mu-0.1/c is unknown: too few piles\n"));
  CHECK_FALSE(test::contains(tex, "detokenize{mu-0.1/c}"));
}
