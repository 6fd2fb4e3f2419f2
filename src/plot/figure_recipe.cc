#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "plot/plot_colours.h"
#include "plot/plot_script.h"
#include "support/error.h"
#include "support/single_line.h"
#include "support/template_file.h"

namespace granuscope {
namespace {

using Json = nlohmann::ordered_json;

/// Variables hold colours of the palette, too: each of `old` becomes the one of `now` of the same name.
void recolour(TemplateVariables& variables, const TemplateVariables& old, const TemplateVariables& now) {
  constexpr std::size_t length = 7;  // #rrggbb
  for (auto& [name, text] : variables) {
    for (std::size_t at = text.find('#'); at != std::string::npos; at = text.find('#', at + 1)) {
      for (const auto& [colour, hex] : old) {
        const auto other = now.find(colour);
        if (text.compare(at, length, hex) != 0 || other == now.end()) continue;
        text.replace(at, length, other->second);
        break;
      }
    }
  }
}

bool is_decimal(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// A text that stays one wherever it stands in single quotes: no quote ends it, neither < nor | at its beginning makes
/// a pipe of a file's name, < begins no place of a part, and TeX finds no command in it.
bool is_plain_text(std::string_view text) {
  return text.find_first_of("'\"`\\@<") == std::string_view::npos &&
         text.substr(std::min(text.find_first_not_of(' '), text.size())).substr(0, 1) != "|" &&
         std::none_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; });
}

enum class Strings { of_both_quotes, of_double_quotes };

/// Nothing but what the program writes where no quotes are: numbers, strings, curves with their columns, and the words
/// that place labels and arrows. What is left out starts programs, reads and writes files, and evaluates strings.
bool is_plain_gnuplot(std::string_view text, Strings strings = Strings::of_both_quotes) {
  constexpr auto words = std::to_array<std::string_view>(
      {"yes",          "NaN",          "nan",        "set",         "label",       "arrow",
       "from",         "first",        "graph",      "screen",      "to",          "at",
       "nohead",       "size",         "filled",     "rgb",         "left",        "right",
       "center",       "noenhanced",   "font",       "inset_text",  "using",       "with",
       "every",        "axes",         "title",      "notitle",     "keyentry",    "lines",
       "points",       "linespoints",  "dots",       "boxes",       "vectors",     "circles",
       "labels",       "yerrorbars",   "xerrorbars", "xyerrorbars", "yerrorlines", "xerrorlines",
       "xyerrorlines", "filledcurves", "linewidth",  "linecolor",   "linetype",    "dashtype",
       "pointsize",    "pointtype",    "fillcolor",  "fillstyle",   "solid",       "sqrt",
       "exp",          "log",          "abs",        "x",           "y",           "wide",
       "unset",        "logscale"});
  while (!text.empty()) {
    const char c = text.front();
    std::size_t end = 1;
    if (c == '\'') {
      if (strings == Strings::of_double_quotes) return false;
      std::string inside;
      // As gnuplot reads it: a doubled quote is one of the text, but not at its beginning.
      for (; end < text.size() && (text[end] != '\'' || (end > 1 && text.substr(end, 2) == "\'\'")); ++end) {
        if (text[end] == '\'')
          ++end;
        else
          inside += text[end];
      }
      if (end == text.size() || !is_plain_text(inside)) return false;
      ++end;
    } else if (c == '"') {
      end = text.find('"', 1);
      if (end == std::string_view::npos || !is_plain_gnuplot(text.substr(1, end - 1))) return false;
      ++end;
    } else if (is_decimal(c)) {
      while (end < text.size() && (is_decimal(text[end]) || text[end] == '.')) ++end;
      if (end + 1 < text.size() && text[end] == 'e' &&
          (is_decimal(text[end + 1]) || text[end + 1] == '-' || text[end + 1] == '+'))
        end += 2;
    } else if (std::isalpha(static_cast<unsigned char>(c)) != 0) {
      while (end < text.size() && (std::isalnum(static_cast<unsigned char>(text[end])) != 0 || text[end] == '_')) ++end;
      const std::string_view word = text.substr(0, end);
      if (std::find(words.begin(), words.end(), word) == words.end()) return false;
    } else if (c == '\\') {
      // A line that goes on, but not into what the template has behind it.
      if (text.substr(1, 1) != "\n" || text.find_first_not_of(" \n", 2) == std::string_view::npos) return false;
    } else if (std::string_view(" \n,:+-*/?()[]$").find(c) == std::string_view::npos) {
      return false;
    }
    text.remove_prefix(end);
  }
  return true;
}

/// Whether the text names one of the recipe's parts, "<part 0>".
bool is_place_of_part(std::string_view text) {
  constexpr std::string_view begin = "<part ";
  return text.starts_with(begin) && text.ends_with('>') && text.size() > begin.size() + 1 &&
         std::all_of(text.begin() + begin.size(), text.end() - 1, is_decimal);
}

/// Whether the text can do no harm in each place where the script template asks for `name`.
bool is_harmless(const std::string& name, const std::string& text, std::string_view script) {
  // The templates evaluate these strings: what stands in them is no text.
  const Strings strings = name.starts_with("close_") ? Strings::of_double_quotes : Strings::of_both_quotes;
  const bool text_only = is_plain_text(text), plain = is_place_of_part(text) || is_plain_gnuplot(text, strings);
  if (!text_only && !plain) return false;
  const std::string place = "{{" + name + "}}";
  for (std::size_t at = script.find(place); at != std::string_view::npos; at = script.find(place, at + 1)) {
    const std::size_t start = script.rfind('\n', at) + 1;
    const std::string_view before = script.substr(start, at - start);
    if (before.substr(std::min(before.find_first_not_of(' '), before.size())).starts_with('#')) continue;
    const bool quoted = std::count(before.begin(), before.end(), '\'') % 2 == 1;
    if (quoted ? !text_only : !plain) return false;
  }
  return true;
}

void require_template(const std::string& name, const std::string& source) {
  const auto files = embedded_files();
  const bool known = std::any_of(files.begin(), files.end(), [&name](const auto& file) { return file.name == name; });
  if (known) return;
  throw InputError(fmt::format("{}: the program has no template {}; run the experiment again with this version", source,
                               single_line(name)));
}

/// A recipe may come from anywhere, and gnuplot runs what is filled from it.
void require_harmless(const FigureRecipe& recipe, const std::string& source) {
  const auto refuse = [&source](const std::string& name, const std::string& text) {
    throw InputError(fmt::format(
        "{}: {} is \"{}\", which holds more than texts, numbers and curves, and gnuplot might run it as a command; "
        "run the experiment again",
        source, single_line(name), single_line(text.substr(0, 200))));
  };
  const auto require = [&](const std::string& script, const TemplateVariables& variables) {
    const std::string file = script + ".gp.mustache";
    require_template(file, source);
    for (const auto& [name, text] : variables) {
      if (!is_harmless(name, text, template_file(file))) refuse(name, text);
    }
  };
  if (!is_plain_text(recipe.id)) refuse("id", recipe.id);
  // Phrases take the place of others inside of quotes.
  if (recipe.wording.terms.find_first_of("'\"`\\@<|") != std::string::npos) refuse("terms", recipe.wording.terms);
  require(recipe.script, recipe.variables);
  for (const ScriptPart& part : recipe.parts) require(part.script, part.variables);
  require_template(recipe.wording.captions, source);
}

}  // namespace

