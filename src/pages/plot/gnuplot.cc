#include "plot/gnuplot.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <sstream>
#include <system_error>
#include <utility>

#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/process.h"

namespace granuscope {

bool is_complaint(std::string_view standard_error) {
  // "name.gp" line 3: warning: …; (process:17): Pango-WARNING **: …; Fontconfig warning: …
  for (const char* sign : {".gp\" line ", ".gp\", line ", "WARNING **", "CRITICAL **", "Fontconfig "}) {
    if (standard_error.find(sign) != std::string_view::npos) return true;
  }
  return false;
}

namespace {

constexpr std::string_view creation_date_key = "/CreationDate (";

bool ends_with_mark(std::string_view text, std::string_view mark) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.remove_suffix(1);
  return text.ends_with(mark);
}

[[noreturn]] void fail(const GnuplotJob& job, const std::string& what) {
  throw EnvironmentError(
      "gnuplot did not plot {}: {}; the figure would be missing or wrong. Run `granuscope doctor` to see whether "
      "gnuplot-nox and fonts-dejavu-core are as expected",
      job.stem, what);
}

std::string read_plot(const GnuplotJob& job, const std::filesystem::path& file, std::string_view end) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  if (error || size == 0) fail(job, fmt::format("{} is missing or empty", file.filename().string()));
  std::string bytes = read_file(file);
  if (!ends_with_mark(bytes, end)) {
    fail(job, fmt::format("{} is cut off (it does not end with {})", file.filename().string(), end));
  }
  return bytes;
}

/// Length of the <g> element at the start of `svg`, nested groups included.
std::size_t group_length(std::string_view svg) {
  int depth = 0;
  for (std::size_t at = svg.find('<'); at != std::string_view::npos; at = svg.find('<', at + 1)) {
    const std::string_view tag = svg.substr(at);
    if (tag.starts_with("<g ") || tag.starts_with("<g>")) ++depth;
    if (tag.starts_with("</g>") && --depth == 0) return at + 4;
  }
  return svg.size();
}

/// Runs the script in `folder`, `settings` before it; a complaint is no success.
void run_script(const GnuplotJob& job, const std::filesystem::path& folder, const std::vector<std::string>& settings,
                double timeout_seconds) {
  ProcessSpec process;
  // -d ignores ~/.gnuplot. C.UTF-8 rather than C: the same number formats, but with C gnuplot warns on stderr that it
  // cannot convert the degree sign as soon as a script says `set encoding utf8`, and stderr has to stay empty.
  process.arguments = {"gnuplot", "-d"};
  process.arguments.insert(process.arguments.end(), settings.begin(), settings.end());
  process.arguments.push_back(job.stem + ".gp");
  process.working_folder = folder;
  process.environment = {{"LC_ALL", "C.UTF-8"}, {"HOME", folder.string()}, {"XDG_CACHE_HOME", folder.string()}};
  process.timeout_seconds = timeout_seconds;
  const ProcessResult result = run_process(process);
  if (result.timed_out) fail(job, fmt::format("it was still running after {:.0f} s", timeout_seconds));
  if (result.exit_code != 0) {
    const std::string said = single_line(result.standard_error);
    fail(job, fmt::format("it {}{}{}", describe_end(result), said.empty() ? "" : ": ", said));
  }
  if (is_complaint(result.standard_error)) fail(job, "it complained: " + single_line(result.standard_error));
}

std::string read_svg(const GnuplotJob& job, const std::filesystem::path& folder) {
  std::string svg = read_plot(job, folder / (job.stem + ".svg"), "</svg>");
  if (const int visible = count_visible_curves(svg); visible != job.curves) {
    fail(job, fmt::format("{} of {} curves are visible", visible, job.curves));
  }
  return svg;
}

}  // namespace

std::string narrow_svg(const std::string& stem) { return stem + "-narrow.svg"; }

