#include "report/pdf_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <vector>

#include "plot/gnuplot.h"
#include "report/page_overlays.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/process.h"

namespace granuscope {
namespace {

/// WeasyPrint has no switch against it: a page, a style sheet or an SVG in it can have files of this computer attached,
/// or ask servers. All that is loaded passes Python's urlopen, which tells this hook. The folder that it makes shows
/// that it was there.
constexpr const char* hook_against_loading = R"(import os, sys
def refuse(event, arguments):
    if event == 'urllib.Request' and not str(arguments[0]).lower().startswith('data:'):
        raise PermissionError('a report holds all it needs, and loads nothing')
sys.addaudithook(refuse)
os.makedirs('loads-nothing', exist_ok=True)
)";

constexpr const char* install = "install it with `apt-get install weasyprint fonts-dejavu-core`";

PdfOutcome failed(const std::string& why) {
  return {"", fmt::format("report.pdf was not written: {}. report.html holds the same, and can be printed.", why)};
}

/// Where Python says what went wrong, after telling where.
std::string_view last_line(std::string_view text) {
  while (!text.empty() && text.back() == '\n') text.remove_suffix(1);
  return text.substr(text.rfind('\n') + 1);
}

bool ends_as_pdf(const std::string& bytes) {
  return bytes.starts_with("%PDF-") &&
         bytes.find("%%EOF", bytes.size() < 16 ? 0 : bytes.size() - 16) != std::string::npos;
}

}  // namespace

PdfOutcome pdf_report(const ReportData& data, const Json& summary, const std::filesystem::path& run_folder,
                      double timeout_seconds) {
  if (!find_program("weasyprint")) return failed(missing_program("weasyprint", "nothing can be typeset", install));

  const std::string page = report_page(data, summary, run_folder, PageMedium::print);
  const ScratchFolder scratch(run_folder, "report-pdf");
  write_file(scratch.path() / "report.html", page);
  write_file(scratch.path() / "sitecustomize.py", hook_against_loading);  // Python runs it first

  ProcessSpec process;
  // The page holds all it needs. Without a base of our own WeasyPrint makes one of the folder's name, and gives up on a
  // name that is not UTF-8.
  process.arguments = {"weasyprint",    "--encoding", "utf-8",       "--base-url", "about:blank",
                       "--pdf-variant", "pdf/ua-1",   "report.html", "report.pdf"};
  process.working_folder = scratch.path();
  // A fixed date makes the same report the same bytes. Font caches go into the scratch folder, where they can be
  // written.
  process.environment = {{"LC_ALL", "C.UTF-8"},
                         {"SOURCE_DATE_EPOCH", "946684800"},
                         {"PYTHONPATH", "."},
                         {"PYTHONDONTWRITEBYTECODE", "1"},
                         {"HOME", scratch.path().string()},
                         {"XDG_CACHE_HOME", scratch.path().string()}};
  process.timeout_seconds = timeout_seconds;
  ProcessResult result;
  try {
    result = run_process(process);
  } catch (const EnvironmentError& error) {
    return failed(error.what());
  }
  if (result.exit_code != 0) {
    try {
      require_room(scratch.path());  // of a full disk Python says little
    } catch (const EnvironmentError& full) {
      return failed(full.what());
    }
  }
  if (result.timed_out) return failed(fmt::format("WeasyPrint was still running after {:.0f} s", timeout_seconds));
  if (result.exit_code != 0) {
    const std::string said = single_line(last_line(result.standard_error));
    return failed(fmt::format("WeasyPrint {}{}{}", describe_end(result), said.empty() ? "" : ": ", said));
  }
  // It ends with status 0 even if an image or a style sheet could not be loaded.
  if (result.standard_error.find("ERROR") != std::string::npos) {
    return failed("WeasyPrint could not load a part of the page: " + single_line(result.standard_error));
  }
  if (!path_exists(scratch.path() / "loads-nothing")) {
    return failed("this WeasyPrint could not be kept from loading files and pages of the web");
  }
  if (!path_exists(scratch.path() / "report.pdf")) return failed("WeasyPrint left no file");
  PdfOutcome outcome;
  outcome.bytes = read_file(scratch.path() / "report.pdf");
  if (!ends_as_pdf(outcome.bytes)) return failed("WeasyPrint left a file that is cut off");
  return outcome;
}

std::string data_uri(const std::string& media_type, std::string_view bytes) {
  return "data:" + media_type + ";base64," + base64(bytes);
}

std::string text_uri(const std::string& media_type, std::string_view text) {
  return "data:" + media_type + "," + percent_encoded(text, "\"#%&:<");
}

