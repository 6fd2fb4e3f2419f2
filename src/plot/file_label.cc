#include "plot/file_label.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <sstream>
#include <utility>
#include <vector>

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

/// The data of the stream that belongs to the object at the beginning of `object`.
std::string stream_in(std::string_view object) {
  constexpr std::string_view begins = "stream";
  constexpr std::size_t longest = 1 << 22;  // of what describes a plot of one page
  std::size_t at = object.find(begins);
  if (at == std::string_view::npos) fail("has no stream");
  at = object.find('\n', at) + 1;
  std::string data(longest, '\0');
  auto size = static_cast<uLongf>(data.size());
  auto packed = static_cast<uLong>(object.size() - at);
  if (uncompress2(reinterpret_cast<Bytef*>(data.data()), &size, reinterpret_cast<const Bytef*>(object.data() + at),
                  &packed) != Z_OK) {
    fail("has a stream that zlib cannot unpack");
  }
  data.resize(size);
  return data;
}

/// The objects of a PDF whose table is a stream, as "7 0 obj ... endobj", by number: those that stand by themselves,
/// and those that are packed in others.
std::map<std::size_t, std::string> objects_of(std::string_view pdf, std::size_t table) {
  const std::string_view about = pdf.substr(table, pdf.find("stream", table) - table);
  const std::string entries = stream_in(pdf.substr(table));
  std::size_t widths[3] = {};
  std::istringstream(std::string(about.substr(about.find("/W [") + 4))) >> widths[0] >> widths[1] >> widths[2];
  const std::size_t width = widths[0] + widths[1] + widths[2];
  if (width == 0 || width > 24) fail("has no table of its objects");
  std::map<std::size_t, std::size_t> places;  // of what stands by itself, by place: its number
  for (std::size_t i = 0; (i + 1) * width <= entries.size(); ++i) {
    std::size_t kind = 0, place = 0;
    for (std::size_t k = 0; k < widths[0] + widths[1]; ++k) {
      std::size_t& field = k < widths[0] ? kind : place;
      field = field << 8 | static_cast<unsigned char>(entries[i * width + k]);
    }
    if (kind == 1) places[place] = i;
  }
  std::map<std::size_t, std::string> objects;
  std::vector<std::size_t> lengths;  // numbers of the objects that say how long packed ones are
  for (auto at = places.begin(); at != places.end(); ++at) {
    if (at->first == table || at->first > pdf.size()) continue;
    const std::size_t end = std::next(at) == places.end() ? pdf.rfind("startxref") : std::next(at)->first;
    const std::string_view object = pdf.substr(at->first, end - at->first),
                           head = object.substr(0, object.find("stream"));
    if (head.find("/Type /ObjStm") == std::string_view::npos) {
      objects[at->second] = object;
      continue;
    }
    lengths.push_back(number_behind(head, "/Length"));
    const std::string packed = stream_in(object);
    const std::size_t first = number_behind(head, "/First"), count = number_behind(head, "/N");
    std::istringstream numbers(packed);
    std::vector<std::pair<std::size_t, std::size_t>> inside(count);  // numbers and places
    for (auto& [number, place] : inside) numbers >> number >> place;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t from = first + inside[k].second,
                        to = k + 1 < count ? first + inside[k + 1].second : packed.size();
      if (!numbers || from > to || to > packed.size()) fail("has packed objects without places");
      objects[inside[k].first] = fmt::format("{} 0 obj\n{}\nendobj\n", inside[k].first, packed.substr(from, to - from));
    }
  }
  for (const std::size_t number : lengths) objects.erase(number);
  return objects;
}

}  // namespace

std::string with_plain_objects(std::string pdf) {
  if (pdf.rfind("startxref") == std::string::npos) return pdf;
  const std::size_t table = number_behind(pdf, "startxref");
  if (table >= pdf.size() || pdf.compare(table, 4, "xref") == 0) return pdf;
  const auto objects = objects_of(pdf, table);
  const std::size_t root = number_behind(pdf, "/Root"), information = number_behind(pdf, "/Info"),
                    size = objects.empty() ? 0 : objects.rbegin()->first + 1;
  std::string plain = "%PDF-1.7\n%\xb5\xed\xae\xfb\n";
  std::map<std::size_t, std::size_t> places;
  for (const auto& [number, text] : objects) {
    places[number] = plain.size();
    plain += text;
  }
  const std::size_t start = plain.size();
  plain += fmt::format("xref\n0 {}\n", size);
  for (std::size_t i = 0; i < size; ++i) {
    const auto there = places.find(i);
    plain +=
        there == places.end() ? std::string("0000000000 65535 f \n") : fmt::format("{:010} 00000 n \n", there->second);
  }
  return plain + fmt::format("trailer\n<< /Size {} /Root {} 0 R /Info {} 0 R >>\nstartxref\n{}\n%%EOF\n", size, root,
                             information, start);
}

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