void require_gnuplot() {
  if (!find_program("gnuplot")) {
    throw EnvironmentError(missing_program("gnuplot", "no plot can be made",
                                           "install it with `apt-get install gnuplot-nox fonts-dejavu-core`"));
  }
}

namespace {

struct Plotted {
  std::string svg, pdf, narrow;
};

Plotted plot_in(const std::filesystem::path& folder, const GnuplotJob& job, double timeout_seconds) {
  write_file(folder / (job.stem + ".gp"), job.script);
  for (const auto& [name, csv] : job.data) write_file(folder / name, csv);
  run_script(job, folder, {}, timeout_seconds);
  Plotted plotted{read_svg(job, folder), without_creation_date(read_plot(job, folder / (job.stem + ".pdf"), "%%EOF")),
                  ""};
  if (job.narrow_inches > 0) {
    run_script(job, folder, {"-e", fmt::format("only = 'svg'; width = {}", job.narrow_inches)}, timeout_seconds);
    plotted.narrow = read_svg(job, folder);
  }
  return plotted;
}

}  // namespace

void plot_with_gnuplot(const GnuplotJob& job, const std::filesystem::path& folder, double timeout_seconds) {
  require_gnuplot();
  for (const auto& [name, csv] : job.data) {
    const std::vector<std::string> names = columns_without_numbers(csv);
    const auto name_of_none = std::ranges::find_if(names, [](const std::string& one) { return !one.empty(); });
    if (job.all_columns && name_of_none != names.end()) {
      fail(job, fmt::format("column {} of {} holds no number at all", *name_of_none, name));
    }
  }

  const ScratchFolder scratch(folder, job.stem);
  Plotted plotted;
  try {
    plotted = plot_in(scratch.path(), job, timeout_seconds);
  } catch (const EnvironmentError&) {
    require_room(scratch.path());  // of a full disk gnuplot says little
    throw;
  }
  auto& [svg, pdf, narrow] = plotted;

  if (job.label) {
    svg = labelled_svg(std::move(svg), *job.label);
    pdf = labelled_pdf(std::move(pdf), *job.label);
    if (!narrow.empty()) narrow = labelled_svg(std::move(narrow), *job.label);
  }

  for (const auto& [name, csv] : job.data) write_file(folder / name, csv);
  if (!job.recipe.empty()) write_file(folder / (job.stem + ".json"), job.recipe);
  write_file(folder / (job.stem + ".gp"), job.script);
  write_file(folder / (job.stem + ".pdf"), pdf);
  if (!narrow.empty()) write_file(folder / narrow_svg(job.stem), narrow);
  write_file(folder / (job.stem + ".svg"), svg);
}

bool is_drawn(const GnuplotJob& job, const std::filesystem::path& folder) {
  try {
    for (const auto& [name, csv] : job.data) {
      if (read_file(folder / name) != csv) return false;
    }
    if (read_file(folder / (job.stem + ".gp")) != job.script) return false;
    (void)read_plot(job, folder / (job.stem + ".pdf"), "%%EOF");
    if (job.narrow_inches > 0) (void)read_plot(job, folder / narrow_svg(job.stem), "</svg>");
    return count_visible_curves(read_plot(job, folder / (job.stem + ".svg"), "</svg>")) == job.curves;
  } catch (const Error&) {  // missing, or not whole
    return false;
  }
}

std::string gnuplot_string(std::string_view text) {
  std::string quoted = "'";
  // gnuplot 5.4 reads '' at the very start of a string as an empty string, whatever follows: a space keeps them apart.
  if (text.starts_with('\'')) quoted += ' ';
  quoted += replaced(text, {{'\'', "''"}});
  std::ranges::replace_if(
      quoted, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, ' ');
  return quoted + "'";
}

