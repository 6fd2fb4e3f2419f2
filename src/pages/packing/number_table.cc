#include "packing/number_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <span>

#include "packing/vtk_table.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/progress.h"
#include "support/provenance.h"

namespace granuscope {
namespace {

constexpr std::size_t told_problems = 5;
constexpr std::size_t worth_threads = 100'000;  // rows
constexpr double memory_of_text = 3;  // of a byte: itself, its numbers, and contacts and particles made of them

/// Goes through a text line by line, without the ends of lines of any system.
class Lines {
 public:
  explicit Lines(std::string_view text, std::size_t before = 0) : rest_(text), number_(before) {}
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
  std::size_t left() const { return rest_.size(); }

 private:
  std::string_view rest_;
  std::size_t number_;
};

/// Hands over the cells of a line: between separators, or between blanks where `separator` is a blank.
template <class Take>
void for_each_cell(std::string_view line, char separator, const Take& take) {
  line = trimmed(line);
  while (!line.empty()) {
    // Cells are short: looking for one of several signs with find_first_of takes ten times as long.
    const auto parts = [separator](char c) { return c == separator || (separator == ' ' && c == '\t'); };
    const auto end = static_cast<std::size_t>(std::find_if(line.begin(), line.end(), parts) - line.begin());
    const bool last = end == line.size();
    take(trimmed(line.substr(0, end)));
    line.remove_prefix(std::min(end + 1, line.size()));
    if (separator == ' ') line = trimmed(line);
    if (line.empty() && !last && separator != ' ') take({});
  }
}

char separator_of(std::string_view line) {
  for (const char c : {';', ','}) {  // where the former separates, the latter is a decimal comma
    if (line.find(c) != std::string_view::npos) return c;
  }
  return ' ';
}

/// Not a number where the cell is no number. Between semicolons a comma is that of decimals, as spreadsheets write it.
double number_in(std::string_view cell, char separator = ' ') {
  if (cell.size() > 1 && cell.starts_with('"') && cell.ends_with('"')) cell = cell.substr(1, cell.size() - 2);
  if (cell.starts_with('+')) cell.remove_prefix(1);
  std::string with_point;
  if (separator == ';' && cell.find(',') != std::string_view::npos)
    std::ranges::replace(with_point = cell, ',', '.'), cell = with_point;
  double number = 0;
  return read_whole(cell, number) ? number : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

std::string plain_name(std::string_view cell) {
  std::string name;
  for (const char c :
       cell.substr(0, cell.find_first_of(cell.starts_with("c_") || cell.starts_with("f_") ? ":" : ":[("))) {
    if (c == '"' || c == '\'') continue;
    name += c;
  }
  return lower_case(std::string(trimmed(name)));
}

namespace {

std::vector<std::string> names_in(std::string_view line, char separator) {
  std::vector<std::string> names;
  for_each_cell(line, separator, [&](std::string_view cell) { names.push_back(plain_name(cell)); });
  return names;
}

/// Whether names are given for some columns only: "N=normal_force".
bool renames(const std::vector<std::string>& given) {
  return std::ranges::any_of(given, [](const std::string& one) { return one.find('=') != std::string::npos; });
}

/// Gives the names of "NAME=COLUMN"; a column that had the name loses it.
void rename(const std::filesystem::path& file, const std::vector<std::string>& given, NumberTable& table) {
  if (!renames(given)) return;
  const std::vector<std::string> found = table.columns;
  for (const std::string& one : given) {
    const std::size_t equals = one.find('=');
    const std::string name = plain_name(one.substr(0, equals)),
                      of = plain_name(one.substr(std::min(equals, one.size() - 1) + 1));
    const auto at = std::ranges::find(found, of);
    if (equals == std::string::npos || name.empty() || at == found.end()) {
      throw InputError("{}: {} names no column; give NAME=COLUMN, of the columns {}", file.string(), one,
                       fmt::join(found, ", "));
    }
    std::ranges::replace(table.columns, name, "_" + name);
    table.columns[static_cast<std::size_t>(at - found.begin())] = name;
  }
}

class Reader {
 public:
  Reader(const std::filesystem::path& file, const ColumnNames& names) : file_(file), names_(names), problems_(file) {}

  /// `lines`: behind the first two of the step.
  NumberTable dump(Lines lines, NumberTable table, bool even_empty) {
    table.dump = table.named = true;
    std::string_view line;
    std::size_t rows = 0;
    bool whole = false;
    while (lines.next(line)) {
      if (line.starts_with("ITEM: NUMBER OF ")) {
        lines.next(line);
        const double told = number_in(trimmed(line));
        if (!(told >= 0 && told < 1e15 && told == std::floor(told))) {
          throw InputError("{}, line {}: this is to be how many lines the step has", file_.string(), lines.number());
        }
        rows = static_cast<std::size_t>(told);
      } else if (line.starts_with("ITEM: BOX BOUNDS")) {
        read_box(line, lines, table);
      } else if (line.starts_with("ITEM: TIMESTEP")) {
        break;
      } else if (line.starts_with("ITEM: ")) {
        whole = true;
        std::vector<std::string> names = names_in(line.substr(6), ' ');
        if (!names.empty()) names.erase(names.begin());  // ENTRIES, BONDS, ATOMS
        set_columns(names, lines.number(), table);
        const std::size_t found = add_rows(lines, rows, ' ', table);
        if (found < rows) {
          problems_.add(lines.number(), fmt::format("the step is to have {}, and has {}: the file is cut off",
                                                    how_many(rows, "line"), found));
        } else if (lines.next(line) && !trimmed(line).empty() && !line.starts_with("ITEM:")) {
          problems_.add(lines.number(), fmt::format("the step is to have {}, and goes on", how_many(rows, "line")));
        }
        break;
      }
    }
    if (!whole) problems_.add(lines.number(), "the step ends before the names of its columns: the file is cut off");
    return finished(std::move(table), even_empty);
  }

  NumberTable plain(std::string_view text) {
    NumberTable table;
    Lines lines(text);
    char separator = 0;
    std::vector<std::string_view> comments;  // before the numbers; one may hold the names
    for (std::string_view line; lines.next(line);) {
      line = trimmed(line);
      if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);
      if (line.empty() || line.starts_with('#') || line.starts_with('%')) {
        if (separator == 0 && !line.empty()) comments.push_back(trimmed(line.substr(1)));
        continue;
      }
      const std::string_view whole = line;
      const std::size_t remark = std::min(line.find(" #"), line.find("\t#"));
      line = trimmed(line.substr(0, remark));
      if (separator == 0) {
        separator = separator_of(line);
        bool numbers = true;
        for_each_cell(line, separator,
                      [&](std::string_view cell) { numbers = numbers && !std::isnan(number_in(cell, separator)); });
        std::vector<std::string> names;
        if (!numbers) {
          // A name may have a #: behind the last name no other one follows.
          if (whole.find_first_of(",;", remark) != std::string_view::npos) separator = separator_of(line = whole);
          names = names_in(line, separator);
        }
        for (; numbers && names.empty() && !comments.empty(); comments.erase(comments.begin())) {
          names = names_in(comments.front(), separator_of(comments.front()));
          if (names.size() != names_in(line, separator).size()) names.clear();  // a remark
        }
        table.named = !names.empty();
        if (names.empty()) names.resize(names_in(line, separator).size());
        set_columns(names, lines.number(), table);
        const auto rows = static_cast<std::size_t>(std::ranges::count(text, '\n')) + 1;
        const std::string_view below = text.substr(text.size() - lines.left());
        if (!numbers && rows >= worth_threads && below.find('#') == below.npos && below.find('%') == below.npos) {
          Reader quick(file_, names_);
          NumberTable tried = table;
          Lines rest = lines;
          quick.add_rows(rest, rows, separator, tried);
          // What is wrong is found out line by line.
          if (rest.left() == 0 && quick.problems_.none()) return finished(std::move(tried));
        }
        table.numbers.reserve(rows * table.columns.size());
        table.lines.reserve(rows);
        if (!numbers) continue;
      }
      const std::size_t before = table.numbers.size(), width = table.columns.size();
      table.numbers.resize(before + width);
      if (read_row(line, separator, lines.number(), {table.numbers.data() + before, width}, problems_))
        table.lines.push_back(lines.number());
      else
        table.numbers.resize(before);
    }
    return finished(std::move(table));
  }

 private:
  void read_box(std::string_view header, Lines& lines, NumberTable& table) const {
    std::vector<std::string> flags = names_in(header.substr(16), ' ');
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::string_view line;
      if (!lines.next(line)) return;
      std::vector<double> bounds;
      for_each_cell(line, ' ', [&](std::string_view cell) { bounds.push_back(number_in(cell)); });
      if (bounds.size() > 2 && bounds[2] != 0) {
        throw InputError("{}, line {}: the box is tilted, which is not understood; unwrap the contacts", file_.string(),
                         lines.number());
      }
      // Of a tilted form three names of tilts come before the flags.
      if (axis > 1 || flags.size() < 3 || flags[flags.size() - 3 + axis] != "pp") continue;
      if (bounds.size() < 2 || !(bounds[1] > bounds[0])) {
        throw InputError("{}, line {}: these are to be the lower and the upper bound of a periodic box", file_.string(),
                         lines.number());
      }
      table.periods[axis] = bounds[1] - bounds[0];
    }
  }

  void set_columns(const std::vector<std::string>& found, std::size_t line, NumberTable& table) const {
    const std::vector<std::string>& given = names_.given;
    table.columns = found;
    const auto usual = std::ranges::find(names_.usual, found.size(), &std::vector<std::string>::size);
    if (!table.named && given.empty() && usual != names_.usual.end()) {
      table.columns = *usual;
      table.usual = true;
    }
    if (given.empty() || renames(given)) return;
    if (given.size() != found.size()) {
      throw InputError("{}, line {}: {} columns, and {} names are given: {}", file_.string(), line, found.size(),
                       given.size(), fmt::join(given, ","));
    }
    table.columns = given;
  }

  /// The rows that follow, `rows` of them if the step has so many, each put in its place by one of several threads.
  /// Returns how many there are.
  std::size_t add_rows(Lines& lines, std::size_t rows, char separator, NumberTable& table) {
    const std::size_t width = table.columns.size();
    const std::size_t each = rows < worth_threads ? rows : rows / static_cast<std::size_t>(worker_count(0)) + 1;
    std::vector<std::pair<Lines, std::size_t>> pieces;  // where each begins, and its first row
    std::size_t found = 0;
    std::string_view line;
    for (Lines next = lines; found < rows && next.next(line) && !line.starts_with("ITEM:"); ++found) {
      if (found % each == 0) pieces.emplace_back(lines, found);
      lines = next;
    }
    table.numbers.resize(found * width);
    table.lines.resize(found);
    std::vector<std::future<LineProblems>> read;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      read.push_back(std::async([&, p, end = p + 1 < pieces.size() ? pieces[p + 1].second : found] {
        LineProblems problems(file_);
        auto [own, row] = pieces[p];
        for (std::string_view text; row < end && own.next(text); ++row) {
          read_row(text, separator, own.number(), {table.numbers.data() + row * width, width}, problems);
          table.lines[row] = own.number();
        }
        return problems;
      }));
    }
    for (std::future<LineProblems>& one : read) problems_.add(one.get());
    return found;
  }

