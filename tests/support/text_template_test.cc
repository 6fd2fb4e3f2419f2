#include "support/templates.h"

#include <catch2/catch.hpp>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

using namespace granuscope;

namespace {

/// Texts, and lists of further scopes, by name; escaping writes <text>.
struct Words : TemplateScope {
  using Texts = std::map<std::string, std::string>;
  Texts texts;
  std::map<std::string, std::vector<Words>> lists = {};
  mutable std::vector<std::string> passed_over = {};

  explicit Words(Texts the_texts, std::map<std::string, std::vector<Words>> the_lists = {})
      : texts(std::move(the_texts)), lists(std::move(the_lists)) {}

  std::string raw_text(const std::string& name) const override {
    if (!texts.contains(name)) throw std::logic_error("no text for " + name);
    return texts.at(name);
  }
  std::string text(const std::string& name) const override { return "<" + raw_text(name) + ">"; }
  void enter(const std::string& name, Missing missing, const Write& write) const override {
    if (lists.contains(name)) {
      for (const Words& words : lists.at(name)) write(words);
    } else if (texts.contains(name)) {
      if (!texts.at(name).empty()) write(*this);
    } else if (missing == Missing::is_an_error) {
      throw std::logic_error("no section " + name);
    }
  }
  void pass_over(const std::string& name) const override { passed_over.push_back(name); }
};

}  // namespace

TEST_CASE("Names are filled in, escaped or as they stand") {
  const Words words(Words::Texts{{"x", "a"}});
  CHECK(fill_template("1 {{x}} {{{x}}} {{ x }} {'{{x}}'} 2", words) == "1 <a> a <a> {'<a>'} 2");
  CHECK(fill_template("{{! nobody sees this {{x}}", words).empty());
  CHECK(fill_template("", words).empty());
}

TEST_CASE("Sections stay, go, repeat and nest") {
  const Words words(Words::Texts{{"x", "1"}, {"y", ""}},
                    {{"rows", {Words(Words::Texts{{"n", "1"}}), Words(Words::Texts{{"n", "2"}})}}, {"none", {}}});
  CHECK(fill_template("{{#x}}yes {{x}}{{/x}}{{^x}}no{{/x}}", words) == "yes <1>");
  CHECK(fill_template("{{#y}}yes{{/y}}{{^y}}no{{/y}}", words) == "no");
  CHECK(fill_template("{{#x}}{{#y}}both{{/y}}{{^y}}x{{/y}}{{/x}}", words) == "x");
  CHECK(fill_template("{{^y}}{{#x}}x{{/x}}{{/y}}{{^x}}{{#x}}hidden{{/x}}{{/x}}", words) == "x");
  CHECK(fill_template("{{#rows}}{{n}},{{/rows}}{{^rows}}none{{/rows}}", words) == "<1>,<2>,");
  CHECK(fill_template("{{#none}}x{{/none}}{{^none}}none{{/none}}", words) == "none");
}

TEST_CASE("A tag that writes nothing itself, alone on a line, leaves no empty line") {
  CHECK(fill_template("a\n{{#x}}\nb\n{{/x}}\nc\n", Words(Words::Texts{{"x", "1"}})) == "a\nb\nc\n");
  CHECK(fill_template("a\n{{#x}}\nb\n{{/x}}\nc\n", Words(Words::Texts{{"x", ""}})) == "a\nc\n");
  CHECK(fill_template("a\n{{! b }}\nc {{! d }}\n", Words(Words::Texts{})) == "a\nc \n");
  CHECK(fill_template("{{x}}\n{{x}}\n", Words(Words::Texts{{"x", "1"}})) == "<1>\n<1>\n");
}

TEST_CASE("What is filled in is not read as a template again") {
  CHECK(fill_template("{{{x}}}", Words(Words::Texts{{"x", "{{y}} {{#z}} {{/x}}"}})) == "{{y}} {{#z}} {{/x}}");
}

TEST_CASE("A part is another file, filled in at the same place") {
  const Words words(Words::Texts{{"width", "7"}, {"height", "5"}, {"stem", "s"}});
  CHECK_THROWS_AS(fill_template("{{> no/such/file}}", words), std::logic_error);
  CHECK(fill_template("{{> palette.txt}}", words) == fill_template_file("palette.txt", words));
}

TEST_CASE("Every name must be known, unless a section says that it may be missing") {
  const Words words(Words::Texts{{"x", "1"}, {"y", ""}});
  CHECK_THROWS_AS(fill_template("{{z}}", words), std::logic_error);
  CHECK_THROWS_AS(fill_template("{{#z}}a{{/z}}", words), std::logic_error);
  CHECK_THROWS_AS(fill_template("{{^z}}a{{/z}}", words), std::logic_error);
  CHECK(fill_template("{{#z?}}a{{/z}}{{^z?}}b{{/z}}{{#x?}}c{{/x}}", words) == "bc");
  fill_template("{{#y}}{{p}}{{#q}}{{{r}}}{{/q}}{{/y}}{{^x}}{{s}}{{/x}}", words);
  CHECK(words.passed_over == std::vector<std::string>{"p", "q", "r", "s"});
}

TEST_CASE("Tags that do not match are named") {
  const Words words(Words::Texts{{"x", "1"}, {"y", ""}});
  for (const char* wrong : {"{{#x}}", "{{/x}}", "{{#x}}{{/y}}", "{{#y}}{{#x}}{{/y}}{{/x}}", "{{x", "{{{x}}",
                            "{{#x}}{{x", "{{#y}}{{#x}}{{/y}}"}) {
    INFO(wrong);
    CHECK_THROWS_AS(fill_template(wrong, words), std::logic_error);
  }
  CHECK_THROWS_WITH(fill_template("{{#x}}", words), Catch::Contains("section x is not closed"));
}

TEST_CASE("sections that nest without end are an error") {
  std::string text;
  for (int k = 0; k < 100'000; ++k) text += "{{#a}}";
  CHECK_THROWS_AS(fill_template(text, Words(Words::Texts{{"a", "x"}})), std::logic_error);
}
