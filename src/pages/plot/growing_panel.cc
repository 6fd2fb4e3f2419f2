#include "plot/growing_panel.h"

#include <utility>

#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {

void GrowingPanel::add(Plot& plot, const std::string& name, const CurveRows& rows, const Style& style,
                       const std::string& x_column, const std::string& y_column) {
  if (rows.empty()) return;
  const bool line = style.with == "lines";
  std::vector<std::string> columns = {x_column, y_column};
  if (!line) columns.push_back("standard_error" + y_column.substr(y_column.find(':')));
  CsvTable table(columns);
  for (const auto& row : rows) {
    table.add_row({row.begin(), row.end() - (line ? 1 : 0)});
    const auto& [at, value, error] = row;
    x.add(at);
    // With its bar, where that is not the whole of a logarithmic axis.
    for (const double end : {value - error, value, value + error}) {
      if (end > 0 || !log_y) y.add(end);
    }
  }
  panel.add(plot.add_data(name, table), line ? "1:2" : "1:2:3", style);
}

Panel GrowingPanel::whole(Panel filled) const {
  if (panel.curves.empty()) {
    throw InputError(
        "the panel of {} against {} has nothing to show, because nothing of it was measured well enough; ask for more "
        "samples",
        y_label, x_label);
  }
  const auto linear = [](const std::string& label, const Range& range) {
    const double margin = range.size() > 0 ? 0.06 * range.size() : 0.5;
    return linear_axis(label, {range.low == 0 ? 0 : range.low - margin, range.high + margin, false}, 6, range);
  };
  filled.curves = panel.curves;
  filled.x = linear(x_label, x);
  filled.y = log_y ? log_axis(y_label, widened_by_factor(y, 1.3)) : linear(y_label, y);
  return filled;
}

Plot two_panels(const char* id) {
  Plot plot;
  plot.id = id;
  plot.height = 3.2;
  plot.key = {.inches = 0.72, .lines = 3, .entries = {}};
  return plot;
}

Figure plot_panels(Plot& plot, const GrowingPanel& left, const GrowingPanel& right, TemplateVariables variables,
                   const std::filesystem::path& run_folder) {
  plot.panels = {left.whole(left_panel()), right.whole(right_panel())};
  std::string file = plot.id;
  for (char& letter : file) letter = letter == '-' ? '_' : letter;
  return plot_figure(plot, {"studies/" + file + ".captions", std::move(variables)}, run_folder);
}

}  // namespace granuscope