  /// Whether the line is a row of the table: otherwise it is added to the problems.
  static bool read_row(std::string_view line, char separator, std::size_t number, std::span<double> row,
                       LineProblems& problems) {
    if (number % 65536 == 0) throw_if_interrupted();
    std::size_t cells = 0;
    for_each_cell(line, separator, [&](std::string_view cell) {
      if (cells++ < row.size()) row[cells - 1] = number_in(cell, separator);
    });
    const bool minus = line.find("\u2212") != std::string_view::npos;
    const bool with_points = separator == ' ' || line.find('.') != std::string_view::npos;
    if (minus || (separator != ',' && with_points && line.find(',') != std::string_view::npos)) {
      problems.add(number, minus ? "the sign U+2212 in a number: write - for minus"
                                 : "a comma in a number: write a point for its decimals");
      return false;
    }
    if (cells != row.size()) {
      problems.add(number, fmt::format("{} instead of {}", how_many(cells, "cell"), row.size()));
      return false;
    }
    return true;
  }

  NumberTable finished(NumberTable table, bool even_empty = false) const {
    problems_.raise();
    if (table.lines.empty() && !even_empty) {
      throw InputError("{}: there is no line of numbers in {}", file_.string(),
                       table.step ? fmt::format("step {:g}; --step takes another", *table.step) : "it");
    }
    return table;
  }

