#pragma once
#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace granuscope {
/// One step of a text file with numbers in columns, as programs that simulate or track particles write them.
struct NumberTable {
  std::vector<std::string> columns;                ///< names in small letters, without units
  std::vector<double> numbers;                     ///< [rows, columns], row-major; not a number where a cell is none
  std::vector<std::size_t> lines;                  ///< of each row, counted from 1
  std::optional<double> step;                      ///< of a dump
  std::size_t steps = 1;                           ///< that the file has
  std::array<std::optional<double>, 2> periods{};  ///< x and y of a dump's box where it is periodic
  bool dump = false, named = false;                ///< of LAMMPS; with names of columns in the file

  std::size_t rows() const { return lines.size(); }
  double at(std::size_t row, std::size_t column) const { return numbers[row * columns.size() + column]; }
};

/// Reads a file. `columns` stand in for its names, if not empty. `step`: of a dump; none: the last one. Throws
/// InputError for a file that cannot be read, has no numbers, lines of different lengths, or does not have that step.
NumberTable read_number_table(const std::filesystem::path& file, const std::vector<std::string>& columns,
                              std::optional<double> step);

/// What is wrong in a file, told together: the first few in words, and how many there are.
class LineProblems {
 public:
  explicit LineProblems(std::filesystem::path file) : file_(std::move(file)) {}
  void add(std::size_t line, std::string_view what);
  /// Throws InputError if there are any.
  void raise() const;

 private:
  std::filesystem::path file_;
  std::string told_;
  std::size_t count_ = 0;
};

}  // namespace granuscope
