#include "plot/plot_language.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <sstream>

#include "support/error.h"
#include "support/single_line.h"
#include "support/template_file.h"

namespace granuscope {
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

}  // namespace granuscope
