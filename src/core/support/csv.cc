#include "support/csv.h"

#include <cmath>
#include <stdexcept>

#include "support/plain_text.h"

namespace granuscope {
namespace {

/// Quoted where a comma, a quote or the end of a line would end it.
std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + '"';
}

}  // namespace

CsvTable::CsvTable(const std::vector<std::string>& columns) : columns_(columns.size()) {
  std::vector<std::string> names, units;
  for (const std::string& column : columns) {
    const std::size_t at = column.find(": ");
    names.push_back(column.substr(0, at));
    if (at != std::string::npos) units.push_back(column.substr(at + 2));
  }
  if (!units.empty() && units.size() != names.size())
    throw std::logic_error("a column of " + names[0] + " has no unit");
  add_cells(names);
  if (!units.empty()) {
    units.front().insert(0, "#");
    add_cells(units);
  }
  rows_ = 0;
}

void CsvTable::add_row(const std::vector<double>& numbers) {
  std::vector<std::string> cells;
  cells.reserve(numbers.size());
  for (const double number : numbers) cells.push_back(std::isfinite(number) ? exact(number) : "NaN");
  add_cells(cells);
}

void CsvTable::add_cells(const std::vector<std::string>& cells) {
  if (cells.size() != columns_) throw std::logic_error("a row of a table has other cells than it has columns");
  for (std::size_t i = 0; i < cells.size(); ++i) text_ += (i > 0 ? "," : "") + csv_cell(cells[i]);
  text_ += '\n';
  ++rows_;
}

}  // namespace granuscope
