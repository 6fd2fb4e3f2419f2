#include "plot/gnuplot.h"

#include <fmt/format.h>

#include <cctype>
#include <utility>

#include "plot/csv_table.h"
#include "plot/file_label.h"
#include "plot/scratch_folder.h"
#include "support/atomic_file.h"
#include "support/child_process.h"
#include "support/error.h"
#include "support/single_line.h"

namespace granuscope {

namespace {

constexpr std::string_view creation_date_key = "/CreationDate (";

bool ends_with_mark(std::string_view text, std::string_view mark) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.remove_suffix(1);
  return text.ends_with(mark);
}

[[noreturn]] void fail(const GnuplotJob& job, const std::string& what) {
  throw EnvironmentError(
      fmt::format("gnuplot did not plot {}: {}; the figure would be missing or wrong. Run `granuscope doctor` to see "
                  "whether gnuplot-nox and fonts-dejavu-core are as expected",
                  job.stem, what));
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

/// Runs the script in `folder`, `settings` before it, and takes nothing but silence for success.
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
  if (!result.standard_error.empty()) fail(job, "it complained: " + single_line(result.standard_error));
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
    throw EnvironmentError(
        "gnuplot is not installed, so no plot can be made; install it with "
        "`apt-get install gnuplot-nox fonts-dejavu-core`");
  }
}

void plot_with_gnuplot(const GnuplotJob& job, const std::filesystem::path& folder, double timeout_seconds) {
  require_gnuplot();
  for (const auto& [name, csv] : job.data) {
    if (const std::string column = column_without_numbers(csv); !column.empty()) {
      fail(job, fmt::format("column {} of {} holds no number at all", column, name));
    }
  }

  const ScratchFolder scratch(folder, job.stem);
  write_file(scratch.path() / (job.stem + ".gp"), job.script);
  for (const auto& [name, csv] : job.data) write_file(scratch.path() / name, csv);

  run_script(job, scratch.path(), {}, timeout_seconds);
  std::string svg = read_svg(job, scratch.path());
  std::string pdf = without_creation_date(read_plot(job, scratch.path() / (job.stem + ".pdf"), "%%EOF"));
  std::string narrow;
  if (job.narrow_inches > 0) {
    run_script(job, scratch.path(), {"-e", fmt::format("only = 'svg'; width = {}", job.narrow_inches)},
               timeout_seconds);
    narrow = read_svg(job, scratch.path());
  }

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
  for (const char c : text) {
    if (c == '\'') {
      quoted += "''";
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      quoted += ' ';
    } else {
      quoted += c;
    }
  }
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
  constexpr std::string_view untitled = "<title>gnuplot_plot_";
  int visible = 0;
  for (std::size_t start = svg.find(curve_start); start != std::string_view::npos;
       start = svg.find(curve_start, start + curve_start.size())) {
    const std::string_view curve = svg.substr(start, group_length(svg.substr(start)));
    if (curve.find(untitled) == std::string_view::npos) continue;
    for (const std::string_view mark : {"<path", "<polygon", "<polyline", "<use", "<circle", "<rect"}) {
      if (curve.find(mark) != std::string_view::npos) {
        ++visible;
        break;
      }
    }
  }
  return visible;
}

}  // namespace granuscope
