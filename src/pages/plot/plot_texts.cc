#include "plot/plot_texts.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "render/palette.h"
#include "support/error.h"
#include "support/plain_text.h"
#include "support/templates.h"

namespace granuscope {

TemplateVariables plot_colours() {
  // The order in which Okabe and Ito list them.
  constexpr std::array names = {"black",  "orange", "sky_blue",  "bluish_green",
                                "yellow", "blue",   "vermilion", "reddish_purple"};
  const Palette palette(template_file("palette.txt"), "templates/palette.txt");
  const std::vector<Rgb>& okabe_ito = palette.colours("okabe-ito");
  if (okabe_ito.size() != names.size()) throw std::logic_error("palette.txt: okabe-ito does not have eight colours");
  TemplateVariables colours;
  for (std::size_t i = 0; i < names.size(); ++i) colours[names[i]] = to_hex(okabe_ito[i]);
  const std::vector<Rgb>& blues = palette.colours("blues");
  for (std::size_t i = 0; const char* name : {"light_blue", "bright_blue", "deep_blue", "dark_blue"})
    colours[name] = to_hex(blues.at(i++));
  colours["frame"] = to_hex(palette.colour("frame"));
  return colours;
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
      throw InputError("plot/labels.txt: \"{}\" is no phrase; write `phrase -> phrase`", single_line(line));
    }
    const Phrase phrase{line.substr(0, at), line.substr(at + arrow.size())};
    if (phrase.from == ".") {
      catalogue.decimal_point = phrase.to;
    } else {
      catalogue.phrases.push_back(phrase);
    }
  }
  std::ranges::stable_sort(catalogue.phrases,
                           [](const Phrase& a, const Phrase& b) { return a.from.size() > b.from.size(); });
  return catalogue;
}

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

struct Translation {
  std::string text;
  bool whole = true;  ///< no word is left that is in no phrase; single letters are symbols
};

Translation translated(const std::string& text, const Catalogue& catalogue) {
  Translation translation;
  std::string& result = translation.text;
  for (std::size_t at = 0; at < text.size();) {
    const auto fits = [&](const Phrase& phrase) {
      if (text.compare(at, phrase.from.size(), phrase.from) != 0) return false;
      const std::size_t end = at + phrase.from.size();
      const bool begins = at == 0 || !is_letter(text[at - 1]) || !is_letter(text[at]);
      return begins && (end == text.size() || !is_letter(text[end]) || !is_letter(text[end - 1]));
    };
    const auto found = std::ranges::find_if(catalogue.phrases, fits);
    if (found != catalogue.phrases.end()) {
      result += found->to;
      at += found->from.size();
    } else if (text[at] == '.' && at > 0 && is_digit(text[at - 1]) && at + 1 < text.size() && is_digit(text[at + 1])) {
      result += catalogue.decimal_point;
      ++at;
    } else {
      const bool parts = text[at] == ',' && catalogue.decimal_point == "," && at > 0 && is_digit(text[at - 1]) &&
                         at + 2 < text.size() && text[at + 1] == ' ' && is_digit(text[at + 2]);
      result += parts ? ';' : text[at];
      if (is_letter(text[at]) && at + 1 < text.size() && is_letter(text[at + 1])) translation.whole = false;
      ++at;
    }
  }
  return translation;
}

}  // namespace

std::string in_terms(const std::string& text, std::string_view catalogue_text) {
  return catalogue_text.empty() ? text : translated(text, read_catalogue(catalogue_text)).text;
}

TemplateVariables in_words_of(TemplateVariables variables, std::string_view catalogue_text) {
  const Catalogue catalogue = read_catalogue(catalogue_text);
  const Catalogue sign{{}, catalogue.decimal_point};
  for (auto& [name, value] : variables) {
    const Translation translation = translated(value, catalogue);
    value = translation.whole ? translation.text : translated(value, sign).text;
  }
  return variables;
}

std::string terms_of(const ScanParameter& parameter, double angle) {
  std::string terms = angle == usual_angle ? "" : fmt::format("30° -> {0}°\n30 degrees -> {0} degrees\n", angle);
  if (&parameter == &friction_parameter()) return terms;
  const ScanParameter& friction = friction_parameter();
  terms += fmt::format("{} -> {}\n{} -> {}\n{} -> {}\n", friction.label(), parameter.label(), friction.meaning,
                       parameter.meaning, friction.name, parameter.name);
  if (parameter.symbol != friction.symbol) terms += fmt::format("{} -> {}\n", friction.symbol, parameter.symbol);
  return terms;
}

std::string_view catalogue_of(const std::string& language) {
  if (language == "en") return "";
  if (language == "fr" || language == "de") return template_file(language + "/plot/labels.txt");
  const std::string begins = lower_case(language.substr(0, 2));
  throw InputError("there is no language {} for figures; {}, or give a folder with plot/labels.txt by --templates",
                   single_line(language),
                   begins == "fr"                     ? "write fr"
                   : begins == "ge" || begins == "de" ? "write de"
                                                      : "choose en, fr or de");
}

}  // namespace granuscope