std::string without_creation_date(std::string pdf) {
  pdf = with_plain_objects(std::move(pdf));
  const std::size_t key = pdf.find(creation_date_key), end = pdf.find(')', key);
  if (key == std::string::npos || end == std::string::npos) {
    throw EnvironmentError(
        "a PDF made by gnuplot has no creation date where gnuplot 5.4 and 6.0 put one, so its bytes cannot be made "
        "reproducible; run `granuscope doctor` to see which gnuplot is installed");
  }
  return pdf.replace(key, end + 1 - key, end + 1 - key, ' ');
}

int count_visible_curves(std::string_view svg) {
  constexpr std::string_view curve_start = "<g id=\"gnuplot_plot_";
  constexpr std::string_view untitled = "<title>gnuplot_plot_", with_data = "<title>data ";
  int visible = 0;
  for (std::size_t start = svg.find(curve_start); start != std::string_view::npos;
       start = svg.find(curve_start, start + curve_start.size())) {
    const std::string_view curve = svg.substr(start, group_length(svg.substr(start)));
    const std::size_t data = curve.find(with_data);
    if (data == std::string_view::npos ? curve.find(untitled) == std::string_view::npos
                                       : curve.substr(data + with_data.size()).starts_with(behind))
      continue;
    for (const std::string_view mark : {"<path", "<polygon", "<polyline", "<use", "<circle", "<rect"}) {
      if (curve.find(mark) != std::string_view::npos) {
        ++visible;
        break;
      }
    }
  }
  return visible;
}

std::vector<std::string> columns_without_numbers(const std::string& csv) {
  std::stringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  std::vector<std::string> names = parts_between(line, ",");
  while (std::getline(lines, line)) {
    const std::vector<std::string> row = parts_between(line, ",");
    for (std::size_t i = 0; i < row.size() && i < names.size(); ++i) {
      char* end = nullptr;
      const double number = std::strtod(row[i].c_str(), &end);
      if (end != row[i].c_str() && *end == '\0' && std::isfinite(number)) names[i].clear();
    }
  }
  return names;
}

