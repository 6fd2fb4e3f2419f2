#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>

#include "cli/flag_checks.h"
#include "cli/verbs.h"
#include "plot/gnuplot.h"
#include "report/finished_run.h"
#include "support/atomic_file.h"
#include "support/template_file.h"

namespace granuscope {
namespace {

struct FigureOptions {
  std::string folder, id, width, font_size, templates;
  OutputFile file;
  FigureStyle style;
};

struct Unit {
  std::string_view name;
  double scale;
};

/// A number above 0 with a unit behind it, or without, which is the first one; 0 for any other text.
double measure_in(const std::string& text, std::initializer_list<Unit> units) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || !(number > 0)) return 0;
  const std::string_view unit = end;
  if (unit.empty()) return number * units.begin()->scale;
  for (const Unit& known : units) {
    if (unit == known.name) return number * known.scale;
  }
  return 0;
}

double millimetres(const std::string& text) {
  const double width = measure_in(text, {{"mm", 1}, {"cm", 10}, {"in", 25.4}});
  if (width > 0) return width;
  throw InputError(fmt::format("--width {} is no width; write 86mm, 8.6cm or 3.37in", text));
}

double points(const std::string& text) {
  const double size = measure_in(text, {{"pt", 1}});
  if (size > 0) return size;
  throw InputError(fmt::format("--font-size {} is no size of text; write 8pt or 8", text));
}

ExitCode plot_figure_again(FigureOptions options, VerbContext& context) {
  if (!options.templates.empty()) use_templates(options.templates);
  if (!options.width.empty()) options.style.width_mm = millimetres(options.width);
  if (!options.font_size.empty()) options.style.font_points = points(options.font_size);
  const auto figures = std::filesystem::path(options.folder) / "figures";
  if (options.id.empty()) {
    for (const std::string& id : plots_in(figures)) context.out << id << '\n';
    return ExitCode::done;
  }
  require_results_of_last_run(options.folder, "plot");
  const PlottedFigure plotted = plot_again(figures, options.id, options.style);
  if (!options.file.asked()) options.file.path = options.id + "." + options.style.format;
  options.file.write(plotted.bytes, {options.folder});
  if (plotted.other_script) {
    context.err << fmt::format(
        "figures/{0}.gp is not what figures/{0}.json gives with the templates of now; the figure was plotted from the "
        "latter (--trust-script runs the script as it stands)\n",
        options.id);
  }
  context.err << fmt::format("wrote {}\n", options.file.path);
  if (!plotted.caption.empty()) context.out << fmt::format("{}. {}\n", plotted.title, plotted.caption);
  return ExitCode::done;
}

}  // namespace

void add_figure_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand(
      "figure", "Plot a figure of a finished run again, in another size, font or format, and print its caption");
  const auto options = std::make_shared<FigureOptions>();
  verb->add_option("OUT", options->folder, "folder of the run")->required();
  verb->add_option("ID", options->id,
                   "which figure: the name of its files, for example scaling-with-friction (a list if not given)");
  verb->add_option("--format", options->style.format,
                   "pdf, svg, eps, png (300 dpi), or tikz, with TeX's own mathematics")
      ->capture_default_str();
  verb->add_option(
      "--width", options->width,
      "86mm, 8.6cm or 3.37in; panels stand one above the other where it is narrow (as in the report, 170mm)");
  verb->add_option("--font", options->style.font,
                   "of all text, as fontconfig names it; TeX: set by TeX with its own mathematics, as eps (needs latex "
                   "and dvips)")
      ->capture_default_str();
  verb->add_option("--font-size", options->font_size,
                   fmt::format("8pt, or 8; room around the axes grows with it (as in the report, {:g}pt)",
                               options->style.font_points));
  verb->add_option("--language", options->style.language, "of its texts and decimal point: en, fr or de")
      ->capture_default_str();
  verb->add_option(
      "--templates", options->templates,
      "folder whose files stand in for those of the same name in templates/: plot scripts, labels, captions, palette");
  verb->add_flag("--trust-script", options->style.trust_script,
                 "run figures/ID.gp as it stands, which can do all that you can; without it the script is filled again "
                 "from figures/ID.json");
  add_output(*verb, "-o,--out", options->file, "file to write (default: ID and the format, here)");
  verb->callback(
      [options, &context] { context.action = [options, &context] { return plot_figure_again(*options, context); }; });
}

}  // namespace granuscope
