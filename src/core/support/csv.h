#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace granuscope {
/// Every CSV file of the program: a line of names, one of units that begins with #, then rows. So pandas reads it with
/// comment="#", numpy.loadtxt with delimiter="," and skiprows=1, numpy.genfromtxt with names=True.
class CsvTable {
 public:
  /// Columns as "name: unit", "dimensionless" if they have none; names alone, and no line of units, for a table of
  /// texts.
  explicit CsvTable(const std::vector<std::string>& columns);
  /// Unknown numbers are written as NaN, which gnuplot leaves out; all others in the shortest form that reads back to
  /// the same double.
  void add_row(const std::vector<double>& numbers);
  void add_cells(const std::vector<std::string>& cells);
  bool empty() const { return rows_ == 0; }
  const std::string& text() const { return text_; }

 private:
  std::size_t columns_;
  std::size_t rows_ = 0;
  std::string text_;
};
}  // namespace granuscope