namespace {

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t number = 0;
  for (const char byte : bytes.substr(0, 4)) number = number << 8U | static_cast<unsigned char>(byte);
  return number;
}

}  // namespace

std::optional<double> png_width_mm(std::string_view png) {
  constexpr std::string_view signature = "\x89PNG\r\n\x1a\n";
  constexpr std::size_t chunk_frame = 12;  // length, type, checksum
  if (!png.starts_with(signature)) return std::nullopt;
  std::uint32_t width = 0;
  for (std::size_t at = signature.size(); at + chunk_frame <= png.size();) {
    const std::size_t length = big_endian(png.substr(at));
    const std::string_view type = png.substr(at + 4, 4);
    if (length > png.size() - at - chunk_frame) return std::nullopt;
    const std::string_view content = png.substr(at + 8, length);
    if (type == "IHDR" && length >= 4) width = big_endian(content);
    if (type == "pHYs" && length == 9 && content[8] == 1) {  // unit: pixels per metre
      const std::uint32_t per_metre = big_endian(content);
      if (per_metre == 0 || width == 0) return std::nullopt;
      return 1000.0 * width / per_metre;
    }
    if (type == "IDAT") return std::nullopt;
    at += chunk_frame + length;
  }
  return std::nullopt;
}

namespace {

// Plain searches rather than std::regex, whose recursion does not survive path data of some hundred kilobytes.
constexpr std::string_view glyph_reference = "xlink:href='#gp";
constexpr std::string_view identity = " id='gp";
constexpr std::string_view colour_start = " color='";
constexpr std::string_view current_colour = "currentColor";

/// A line of gnuplot's <defs> that defines a point shape: gpPt0 ... gpPt14 and gpDot.
bool defines_shape(std::string_view line) {
  return line.find(" id='gpPt") != std::string_view::npos || line.find(" id='gpDot'") != std::string_view::npos;
}

/// A line that plots one point: refers to a shape and names a colour.
bool draws_point(std::string_view line) {
  return line.find("<use " + std::string(glyph_reference)) != std::string_view::npos &&
         line.find(colour_start) != std::string_view::npos;
}

/// Appends `suffix` to the name that follows the first `mark` in the line, if there is one.
void extend_name(std::string& line, std::string_view mark, const std::string& suffix) {
  const std::size_t start = line.find(mark);
  if (start == std::string::npos) return;
  line.insert(line.find('\'', start + mark.size()), suffix);
}

std::string suffix_for(std::vector<std::string>& colours, const std::string& colour) {
  std::size_t index = 0;
  while (index < colours.size() && colours[index] != colour) ++index;
  if (index == colours.size()) colours.push_back(colour);
  return fmt::format("-c{}", index);
}

/// The point's line with its colour taken out and a reference to the shape of that colour.
std::string coloured_point(std::string line, std::vector<std::string>& colours) {
  const std::size_t start = line.find(colour_start);
  const std::size_t value = start + colour_start.size();
  const std::size_t end = line.find('\'', value);
  if (end == std::string::npos) return line;
  const std::string colour = line.substr(value, end - value);
  line.erase(start, end + 1 - start);
  extend_name(line, glyph_reference, suffix_for(colours, colour));
  return line;
}

std::string definition_in(std::string line, const std::string& colour, std::size_t index) {
  const std::string suffix = fmt::format("-c{}", index);
  extend_name(line, identity, suffix);
  extend_name(line, glyph_reference, suffix);
  for (std::size_t at = line.find(current_colour); at != std::string::npos; at = line.find(current_colour, at)) {
    line.replace(at, current_colour.size(), colour);
    at += colour.size();
  }
  return line;
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = text.find('\n', start);
    const std::size_t next = end == std::string_view::npos ? text.size() : end + 1;
    lines.emplace_back(text.substr(start, next - start));
    start = next;
  }
  return lines;
}

}  // namespace

std::string svg_for_weasyprint(std::string_view svg) {
  std::vector<std::string> lines = lines_of(svg);
  std::vector<std::string> colours;
  for (std::string& line : lines) {
    if (!defines_shape(line) && draws_point(line)) line = coloured_point(line, colours);
  }
  if (colours.empty()) return std::string(svg);

  // The original definitions go: nothing refers to them any more. Their copies stand where the first one stood.
  std::string before, definitions, after;
  std::vector<std::string> shapes;
  for (const std::string& line : lines) {
    if (defines_shape(line)) {
      shapes.push_back(line);
    } else {
      (shapes.empty() ? before : after) += line;
    }
  }
  for (std::size_t i = 0; i < colours.size(); ++i) {
    for (const std::string& shape : shapes) definitions += definition_in(shape, colours[i], i);
  }
  return before + definitions + after;
}

}  // namespace granuscope
