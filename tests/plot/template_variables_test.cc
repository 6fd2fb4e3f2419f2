#include "plot/figure_captions.h"

#include <catch2/catch.hpp>
#include <stdexcept>

using namespace granuscope;

TEST_CASE("Template variables are filled as they stand, sections stay or go") {
  CHECK(fill_template("a {{x}} b", {{"x", "<&'\">"}}) == "a <&'\"> b");
  CHECK(fill_template("{{#x}}yes {{x}}{{/x}}{{^x}}no{{/x}}", {{"x", "1"}}) == "yes 1");
  CHECK(fill_template("{{#x}}yes {{x}}{{/x}}{{^x}}no{{/x}}", {{"x", ""}}) == "no");
  CHECK(fill_template("{{^x}}{{#y}}hidden{{/y}}{{/x}}", {{"x", "1"}, {"y", "1"}}).empty());
}

TEST_CASE("A template and its variables must match") {
  CHECK_THROWS_AS(fill_template("{{x}}", TemplateVariables{}), std::logic_error);
  CHECK_THROWS_AS(fill_template("{{#x}}{{y}}{{/x}}", {{"x", ""}}), std::logic_error);  // also in a hidden section
  CHECK_THROWS_AS(fill_template("text", {{"x", "unasked"}}), std::logic_error);
}
