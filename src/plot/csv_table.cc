#include "plot/csv_table.h"

#include <cassert>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "support/number_format.h"

namespace granuscope {

CsvTable::CsvTable(const std::vector<std::string>& columns) : columns_(columns.size()) {
  std::string units;
  for (const std::string& column : columns) {
    const std::size_t at = column.find(": ");
    if (at == std::string::npos) throw std::logic_error("the column " + column + " has no unit");
    const char* const comma = units.empty() ? "" : ",";
    text_ += comma + column.substr(0, at);
    units += comma + column.substr(at + 2);
  }
  text_ += '\n' + units + '\n';
}

void CsvTable::add_row(const std::vector<double>& numbers) {
  assert(numbers.size() == columns_);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0) text_ += ',';
    text_ += std::isfinite(numbers[i]) ? exact(numbers[i]) : "NaN";
  }
  text_ += '\n';
  ++rows_;
}

namespace {

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> parts;
  std::stringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) parts.push_back(cell);
  return parts;
}

}  // namespace

std::string column_without_numbers(const std::string& csv) {
  std::stringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> names = cells(line);
  std::vector<bool> has_number(names.size(), false);
  while (std::getline(lines, line)) {
    const std::vector<std::string> row = cells(line);
    for (std::size_t i = 0; i < row.size() && i < names.size(); ++i) {
      char* end = nullptr;
      const double number = std::strtod(row[i].c_str(), &end);
      if (end != row[i].c_str() && *end == '\0' && std::isfinite(number)) has_number[i] = true;
    }
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!has_number[i]) return names[i];
  }
  return {};
}

}  // namespace granuscope
