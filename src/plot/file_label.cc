#include "plot/file_label.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "support/clean_text.h"
#include "support/error.h"

namespace granuscope {
namespace {

constexpr std::string_view title_begins = "<title>", title_ends = "</title>", description_begins = "<desc>",
                           description_ends = "</desc>";
constexpr std::string_view command_key = "Command: ", program_key = "Program: ";

[[noreturn]] void fail(const std::string& what) {
  throw EnvironmentError(
      fmt::format("a plot made by gnuplot {} where Debian 12's gnuplot 5.4 and cairo 1.16 have one, so that it cannot "
                  "say what it is, nor have the same bytes each time; run `granuscope doctor` to see which gnuplot is "
                  "installed",
                  what));
}

/// What stands between two marks, the first time; npos if it does not.
struct Span {
  std::size_t begin = std::string_view::npos, length = 0;
  bool found() const { return begin != std::string_view::npos; }
};

Span between(std::string_view text, std::string_view first, std::string_view last) {
  const std::size_t at = text.find(first);
  if (at == std::string_view::npos) return {};
  const std::size_t end = text.find(last, at + first.size());
  if (end == std::string_view::npos) return {};
  return {at + first.size(), end - at - first.size()};
}

std::string unescaped(std::string_view markup) {
  constexpr std::pair<std::string_view, char> entities[] = {
      {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&#39;", '\''}, {"&amp;", '&'}};
  std::string text;
  while (!markup.empty()) {
    const auto* const found = std::find_if(std::begin(entities), std::end(entities),
                                           [&](const auto& one) { return markup.starts_with(one.first); });
    const bool entity = found != std::end(entities);
    text += entity ? found->second : markup.front();
    markup.remove_prefix(entity ? found->first.size() : 1);
  }
  return text;
}

/// The number behind the last of these words.
std::size_t number_behind(std::string_view pdf, std::string_view word) {
  std::size_t at = pdf.rfind(word);
  if (at == std::string_view::npos) fail(fmt::format("has no {}", word));
  at = pdf.find_first_not_of(" \n\r", at + word.size());
  std::size_t number = 0;
  if (at == std::string_view::npos ||
      std::from_chars(pdf.data() + at, pdf.data() + pdf.size(), number).ec != std::errc()) {
    fail(fmt::format("has no number behind {}", word));
  }
  return number;
}

}  // namespace

std::string labelled_svg(std::string svg, const FileLabel& label) {
  // The first of each is that of the whole drawing; those of curves come behind.
  const auto put = [&svg](std::string_view begins, std::string_view ends, const std::string& text) {
    const Span place = between(svg, begins, ends);
    if (!place.found()) fail(fmt::format("has no {}", begins));
    svg.replace(place.begin, place.length, escape_markup(clean_text(text)));
  };
  put(title_begins, title_ends, label.title);
  put(description_begins, description_ends,
      fmt::format("{}{}\n{}{}", command_key, label.command, program_key, label.program));
  return svg;
}

std::optional<FileLabel> label_of_svg(std::string_view svg) {
  const Span title = between(svg, title_begins, title_ends),
             description = between(svg, description_begins, description_ends);
  if (!title.found() || !description.found()) return std::nullopt;
  const std::string text = unescaped(svg.substr(description.begin, description.length));
  const Span command = between(text, command_key, "\n");
  const std::size_t program = text.find(program_key);
  if (!command.found() || program == std::string::npos) return std::nullopt;
  return FileLabel{unescaped(svg.substr(title.begin, title.length)), text.substr(command.begin, command.length),
                   text.substr(program + program_key.size())};
}

std::string labelled_pdf(std::string pdf, const FileLabel& label) {
  const std::size_t table = number_behind(pdf, "startxref"), information = number_behind(pdf, "/Info"),
                    root = number_behind(pdf, "/Root"), size = number_behind(pdf, "/Size");
  if (!pdf.ends_with('\n')) pdf += '\n';
  const std::size_t object = pdf.size();
  pdf += fmt::format("{} 0 obj\n<< /Title {} /Subject {} /Creator {} /Producer (gnuplot, cairo) >>\nendobj\n",
                     information, pdf_string(label.title), pdf_string(label.command), pdf_string(label.program));
  const std::size_t new_table = pdf.size();
  pdf += fmt::format("xref\n{} 1\n{:010} 00000 n \ntrailer\n<< /Size {} /Root {} 0 R /Info {} 0 R /Prev {} >>\n",
                     information, object, size, root, information, table);
  return pdf + fmt::format("startxref\n{}\n%%EOF\n", new_table);
}

}  // namespace granuscope