  const std::filesystem::path& file_;
  const ColumnNames& names_;
  LineProblems problems_;
};

}  // namespace

void LineProblems::add(std::size_t line, std::string_view what) {
  if (++count_ <= told_problems) told_.push_back(fmt::format("{}, {} {}: {}", file_.string(), row_name_, line, what));
}

void LineProblems::add(const LineProblems& later) {
  for (const std::string& one : later.told_) {
    if (told_.size() < told_problems) told_.push_back(one);
  }
  count_ += later.count_;
}

void LineProblems::raise() const {
  if (count_ == 0) return;
  std::vector<std::string> told = told_;
  if (count_ > told_problems) {
    told.push_back(fmt::format("{}: {} more {}s of these kinds", file_.string(), count_ - told_problems, row_name_));
  }
  throw InputError(std::move(told));
}

NumberFile::NumberFile(std::filesystem::path file, ColumnNames names, TableOf part)
    : file_(std::move(file)),
      names_(std::move(names)),
      text_(read_file(file_, static_cast<std::uint64_t>(usable_memory() / memory_of_text))) {
  if (text_.starts_with("ITEM:")) {
    Lines lines(text_);
    for (std::string_view line; lines.next(line);) {
      if (line.starts_with("ITEM: NUMBER OF ") && !steps_.empty() && lines.next(line)) {
        steps_.back().empty = number_in(trimmed(line)) == 0;
      }
      if (!line.starts_with("ITEM: TIMESTEP") || !lines.next(line)) continue;
      const double step = number_in(trimmed(line));
      if (step != step)
        throw InputError("{}, line {}: this is to be the number of a step", file_.string(), lines.number());
      steps_.push_back({step, text_.size() - lines.left(), lines.number()});
    }
    if (!steps_.empty()) return;
    throw InputError("{}: it begins as a dump of LAMMPS and has no ITEM: TIMESTEP with a number", file_.string());
  }
  if (text_.starts_with("\x89HDF")) {
    throw InputError(
        "{}: it is HDF5; `granuscope export` writes the contacts of a pile as a table, and "
        "`granuscope audit` looks at one",
        file_.string());
  }
  NumberTable table;
  if (is_vtk(text_)) {
    if (is_open_already(file_)) throw InputError("{}: VTK is read twice; write it into a file", file_.string());
    if (!names_.given.empty() && !renames(names_.given)) {
      throw InputError("{}: arrays of VTK have names; give NAME=ARRAY for those to be read under another",
                       file_.string());
    }
    table = read_vtk_table(file_, text_, part);
  } else if (text_.substr(0, 4096).find("<graphml") != std::string::npos) {
    throw InputError("{}: it is GraphML, of which contacts are not read; export the pile as csv, vtu or dump-local",
                     file_.string());
  } else if (text_.find('\0') != std::string::npos) {
    const bool wide = text_.starts_with("\xff\xfe") || text_.starts_with("\xfe\xff");
    throw InputError(
        "{}: it is {}; give a table (of a spreadsheet: saved as CSV), a dump of LAMMPS or LIGGGHTS as text, or vtu or "
        "vtk",
        file_.string(), wide ? "in UTF-16, not in UTF-8" : "no text");
  } else {
    table = Reader(file_, names_).plain(text_);
  }
  rename(file_, names_.given, table);
  table_ = std::make_shared<const NumberTable>(std::move(table));
  text_.clear();
  text_.shrink_to_fit();
}

