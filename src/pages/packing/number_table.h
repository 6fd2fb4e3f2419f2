#pragma once
#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace granuscope {
/// One step of a text file with numbers in columns, as programs that simulate or track particles write them, or what a
/// file of VTK says of its lines or points.
struct NumberTable {
  std::vector<std::string> columns;                ///< names in small letters, without units
  std::vector<double> numbers;                     ///< [rows, columns], row-major; not a number where a cell is none
  std::vector<std::size_t> lines;                  ///< of each row, counted from 1; of VTK the cell or point, from 0
  std::string row_name = "line";                   ///< "cell", "point": what `lines` counts
  std::optional<double> step;                      ///< of a dump
  std::size_t steps = 1;                           ///< that the file has
  std::array<std::optional<double>, 2> periods{};  ///< x and y of a dump's box where it is periodic
  bool dump = false, named = false;                ///< of LAMMPS; with names of columns in the file
  bool usual = false;                              ///< has none, and got those that are usual for so many columns

  std::size_t rows() const { return lines.size(); }
  double at(std::size_t row, std::size_t column) const { return numbers[row * columns.size() + column]; }
};

/// What a table is read for: of a file of VTK contacts are its lines of two points, with the arrays of cells, and
/// particles its points.
enum class TableOf { contacts, particles };

/// How columns are called.
struct ColumnNames {
  std::vector<std::string> given;  ///< in the place of those of the file, or "NAME=COLUMN" for some of them; or none
  std::vector<std::vector<std::string>> usual;  ///< those of as many columns are taken for a file without names
};

/// A file of numbers, read once for all its steps.
class NumberFile {
 public:
  /// Throws InputError for a file that cannot be read, has no numbers, or lines of different lengths.
  NumberFile(std::filesystem::path file, ColumnNames names, TableOf part);
  /// `step`: of a dump; none: the last one. Throws InputError as above, and if it does not have that step; a step of a
  /// dump may be asked for even if it has no lines.
  std::shared_ptr<const NumberTable> read(std::optional<double> step, bool even_empty = false) const;
  /// Of a dump those that have any line.
  std::vector<double> steps() const;

 private:
  /// A step's number, and what is behind its first two lines.
  struct Step {
    double step = 0;
    std::size_t at = 0, line = 0;
    bool empty = false;
  };
  NumberTable dump(std::optional<double> step, bool even_empty) const;

  std::filesystem::path file_;
  ColumnNames names_;
  std::string text_;  ///< of a dump
  std::vector<Step> steps_;
  std::shared_ptr<const NumberTable> table_;  ///< of all others
};

/// What is wrong in a file, told together: the first few in words, and how many there are.
class LineProblems {
 public:
  explicit LineProblems(std::filesystem::path file, std::string row_name = "line")
      : file_(std::move(file)), row_name_(std::move(row_name)) {}
  void add(std::size_t line, std::string_view what);
  void add(const LineProblems& later);
  bool none() const { return count_ == 0; }
  /// Throws InputError if there are any.
  void raise() const;

 private:
  std::filesystem::path file_;
  std::string row_name_;
  std::vector<std::string> told_;
  std::size_t count_ = 0;
};

}  // namespace granuscope
