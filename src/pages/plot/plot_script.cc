#include "plot/plot_script.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "render/palette.h"
#include "support/error.h"
#include "support/plain_text.h"
#include "support/provenance.h"
#include "support/templates.h"

namespace granuscope {
namespace {

std::string plot_template(const std::string& name) {
  return std::string(template_file(fmt::format("{}.gp.mustache", name)));
}

/// Colours the script does not use are no mistake; every other variable must be asked for.
void add_colours_used(TemplateVariables& variables, const std::string& script) {
  for (const auto& [name, colour] : plot_colours()) {
    if (script.find("{{" + name + "}}") != std::string::npos) variables.emplace(name, colour);
  }
}

constexpr const char* begin_pass_place = "<begin_pass>";

std::string part_place(std::size_t index) { return fmt::format("<part {}>", index); }

}  // namespace

KeySize size_of_key(const std::string& script) {
  KeySize size;
  constexpr std::string_view entry = "keyentry ", title = " title '";
  for (std::size_t at = script.find(entry); at != std::string::npos; at = script.find(entry, at + 1)) {
    const std::size_t end = std::min(script.find(entry, at + 1), script.size());
    const std::size_t begins = script.find(title, at);
    if (begins >= end) continue;
    int letters = 0;
    for (std::size_t i = begins + title.size(); i < end; ++i) {
      if (script[i] == '\'' && script[++i] != '\'') break;                          // a doubled one is one of the text
      letters += (static_cast<unsigned char>(script[i]) & 0xC0U) != 0x80U ? 1 : 0;  // UTF-8
    }
    ++size.entries;
    size.letters = std::max(size.letters, letters);
  }
  return size;
}

std::string PlotPlan::add_part(ScriptPart part) {
  parts.push_back(std::move(part));
  return part_place(parts.size() - 1);
}

std::string fill_script(const FigureRecipe& recipe) {
  const std::string script_template = plot_template(recipe.script);
  TemplateVariables all = recipe.variables;
  all["stem"] = recipe.id;
  all["begin_pass"] = begin_pass_place;
  if (script_template.find("{{key_panel}}") != std::string::npos) all["key_panel"] = plot_template("plot/key_panel");
  all["end_of_pass"] = plot_template("plot/end_of_pass");
  add_colours_used(all, script_template);
  std::string script = fill_template(script_template, all);
  for (std::size_t i = 0; i < recipe.parts.size(); ++i) {
    const std::string place = part_place(i), part_template = plot_template(recipe.parts[i].script);
    const std::size_t at = script.find(place);
    if (at == std::string::npos) continue;
    TemplateVariables variables = recipe.parts[i].variables;
    add_colours_used(variables, part_template);
    script.replace(at, place.size(), fill_template(part_template, variables));
  }
  script = in_language(in_language(script, recipe.wording.terms), template_file("plot/labels.txt"));
  const KeySize key = size_of_key(script);
  return script.replace(
      script.find(begin_pass_place), std::string_view(begin_pass_place).size(),
      fill_template(plot_template("plot/begin_pass"),
                    {{"stem", recipe.id},
                     {"width", exact(plot_width_inches)},
                     {"height", exact(recipe.height)},
                     {"own_width", exact(recipe.half_width ? half_plot_width_inches : plot_width_inches)},
                     {"own_points", recipe.half_width ? "8" : "9"},
                     {"key_entries", std::to_string(key.entries)},
                     {"key_letters", std::to_string(key.letters)}}));
}

Figure plot_figure(const PlotPlan& plan, const TemplateVariables& variables, const Wording& wording,
                   const std::filesystem::path& run_folder) {
  const std::filesystem::path folder = "figures";
  Figure figure;
  figure.id = plan.id;
  figure.redraw = fmt::format("cd figures && gnuplot -d {}.gp", plan.id);
  set_captions(figure, wording);

  const FigureRecipe recipe{plan.id,    plan.script, plan.height,  plan.half_width, variables,
                            plan.parts, wording,     figure.title, figure.caption,  plot_colours()};
  GnuplotJob job;
  job.stem = plan.id;
  job.script = fill_script(recipe);
  job.data = plan.data;
  for (auto& [name, csv] : job.data) {
    const std::size_t head = std::min(csv.find('\n'), csv.size());
    csv = in_terms(csv.substr(0, head), wording.terms) + csv.substr(head);
  }
  job.recipe = recipe_json(recipe);
  job.label = FileLabel{figure.title, figure.redraw, provenance_line(collect_provenance())};
  job.curves = plan.curves;
  job.narrow_inches = plan.half_width ? 0 : narrow_plot_width_inches;
  try {
    plot_with_gnuplot(job, run_folder / folder);
  } catch (const EnvironmentError& failure) {
    figure.failure = failure.what();
    if (!is_drawn(job, run_folder / folder)) return figure;
  }
  figure.screen = folder / (plan.id + ".svg");
  if (job.narrow_inches > 0) figure.narrow = folder / narrow_svg(plan.id);
  figure.print = folder / (plan.id + ".pdf");
  figure.script = folder / (plan.id + ".gp");
  figure.recipe = folder / (plan.id + ".json");
  for (const auto& [name, csv] : plan.data) figure.data.push_back(folder / name);
  return figure;
}

TemplateVariables plot_colours() {
  // The order in which Okabe and Ito list them.
  constexpr std::array names = {"black",  "orange", "sky_blue",  "bluish_green",
                                "yellow", "blue",   "vermilion", "reddish_purple"};
  const Palette palette(template_file("palette.txt"), "templates/palette.txt");
  const std::vector<Rgb>& okabe_ito = palette.colours("okabe-ito");
  if (okabe_ito.size() != names.size()) throw std::logic_error("palette.txt: okabe-ito does not have eight colours");
  TemplateVariables colours;
  for (std::size_t i = 0; i < names.size(); ++i) colours[names[i]] = to_hex(okabe_ito[i]);
  colours["frame"] = to_hex(palette.colour("frame"));
  return colours;
}

std::string series_style(std::size_t index) {
  constexpr std::array colours = {"blue", "vermilion", "bluish_green", "reddish_purple", "orange", "black"};
  constexpr std::array markers = {7, 5, 13, 9, 11, 6, 4};
  return fmt::format("pointtype {} linecolor rgb '{}'", markers[index % markers.size()],
                     plot_colours().at(colours[index % colours.size()]));
}

namespace {

struct Phrase {
  std::string from, to;
};

struct Catalogue {
  std::vector<Phrase> phrases;  ///< longest first
  std::string decimal_point = ".";
};

Catalogue read_catalogue(std::string_view text) {
  Catalogue catalogue;
  constexpr std::string_view arrow = " -> ";
  std::stringstream lines{std::string(text)};
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.front() == '#') continue;
    const std::size_t at = line.find(arrow);
    if (at == std::string::npos || at == 0 || at + arrow.size() == line.size()) {
      throw InputError(
          fmt::format("plot/labels.txt: \"{}\" is no phrase; write `phrase -> phrase`", single_line(line)));
    }
    const Phrase phrase{line.substr(0, at), line.substr(at + arrow.size())};
    if (phrase.from == ".") {
      catalogue.decimal_point = phrase.to;
    } else {
      catalogue.phrases.push_back(phrase);
    }
  }
  std::stable_sort(catalogue.phrases.begin(), catalogue.phrases.end(),
                   [](const Phrase& a, const Phrase& b) { return a.from.size() > b.from.size(); });
  return catalogue;
}

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// File names, formats, colours, terminals and the first choice of font are no texts.
bool is_text(std::string_view text) {
  constexpr std::array<std::string_view, 9> technical = {"svg", "pdf", "eps", "png", "tikz", "NaN", "+", "-", ""};
  if (std::find(technical.begin(), technical.end(), text) != technical.end()) return false;
  if (text.front() == '#' || text.find('%') != std::string_view::npos) return false;
  if (text == "DejaVu Sans") return false;
  const auto extension = [text](std::string_view end) { return text.ends_with(end); };
  constexpr std::array<std::string_view, 6> files = {".csv", ".svg", ".pdf", ".eps", ".png", ".tikz"};
  return std::none_of(files.begin(), files.end(), extension);
}

