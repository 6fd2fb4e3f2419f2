#include "report/unbroken_text.h"

#include <algorithm>
#include <vector>

#include "support/clean_text.h"

namespace granuscope {

namespace {

bool joins(std::string_view word) { return word == "=" || word == "−" || word == "≈" || word == "±" || word == "×"; }

/// "1/√z" and "xₚ/z": a line could break behind the stroke.
bool short_fraction(std::string_view word) {
  constexpr std::size_t longest = 16;  // bytes; more is a path, or no formula
  return word.size() <= longest && word.find('/') != std::string_view::npos;
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(' ', start), text.size());
    words.push_back(text.substr(start, end - start));
    start = end + 1;
  }
  return words;
}

}  // namespace

std::string unbroken_formulae(std::string_view text) {
  const std::vector<std::string_view> words = words_of(text);
  std::string html;
  bool inside = false;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool last = i + 1 == words.size();
    const bool goes_on = !last && (joins(words[i + 1]) || words[i + 1].starts_with('%') || (inside && joins(words[i])));
    if ((goes_on || short_fraction(words[i])) && !inside) {
      html += "<span class=\"formula-text\">";
      inside = true;
    }
    html += escape_markup(words[i]);
    if (inside && !goes_on) {
      html += "</span>";
      inside = false;
    }
    if (!last) html += ' ';
  }
  return html;
}

std::string unbroken_words(std::string_view text) {
  constexpr std::size_t longest = 60;  // characters that fit into a line of print in any case
  std::string html;
  for (const std::string_view word : words_of(text)) {
    if (!html.empty()) html += ' ';
    const bool breaks = word.size() > longest || word.find('-') == std::string_view::npos;
    html += breaks ? escape_markup(word) : "<span class=\"word\">" + escape_markup(word) + "</span>";
  }
  return html;
}

}  // namespace granuscope