NumberTable NumberFile::dump(std::optional<double> wanted, bool even_empty) const {
  const auto found =
      std::find_if(steps_.rbegin(), steps_.rend(), [&](const Step& one) { return !wanted || one.step == *wanted; });
  if (found == steps_.rend()) {
    std::string told;
    for (std::size_t k = 0; k < std::min(steps_.size(), told_problems); ++k)
      told += fmt::format(" {:g}", steps_[k].step);
    throw InputError("{}: there is no step {:g} among its {}:{}{}; give one of them", file_.string(), *wanted,
                     steps_.size(), told, steps_.size() > told_problems ? " ..." : "");
  }
  NumberTable table;
  table.step = found->step;
  table.steps = steps_.size();
  table = Reader(file_, names_)
              .dump(Lines(std::string_view(text_).substr(found->at), found->line), std::move(table), even_empty);
  rename(file_, names_.given, table);
  return table;
}

std::shared_ptr<const NumberTable> NumberFile::read(std::optional<double> step, bool even_empty) const {
  return table_ != nullptr ? table_ : std::make_shared<const NumberTable>(dump(step, even_empty));
}

std::vector<double> NumberFile::steps() const {
  std::vector<double> steps;
  for (const Step& one : steps_) {
    if (!one.empty) steps.push_back(one.step);
  }
  return steps;
}

}  // namespace granuscope