std::string translated(const std::string& text, const Catalogue& catalogue) {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const auto fits = [&](const Phrase& phrase) {
      if (text.compare(at, phrase.from.size(), phrase.from) != 0) return false;
      const std::size_t end = at + phrase.from.size();
      const bool begins = at == 0 || !is_letter(text[at - 1]) || !is_letter(text[at]);
      return begins && (end == text.size() || !is_letter(text[end]) || !is_letter(text[end - 1]));
    };
    const auto found = std::find_if(catalogue.phrases.begin(), catalogue.phrases.end(), fits);
    if (found != catalogue.phrases.end()) {
      result += found->to;
      at += found->from.size();
    } else if (text[at] == '.' && at > 0 && is_digit(text[at - 1]) && at + 1 < text.size() && is_digit(text[at + 1])) {
      result += catalogue.decimal_point;
      ++at;
    } else {
      result += text[at++];
    }
  }
  return result;
}

/// Calls `replace` on every quoted text, with its doubled quotes made single, and puts its result in the place.
/// Comments stay.
std::string with_each_text(std::string_view script, const std::function<std::string(const std::string&)>& replace) {
  std::string result;
  std::size_t at = 0;
  while (at < script.size()) {
    const std::size_t end = std::min(script.find('\n', at), script.size() - 1) + 1;
    const std::string_view line = script.substr(at, end - at);
    at = end;
    for (std::size_t i = 0; i < line.size(); ++i) {
      if (line[i] == '#') {
        result += line.substr(i);
        break;
      }
      result += line[i];
      if (line[i] != '\'') continue;
      std::string text;
      bool closed = false;
      for (++i; i < line.size() && !closed; ++i) {
        closed = line[i] == '\'' && (i + 1 == line.size() || line[i + 1] != '\'');
        if (closed) break;
        if (line[i] == '\'') ++i;  // a doubled one is one of the text
        text += line[i];
      }
      for (const char c : replace(text)) result += c == '\'' ? "''" : std::string(1, c);
      if (closed) result += '\'';
    }
  }
  return result;
}

}  // namespace