std::string recipe_json(const FigureRecipe& recipe) {
  Json parts = Json::array();
  for (const ScriptPart& part : recipe.parts) {
    parts.push_back({{"template", part.script}, {"variables", part.variables}});
  }
  const Json json = {{"schema", 1},
                     {"id", recipe.id},
                     {"template", recipe.script},
                     {"title", recipe.title},
                     {"caption", recipe.caption},
                     {"height", recipe.height},
                     {"half_width", recipe.half_width},
                     {"variables", recipe.variables},
                     {"parts", parts},
                     {"captions",
                      {{"template", recipe.wording.captions},
                       {"variables", recipe.wording.variables},
                       {"terms", recipe.wording.terms}}},
                     {"colours", recipe.colours}};
  return json.dump(1) + "\n";
}

FigureRecipe read_recipe(const std::string& json, const std::string& source) {
  FigureRecipe recipe;
  try {
    const Json read = Json::parse(json);
    read.at("id").get_to(recipe.id);
    read.at("template").get_to(recipe.script);
    read.at("title").get_to(recipe.title);
    read.at("caption").get_to(recipe.caption);
    read.at("height").get_to(recipe.height);
    read.at("half_width").get_to(recipe.half_width);
    read.at("variables").get_to(recipe.variables);
    for (const Json& part : read.at("parts")) {
      recipe.parts.push_back({part.at("template"), part.at("variables").get<TemplateVariables>()});
    }
    read.at("captions").at("template").get_to(recipe.wording.captions);
    read.at("captions").at("variables").get_to(recipe.wording.variables);
    recipe.wording.terms = read.at("captions").value("terms", "");
    const auto old = read.at("colours").get<TemplateVariables>();
    recipe.colours = plot_colours();
    recolour(recipe.variables, old, recipe.colours);
    for (ScriptPart& part : recipe.parts) recolour(part.variables, old, recipe.colours);
  } catch (const Json::exception& error) {
    throw InputError(fmt::format(
        "{}: this is no recipe of a figure ({}), so that its script cannot be filled from other templates; run the "
        "experiment again",
        source, error.what()));
  }
  require_harmless(recipe, source);
  return recipe;
}

}  // namespace granuscope
