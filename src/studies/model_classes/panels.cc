#include "panels.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "plot/csv_table.h"
#include "plot/series_style.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// In the style of a series: its colour, and dashes for lines.
std::string appearance(std::size_t colour, CurveKind kind) {
  const std::string style = series_style(colour);
  if (kind == CurveKind::points) return "points pointsize 0.6 linewidth 1 " + style;
  if (kind == CurveKind::joined_points) return "linespoints pointsize 0.55 linewidth 1 " + style;
  return "lines linewidth 1 " + style.substr(style.find("linecolor"));
}

void add_axis(TemplateVariables& variables, const std::string& name, Range range, bool logarithmic) {
  const std::string ticks = logarithmic ? log_ticks(widened_by_factor(range, 1.3)) : linear_ticks(range, 6);
  const double margin = range.size() > 0 ? 0.06 * range.size() : 0.5;
  const Range shown = logarithmic ? widened_by_factor(range, 1.3)
                                  : Range{range.low == 0 ? 0 : range.low - margin, range.high + margin, false};
  variables[name + "_low"] = exact(shown.low);
  variables[name + "_high"] = exact(shown.high);
  variables[name + "_ticks"] = ticks;
}

void add_panel(TemplateVariables& variables, const std::string& side, const ModelPanel& panel) {
  if (panel.curves.empty()) {
    throw InputError(fmt::format(
        "the panel of {} against {} has nothing to show, because nothing of it was measured well enough; ask for more "
        "samples",
        panel.y_label, panel.x_label));
  }
  variables[side + "_x"] = panel.x_label;
  variables[side + "_y"] = panel.y_label;
  variables[side + "_scale"] = !panel.log_x && !panel.log_y
                                   ? ""
                                   : fmt::format("set logscale {}{}", panel.log_x ? "x" : "", panel.log_y ? "y" : "");
  variables[side + "_curves"] = fmt::format("{}", fmt::join(panel.curves, ", \\\n    "));
  add_axis(variables, side + "_x", panel.x, panel.log_x);
  add_axis(variables, side + "_y", panel.y, panel.log_y);
}

}  // namespace

void add_curve(PlotPlan& plan, ModelPanel& panel, const std::string& name, const CurveRows& rows, CurveKind kind,
               std::size_t colour, const std::string& x_column, const std::string& y_column) {
  if (rows.empty()) return;
  const bool line = kind == CurveKind::line;
  const std::string unit = y_column.substr(y_column.find(':'));
  CsvTable table(line ? std::vector<std::string>{x_column, y_column}
                      : std::vector<std::string>{x_column, y_column, "standard_error" + unit});
  for (const auto& [x, y, error] : rows) {
    table.add_row(line ? std::vector<double>{x, y} : std::vector<double>{x, y, error});
    panel.x.add(x);
    // With its bar, where that is not the whole of a logarithmic axis.
    for (const double end : {y - error, y, y + error}) {
      if (end > 0 || !panel.log_y) panel.y.add(end);
    }
  }
  const std::string file = fmt::format("{}-{}.csv", plan.id, name), with = appearance(colour, kind);
  plan.data[file] = table.text();
  if (!line) {
    const std::string bars = kind == CurveKind::points ? "yerrorbars" : "yerrorlines";
    panel.curves.push_back(
        fmt::format("'{}' using 1:2:3 with {} {} notitle", file, bars, with.substr(with.find(' ') + 1)));
  } else {
    panel.curves.push_back(fmt::format("'{}' using 1:2 with {} notitle", file, with));
  }
  ++plan.curves;
}

std::string key_entry(const std::string& title, std::size_t colour, CurveKind kind) {
  return fmt::format("keyentry with {} title {}", appearance(colour, kind), gnuplot_string(title));
}

Figure plot_panels(PlotPlan plan, const ModelPanel& left, const ModelPanel& right,
                   const std::vector<std::string>& titles, const Wording& wording,
                   const std::filesystem::path& run_folder) {
  plan.script = "studies/model_panels";
  plan.height = 3.2;
  TemplateVariables variables = {{"titles", fmt::format("{}", fmt::join(titles, ", \\\n    "))}};
  add_panel(variables, "left", left);
  add_panel(variables, "right", right);
  return plot_figure(plan, variables, wording, run_folder);
}

}  // namespace granuscope