std::string in_language(const std::string& script, std::string_view catalogue_text) {
  const Catalogue catalogue = read_catalogue(catalogue_text);
  if (catalogue.phrases.empty() && catalogue.decimal_point == ".") return script;
  return with_each_text(script,
                        [&](const std::string& text) { return is_text(text) ? translated(text, catalogue) : text; });
}

std::string in_terms(const std::string& text, std::string_view catalogue_text) {
  return catalogue_text.empty() ? text : translated(text, read_catalogue(catalogue_text));
}

std::string terms_of(const ScanParameter& parameter) {
  if (&parameter == &friction_parameter()) return {};
  const ScanParameter& friction = friction_parameter();
  std::string terms = fmt::format("{} -> {}\n{} -> {}\n{} -> {}\n", friction.label(), parameter.label(),
                                  friction.meaning, parameter.meaning, friction.name, parameter.name);
  if (parameter.symbol != friction.symbol) {
    terms += fmt::format("{} -> {}\n", friction.symbol, parameter.symbol);
  }
  return terms;
}

std::vector<std::string> texts_of_script(std::string_view script) {
  std::vector<std::string> texts;
  with_each_text(script, [&](const std::string& text) {
    if (is_text(text)) texts.push_back(text);
    return text;
  });
  return texts;
}

std::string_view catalogue_of(const std::string& language) {
  if (language == "en") return "";
  if (language == "fr" || language == "de") return template_file(language + "/plot/labels.txt");
  throw InputError(
      fmt::format("there is no language {} for figures; choose en, fr or de, or give a folder with "
                  "plot/labels.txt by --templates",
                  single_line(language)));
}

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
    const Json read = Json::parse(shallow_json(json));
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
