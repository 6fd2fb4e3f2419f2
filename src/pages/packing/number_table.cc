#include "packing/number_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <limits>

#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/progress.h"

namespace granuscope {
namespace {

constexpr std::size_t told_problems = 5;

/// Goes through a text line by line, without the ends of lines of any system.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    ++number_;
    return true;
  }
  std::size_t number() const { return number_; }

 private:
  std::string_view rest_;
  std::size_t number_ = 0;
};

bool is_space(char c) { return c == ' ' || c == '\t'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

/// Hands over the cells of a line: between separators, or between blanks where `separator` is a blank.
template <class Take>
void for_each_cell(std::string_view line, char separator, const Take& take) {
  line = trimmed(line);
  while (!line.empty()) {
    std::size_t end = separator == ' ' ? line.find_first_of(" \t") : line.find(separator);
    const bool last = end == std::string_view::npos;
    if (last) end = line.size();
    take(trimmed(line.substr(0, end)));
    line.remove_prefix(std::min(end + 1, line.size()));
    if (separator == ' ') line = trimmed(line);
    if (line.empty() && !last && separator != ' ') take({});
  }
}

char separator_of(std::string_view line) {
  for (const char c : {',', ';'}) {
    if (line.find(c) != std::string_view::npos) return c;
  }
  return ' ';
}

/// Not a number where the cell is no number.
double number_in(std::string_view cell) {
  if (cell.size() > 1 && cell.starts_with('"') && cell.ends_with('"')) cell = cell.substr(1, cell.size() - 2);
  if (cell.starts_with('+')) cell.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  return error == std::errc() && end == cell.data() + cell.size() ? number : std::numeric_limits<double>::quiet_NaN();
}

/// A name of a column without quotes, its unit ("x: m", "x [m]", "x (m)") and capitals.
std::string plain_name(std::string_view cell) {
  std::string name;
  for (const char c :
       cell.substr(0, cell.find_first_of(cell.starts_with("c_") || cell.starts_with("f_") ? ":" : ":[("))) {
    if (c == '"' || c == '\'') continue;
    name += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return std::string(trimmed(name));
}

std::vector<std::string> names_in(std::string_view line, char separator) {
  std::vector<std::string> names;
  for_each_cell(line, separator, [&](std::string_view cell) { names.push_back(plain_name(cell)); });
  return names;
}

class Reader {
 public:
  Reader(const std::filesystem::path& file, std::string_view text, const std::vector<std::string>& columns)
      : file_(file), text_(text), columns_(columns), problems_(file) {}

  NumberTable dump(std::optional<double> wanted) {
    NumberTable table;
    table.dump = table.named = true;
    const Lines begin = step_at(wanted, table);
    Lines lines = begin;
    std::string_view line;
    std::size_t rows = 0;
    while (lines.next(line)) {
      if (line.starts_with("ITEM: NUMBER OF ")) {
        lines.next(line);
        rows = static_cast<std::size_t>(std::max(0.0, number_in(trimmed(line))));
      } else if (line.starts_with("ITEM: BOX BOUNDS")) {
        read_box(line, lines, table);
      } else if (line.starts_with("ITEM: TIMESTEP")) {
        break;
      } else if (line.starts_with("ITEM: ")) {
        std::vector<std::string> names = names_in(line.substr(6), ' ');
        if (!names.empty()) names.erase(names.begin());  // ENTRIES, BONDS, ATOMS
        set_columns(names, lines.number(), table);
        for (std::size_t row = 0; row < rows; ++row) {
          if (!lines.next(line) || line.starts_with("ITEM:")) {
            problems_.add(
                lines.number(),
                fmt::format("of {} lines that the step is to have, {} are there: the file is cut off", rows, row));
            break;
          }
          add_row(line, ' ', lines.number(), table);
        }
        if (rows == table.lines.size() && lines.next(line) && !trimmed(line).empty() && !line.starts_with("ITEM:")) {
          problems_.add(lines.number(), fmt::format("the step is to have {} lines, and goes on", rows));
        }
        break;
      }
    }
    return finished(std::move(table));
  }

  NumberTable plain() {
    NumberTable table;
    Lines lines(text_);
    char separator = 0;
    std::string_view comment;  // the last one before the numbers, which may hold the names
    for (std::string_view line; lines.next(line);) {
      line = trimmed(line);
      if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);
      if (line.empty() || line.starts_with('#') || line.starts_with('%')) {
        if (separator == 0 && comment.empty() && !line.empty()) comment = trimmed(line.substr(1));
        continue;
      }
      if (separator == 0) {
        separator = separator_of(line);
        bool numbers = true;
        for_each_cell(line, separator,
                      [&](std::string_view cell) { numbers = numbers && number_in(cell) == number_in(cell); });
        std::vector<std::string> names;
        if (!numbers) {
          names = names_in(line, separator);
        } else if (!comment.empty()) {
          names = names_in(comment, separator_of(comment));
          if (names.size() != names_in(line, separator).size()) names.clear();  // a remark
        }
        table.named = !names.empty();
        if (names.empty()) names.resize(names_in(line, separator).size());
        set_columns(names, lines.number(), table);
        if (!numbers) continue;
      }
      add_row(line, separator, lines.number(), table);
    }
    return finished(std::move(table));
  }

 private:
  /// Behind the line ITEM: TIMESTEP of the step that is wanted.
  Lines step_at(std::optional<double> wanted, NumberTable& table) {
    Lines lines(text_), found(text_);
    table.steps = 0;
    std::string steps;
    bool there = false;
    for (std::string_view line; lines.next(line);) {
      if (!line.starts_with("ITEM: TIMESTEP") || !lines.next(line)) continue;
      const double step = number_in(trimmed(line));
      if (table.steps++ < told_problems) steps += fmt::format(" {:g}", step);
      if (wanted && step != *wanted) continue;
      there = true;
      found = lines;
      table.step = step;
    }
    if (!there) {
      throw InputError(
          wanted ? fmt::format("{}: there is no step {:g} among its {}:{}{}; give one of them", file_.string(), *wanted,
                               table.steps, steps, table.steps > told_problems ? " ..." : "")
                 : fmt::format("{}: it begins as a dump of LAMMPS and has no ITEM: TIMESTEP", file_.string()));
    }
    return found;
  }

  void read_box(std::string_view header, Lines& lines, NumberTable& table) const {
    std::vector<std::string> flags = names_in(header.substr(16), ' ');
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::string_view line;
      if (!lines.next(line)) return;
      std::vector<double> bounds;
      for_each_cell(line, ' ', [&](std::string_view cell) { bounds.push_back(number_in(cell)); });
      if (bounds.size() > 2 && bounds[2] != 0) {
        throw InputError(fmt::format("{}, line {}: the box is tilted, which is not understood; unwrap the contacts",
                                     file_.string(), lines.number()));
      }
      // Of a tilted form three names of tilts come before the flags.
      if (axis < 2 && bounds.size() >= 2 && flags.size() >= 3 && flags[flags.size() - 3 + axis] == "pp") {
        table.periods[axis] = bounds[1] - bounds[0];
      }
    }
  }

  void set_columns(const std::vector<std::string>& names, std::size_t line, NumberTable& table) {
    if (!columns_.empty() && columns_.size() != names.size()) {
      throw InputError(fmt::format("{}, line {}: {} columns, and {} names are given: {}", file_.string(), line,
                                   names.size(), columns_.size(), fmt::join(columns_, ",")));
    }
    table.columns = columns_.empty() ? names : columns_;
  }

  void add_row(std::string_view line, char separator, std::size_t number, NumberTable& table) {
    if (number % 65536 == 0) throw_if_interrupted();
    const std::size_t before = table.numbers.size(), width = table.columns.size();
    for_each_cell(line, separator, [&](std::string_view cell) { table.numbers.push_back(number_in(cell)); });
    if (separator != ',' && line.find(',') != std::string_view::npos) {
      problems_.add(number, "a comma in a number: write a point for its decimals");
      table.numbers.resize(before);
      return;
    }
    if (const std::size_t cells = table.numbers.size() - before; cells != width) {
      problems_.add(number, fmt::format("{} cells instead of {}", cells, width));
      table.numbers.resize(before);
      return;
    }
    table.lines.push_back(number);
  }

  NumberTable finished(NumberTable table) const {
    problems_.raise();
    if (table.lines.empty()) {
      throw InputError(fmt::format("{}: there is no line of numbers in {}", file_.string(),
                                   table.step ? fmt::format("step {:g}; --step takes another", *table.step) : "it"));
    }
    return table;
  }

  const std::filesystem::path& file_;
  std::string_view text_;
  const std::vector<std::string>& columns_;
  LineProblems problems_;
};

}  // namespace

void LineProblems::add(std::size_t line, std::string_view what) {
  if (++count_ <= told_problems) told_ += fmt::format("\n  line {}: {}", line, what);
}

void LineProblems::raise() const {
  if (count_ == 0) return;
  throw InputError(
      fmt::format("{} cannot be taken as it is:{}{}", file_.string(), told_,
                  count_ > told_problems ? fmt::format("\n  and {} more lines", count_ - told_problems) : ""));
}

NumberTable read_number_table(const std::filesystem::path& file, const std::vector<std::string>& columns,
                              std::optional<double> step) {
  const std::string text = read_file(file);
  if (text.starts_with("\x89HDF")) {
    throw InputError(
        fmt::format("{}: it is HDF5; `granuscope export` writes the contacts of a pile as a table, and "
                    "`granuscope audit` looks at one",
                    file.string()));
  }
  if (text.find('\0') != std::string::npos) {
    throw InputError(
        fmt::format("{}: it is no text; give a table, or a dump of LAMMPS or LIGGGHTS as text", file.string()));
  }
  Reader reader(file, text, columns);
  return text.starts_with("ITEM:") ? reader.dump(step) : reader.plain();
}

}  // namespace granuscope