namespace {

constexpr std::string_view title_begins = "<title>", title_ends = "</title>", description_begins = "<desc>",
                           description_ends = "</desc>";
constexpr std::string_view command_key = "Command: ", program_key = "Program: ";

[[noreturn]] void refuse_plot(const std::string& what) {
  throw EnvironmentError(
      "a plot made by gnuplot {} where Debian 12's gnuplot 5.4 and cairo 1.16 have one, so that it cannot say what it "
      "is, nor have the same bytes each time; run `granuscope doctor` to see which gnuplot is installed",
      what);
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
  if (at == std::string_view::npos) refuse_plot(fmt::format("has no {}", word));
  at = pdf.find_first_not_of(" \n\r", at + word.size());
  std::size_t number = 0;
  if (at == std::string_view::npos ||
      std::from_chars(pdf.data() + at, pdf.data() + pdf.size(), number).ec != std::errc()) {
    refuse_plot(fmt::format("has no number behind {}", word));
  }
  return number;
}

/// The data of the stream that belongs to the object at the beginning of `object`.
std::string stream_in(std::string_view object) {
  constexpr std::string_view begins = "stream";
  constexpr std::size_t longest = 1 << 22;  // of what describes a plot of one page
  std::size_t at = object.find(begins);
  if (at == std::string_view::npos) refuse_plot("has no stream");
  at = object.find('\n', at) + 1;
  std::string data(longest, '\0');
  auto size = static_cast<uLongf>(data.size());
  auto packed = static_cast<uLong>(object.size() - at);
  if (uncompress2(reinterpret_cast<Bytef*>(data.data()), &size, reinterpret_cast<const Bytef*>(object.data() + at),
                  &packed) != Z_OK) {
    refuse_plot("has a stream that zlib cannot unpack");
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
  if (width == 0 || width > 24) refuse_plot("has no table of its objects");
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
      if (!numbers || from > to || to > packed.size()) refuse_plot("has packed objects without places");
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
    if (!place.found()) refuse_plot(fmt::format("has no {}", begins));
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

std::array<Corner, 4> SvgText::corners() const {
  std::array<Corner, 4> all;
  for (std::size_t i = 0; i < 4; ++i) {
    const double u = (i % 2 == 0 ? -1 : 1) * half_width, v = (i < 2 ? -1 : 1) * half_height;
    all[i] = {middle.x + u * along.x - v * along.y, middle.y + u * along.y + v * along.x};
  }
  return all;
}

std::vector<SvgText> texts_of_svg(std::string_view svg, const std::string& font_file) {
  constexpr std::string_view group = "<g transform=\"translate(";
  const auto number = [](std::string_view tag, std::string_view before) {
    const std::size_t at = tag.find(before);
    return at == std::string_view::npos ? 0 : std::atof(std::string(tag.substr(at + before.size(), 40)).c_str());
  };
  std::vector<SvgText> texts;
  for (std::size_t at = svg.find(group); at != std::string_view::npos; at = svg.find(group, at + 1)) {
    const std::string_view tag = svg.substr(at, svg.find('>', at) - at);
    const std::size_t begin = svg.find("<text", at), end = svg.find("</text>", at);
    if (end == std::string_view::npos || begin > end || svg.find("</g>", at) < begin) continue;
    std::string markup;  // without the marks of what is italic, raised or lowered
    for (std::size_t i = begin; i < end; ++i) {
      if (svg[i] == '<')
        i = svg.find('>', i);
      else
        markup += svg[i];
    }
    const std::string text = unescaped(markup);
    if (text.find_first_not_of(' ') == std::string::npos) continue;
    const double size = number(tag, "font-size=\""), width = Font(size, font_file).width(text);
    const double above = 0.75 * size, below = 0.2 * size, angle = number(tag, "rotate(") * std::numbers::pi / 180;
    const bool ends = tag.find("\"end\"") != std::string_view::npos,
               centred = tag.find("\"middle\"") != std::string_view::npos;
    const double u = (ends ? -0.5 : centred ? 0 : 0.5) * width, v = 0.5 * (below - above);
    const Corner along{std::cos(angle), std::sin(angle)};
    texts.push_back({text,
                     {number(tag, group) + u * along.x - v * along.y, number(tag, ",") + u * along.y + v * along.x},
                     0.5 * width,
                     0.5 * (above + below),
                     along});
  }
  return texts;
}

std::string clipped_text(std::string_view svg, const std::string& font_file) {
  constexpr double tolerance = 2;
  const Span view = between(svg, "viewBox=\"", "\"");
  double left = 0, top = 0, width = 0, height = 0;
  if (view.found())
    std::istringstream(std::string(svg.substr(view.begin, view.length))) >> left >> top >> width >> height;
  for (const SvgText& one : texts_of_svg(svg, font_file)) {
    for (const Corner& corner : one.corners()) {
      if (std::max({-corner.x, -corner.y, corner.x - width, corner.y - height}) > tolerance) return one.text;
    }
  }
  return {};
}

namespace {

std::filesystem::path temporary_folder() {
  std::error_code error;
  std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  if (error) {
    throw EnvironmentError(
        "there is no folder for temporary files, since TMPDIR names something else; unset it, or name a folder");
  }
  return folder;
}

}  // namespace

ScratchFolder::ScratchFolder(const std::string& name) : ScratchFolder(temporary_folder(), name) {}

ScratchFolder::ScratchFolder(const std::filesystem::path& parent, const std::string& name) {
  make_folder(parent);
  std::string pattern = (parent / (scratch_name(name) + "-XXXXXX")).string();
  if (mkdtemp(pattern.data()) == nullptr) {
    throw EnvironmentError("cannot make a working folder in {}: {}; free space, or choose another --out or TMPDIR",
                           parent.string(), std::strerror(errno));
  }
  path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;  // a leftover hidden folder is harmless, a throwing destructor is not
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace granuscope
