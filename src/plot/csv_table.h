#pragma once
#include <string>
#include <vector>

namespace granuscope {

/// Numbers in named columns, as comma-separated text: a line of names, one of units, then the numbers. Unknown numbers
/// are written as NaN, which gnuplot leaves out; all others in the shortest form that reads back to the same double.
class CsvTable {
 public:
  /// Columns as "name: unit", "dimensionless" if they have none (a number would be a point to gnuplot).
  explicit CsvTable(const std::vector<std::string>& columns);
  void add_row(const std::vector<double>& numbers);
  bool empty() const { return rows_ == 0; }
  const std::string& text() const { return text_; }

 private:
  std::size_t columns_;
  std::size_t rows_ = 0;
  std::string text_;
};

/// The first column of a CSV text (lines of names and units, numbers) that holds no finite number, or nothing: a curve
/// plotted from it would silently be empty.
std::string column_without_numbers(const std::string& csv);

}  // namespace granuscope
