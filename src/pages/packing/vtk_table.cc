#include "packing/vtk_table.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

using Doubles = std::vector<double>;
constexpr double most_unpacked = 2e9;  // bytes of a file

struct VtkArray {
  std::string name;
  std::size_t components = 1;
  Doubles numbers;
};

struct VtkGrid {
  Doubles points;                                  ///< three a point
  std::map<std::string, Doubles> ends, points_of;  ///< by kind of cells: where each ends among their points, and these
  std::vector<VtkArray> of_points, of_cells;
};

/// Kinds of cells whose arrays come before those of all others, in the order of their data.
constexpr std::array<const char*, 3> kinds_of_cells{"cells", "verts", "lines"};

template <class Number>
void append_numbers(std::string_view bytes, bool swapped, Doubles& to) {
  for (std::size_t at = 0; at + sizeof(Number) <= bytes.size(); at += sizeof(Number)) {
    std::array<char, sizeof(Number)> one{};
    std::memcpy(one.data(), bytes.data() + at, sizeof(Number));
    if (swapped) std::ranges::reverse(one);
    to.push_back(static_cast<double>(std::bit_cast<Number>(one)));
  }
}

struct NumberKind {
  const char *xml, *legacy;
  std::size_t size;
  void (*append)(std::string_view, bool, Doubles&);
};
constexpr std::array<NumberKind, 11> number_kinds{{{"Float64", "double", 8, append_numbers<double>},
                                                   {"Float32", "float", 4, append_numbers<float>},
                                                   {"Int64", "vtktypeint64", 8, append_numbers<std::int64_t>},
                                                   {"Int32", "int", 4, append_numbers<std::int32_t>},
                                                   {"Int16", "short", 2, append_numbers<std::int16_t>},
                                                   {"Int8", "char", 1, append_numbers<std::int8_t>},
                                                   {"UInt64", "unsigned_long", 8, append_numbers<std::uint64_t>},
                                                   {"UInt32", "unsigned_int", 4, append_numbers<std::uint32_t>},
                                                   {"UInt16", "unsigned_short", 2, append_numbers<std::uint16_t>},
                                                   {"UInt8", "unsigned_char", 1, append_numbers<std::uint8_t>},
                                                   {"", "long", 8, append_numbers<std::int64_t>}}};

/// What both grammars share: where the text has been read to, and how a file is refused.
class VtkReader {
 public:
  VtkReader(const std::filesystem::path& file, std::string_view text) : file_(file), text_(text) {}

 protected:
  [[noreturn]] void refuse(const std::string& what) const {
    throw InputError(
        fmt::format("{}: {}; save the contacts as lines of two points, with arrays of cells, as .vtu, "
                    ".vtp or .vtk",
                    file_.string(), what));
  }
  [[noreturn]] void refuse_cut(std::string_view name) const {
    throw InputError(
        fmt::format("{}: the array {} has fewer numbers than it is to have: the file is cut off or damaged",
                    file_.string(), single_line(std::string(name))));
  }
  static bool is_blank(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }
  std::string_view word() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    const std::size_t from = at_;
    while (at_ < text_.size() && !is_blank(text_[at_]) && text_[at_] != '<') ++at_;
    return text_.substr(from, at_ - from);
  }
  std::size_t count(std::string_view written) const {
    std::size_t number = 0;
    // Nothing has more items than the file has bits.
    if (!read_whole(written, number) || number / 8 > text_.size()) {
      refuse(fmt::format("'{}' stands where a count is to be", single_line(std::string(written.substr(0, 20)))));
    }
    return number;
  }
  /// Numbers in plain text, as long as there are any.
  Doubles words(std::size_t most) {
    Doubles numbers;
    while (numbers.size() < most) {
      const std::size_t before = at_;
      const std::string_view one = word();
      double number = 0;
      if (one.empty() || !read_whole(one, number)) {
        at_ = before;
        break;
      }
      numbers.push_back(number);
    }
    return numbers;
  }

  const std::filesystem::path& file_;
  std::string_view text_;
  std::size_t at_ = 0;
};

/// Bytes of a text in base64, or as they are; stretches that are padded by themselves may follow each other.
class VtkBytes {
 public:
  VtkBytes(std::string_view text, bool coded) : text_(text), coded_(coded) {}

  /// Fewer where there are no more.
  std::string take(std::size_t bytes) {
    std::string taken = std::exchange(rest_, {});
    if (!coded_) {
      taken = text_.substr(0, bytes);
      text_.remove_prefix(taken.size());
      return taken;
    }
    while (taken.size() < bytes) {
      std::uint32_t bits = 0;
      std::size_t letters = 0, pads = 0;
      while (letters < 4 && !text_.empty()) {
        const int value = values[static_cast<unsigned char>(text_.front())];
        if (value == not_base64) break;
        text_.remove_prefix(1);
        if (value == blank) continue;
        pads += value == padding ? 1 : 0;
        bits = bits << 6U | static_cast<std::uint32_t>(value == padding ? 0 : value);
        ++letters;
      }
      if (letters < 4 || pads > 2) break;
      for (std::size_t k = 0; k < 3 - pads; ++k) taken += static_cast<char>(bits >> (16U - 8U * k) & 0xFFU);
    }
    if (taken.size() > bytes) {
      rest_ = taken.substr(bytes);
      taken.resize(bytes);
    }
    return taken;
  }

 private:
  static constexpr int padding = -1, blank = -2, not_base64 = -3;
  static constexpr std::array<int, 256> values = [] {
    std::array<int, 256> all{};
    all.fill(not_base64);
    constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (std::size_t k = 0; k < letters.size(); ++k) {
      all[static_cast<unsigned char>(letters[k])] = static_cast<int>(k);
    }
    all['='] = padding;
    for (const char c : {' ', '\n', '\t', '\r'}) all[static_cast<unsigned char>(c)] = blank;
    return all;
  }();

  std::string_view text_;
  bool coded_;
  std::string rest_;
};

class XmlReader : VtkReader {
 public:
  XmlReader(const std::filesystem::path& file, std::string_view text, TableOf part)
      : VtkReader(file, text), part_(part) {}

  VtkGrid read() {
    if (const std::size_t appended = text_.find("<AppendedData"); appended != std::string_view::npos) {
      const std::size_t begin = text_.find('_', text_.find('>', appended));
      if (begin == std::string_view::npos) refuse("there is no data behind <AppendedData>: the file is cut off");
      appended_ = text_.substr(begin + 1);
      appended_coded_ = attribute(text_.substr(appended, begin - appended), "encoding") == "base64";
      text_ = text_.substr(0, appended);
    }
    std::string section;
    std::size_t pieces = 0;
    while ((at_ = text_.find('<', at_)) != std::string_view::npos) {
      if (text_.substr(at_).starts_with("<!--")) {
        at_ = std::min(text_.find("-->", at_), text_.size());
        continue;
      }
      const std::size_t end = text_.find('>', at_);
      if (end == std::string_view::npos) break;
      const std::string_view tag = text_.substr(at_ + 1, end - at_ - 1);
      const std::string name = plain_name(tag.substr(0, tag.find_first_of(" \t\r\n/", 1)));
      at_ = end + 1;
      if (name == "vtkfile") {
        open(tag);
      } else if (name == "piece") {
        pieces += attribute(tag, "NumberOfPoints") == "0" ? 0 : 1;
        if (pieces > 1) refuse("it has several pieces, which are not put together here");
      } else if (name == "dataarray") {
        take(section, tag);
      } else if (name == "points" || name == "pointdata" || name == "celldata" || is_kind_of_cells(name)) {
        section = name;
      } else if (name == "/" + section) {
        section.clear();
      }
    }
    return std::move(grid_);
  }

 private:
  static bool is_kind_of_cells(const std::string& name) {
    return std::ranges::find(kinds_of_cells, name) != kinds_of_cells.end();
  }
  static std::string attribute(std::string_view tag, const std::string& name) {
    const std::size_t at = tag.find(" " + name + "=\"");
    if (at == std::string_view::npos) return "";
    const std::size_t from = at + name.size() + 3;
    return std::string(tag.substr(from, tag.find('"', from) - from));
  }

  void open(std::string_view tag) {
    const std::string type = attribute(tag, "type"), compressor = attribute(tag, "compressor");
    if (type != "UnstructuredGrid" && type != "PolyData") {
      refuse(fmt::format("it is {} of VTK, which has no contacts", single_line(type)));
    }
    if (!compressor.empty() && compressor != "vtkZLibDataCompressor") {
      refuse(fmt::format("it is compressed by {}, not by zlib", single_line(compressor)));
    }
    compressed_ = !compressor.empty();
    swapped_ = attribute(tag, "byte_order") == "BigEndian";
    size_of_count_ = attribute(tag, "header_type") == "UInt64" ? 8 : 4;
  }

  std::size_t count_in(VtkBytes& bytes, const std::string& name) const {
    Doubles number;
    const std::string told = bytes.take(size_of_count_);
    size_of_count_ == 8 ? append_numbers<std::uint64_t>(told, swapped_, number)
                        : append_numbers<std::uint32_t>(told, swapped_, number);
    // zlib makes at most about a thousand bytes of one.
    const double most = 1100.0 * static_cast<double>(text_.size() + appended_.size());
    if (number.empty() || number[0] > most) refuse_cut(name);
    return static_cast<std::size_t>(number[0]);
  }

  std::string unpacked(VtkBytes bytes, const std::string& name) {
    std::string all;
    if (!compressed_) {
      const std::size_t size = count_in(bytes, name);
      all = bytes.take(size);
      if (all.size() < size) refuse_cut(name);
      return all;
    }
    const std::size_t blocks = count_in(bytes, name);
    if (blocks > text_.size() + appended_.size()) refuse_cut(name);
    std::vector<std::size_t> sizes(blocks);
    const std::size_t whole = count_in(bytes, name), last = count_in(bytes, name);
    for (std::size_t& size : sizes) size = count_in(bytes, name);
    unpacked_ += static_cast<double>(whole) * static_cast<double>(sizes.size());
    if (unpacked_ > most_unpacked) refuse("its arrays are larger than 2 GB when they are unpacked");
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      const std::string packed = bytes.take(sizes[k]);
      std::string block(k + 1 == sizes.size() && last > 0 ? last : whole, '\0');
      uLongf size = block.size();
      if (packed.size() < sizes[k] ||
          uncompress(reinterpret_cast<Bytef*>(block.data()), &size, reinterpret_cast<const Bytef*>(packed.data()),
                     packed.size()) != Z_OK ||
          size != block.size()) {
        refuse_cut(name);
      }
      all += block;
    }
    return all;
  }

  void take(const std::string& section, std::string_view tag) {
    VtkArray array;
    array.name = plain_name(attribute(tag, "Name"));
    if (const std::string components = attribute(tag, "NumberOfComponents"); !components.empty()) {
      array.components = std::max<std::size_t>(count(components), 1);
    }
    if (section.empty() || (is_kind_of_cells(section) && array.name == "types")) return;
    if (part_ == TableOf::particles ? section != "points" && section != "pointdata" : section == "pointdata") return;
    const std::string format = attribute(tag, "format"), type = attribute(tag, "type");
    const auto kind = std::ranges::find_if(number_kinds, [&](const NumberKind& one) { return type == one.xml; });
    if (kind == number_kinds.end()) return;  // texts
    if (format == "ascii") {
      array.numbers = words(static_cast<std::size_t>(-1));
    } else {
      const bool appended = format == "appended";
      const std::size_t offset = appended ? count(attribute(tag, "offset")) : 0;
      if (offset > appended_.size()) refuse_cut(array.name);
      kind->append(
          unpacked(appended ? VtkBytes(appended_.substr(offset), appended_coded_) : VtkBytes(text_.substr(at_), true),
                   array.name),
          swapped_, array.numbers);
    }
    if (section == "points") {
      grid_.points = std::move(array.numbers);
    } else if (is_kind_of_cells(section)) {
      (array.name == "offsets" ? grid_.ends : grid_.points_of)[section] = std::move(array.numbers);
    } else {
      (section == "pointdata" ? grid_.of_points : grid_.of_cells).push_back(std::move(array));
    }
  }

  TableOf part_;
  VtkGrid grid_;
  std::string_view appended_;
  bool appended_coded_ = false, compressed_ = false, swapped_ = false;
  double unpacked_ = 0;  // bytes of all arrays so far
  std::size_t size_of_count_ = 4;
};

class LegacyReader : VtkReader {
 public:
  using VtkReader::VtkReader;

  VtkGrid read() {
    line();
    line();  // a title
    binary_ = word() == "BINARY";
    VtkGrid grid;
    std::vector<VtkArray>* arrays = nullptr;
    std::size_t items = 0;
    for (std::string key = next_word(); !key.empty(); key = next_word()) {
      if (key == "points") {
        const std::size_t points = count(word());
        grid.points = numbers(key, next_word(), 3 * points);
      } else if (key == "cells" || key == "lines" || key == "vertices" || key == "polygons" ||
                 key == "triangle_strips") {
        take_cells(key == "vertices" ? "verts" : key, grid);
      } else if (key == "cell_types") {
        (void)numbers(key, "int", count(word()));
      } else if (key == "point_data" || key == "cell_data") {
        arrays = key == "point_data" ? &grid.of_points : &grid.of_cells;
        items = count(word());
      } else if (key == "field") {
        (void)word();
        for (std::size_t left = count(word()); left > 0; --left) {
          std::string name = next_word();
          for (; name == "metadata"; name = next_word()) skip_metadata();
          VtkArray array{name, count(word()), {}};
          const std::size_t tuples = count(word());
          array.numbers = numbers(array.name, next_word(), array.components * tuples);
          if (arrays != nullptr) arrays->push_back(std::move(array));
        }
      } else if (key == "scalars" || key == "vectors" || key == "normals" || key == "tensors") {
        if (arrays == nullptr) refuse(key + " stands before POINT_DATA or CELL_DATA");
        VtkArray array{next_word(), key == "scalars" ? std::size_t{1} : key == "tensors" ? 9U : 3U, {}};
        const std::string type = next_word();
        if (key == "scalars") {
          if (const std::string_view more = line(); !more.empty()) array.components = count(more);
          if (text_.substr(at_).starts_with("LOOKUP_TABLE")) line();
          --at_;  // the end of the line belongs to the numbers
        }
        array.numbers = numbers(array.name, type, array.components * items);
        arrays->push_back(std::move(array));
      } else if (key == "metadata") {
        skip_metadata();
      } else if (key == "lookup_table") {
        (void)word();
        (void)numbers(key, binary_ ? "unsigned_char" : "float", 4 * count(word()));
      } else if (key != "dataset" && key != "unstructured_grid" && key != "polydata") {
        refuse(fmt::format("'{}' is not known in a file of contacts", single_line(key.substr(0, 30))));
      }
    }
    return grid;
  }

 private:
  std::string next_word() { return plain_name(word()); }
  /// The rest of it, without blanks around.
  std::string_view line() {
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    std::string_view rest = text_.substr(std::min(at_, end), end - std::min(at_, end));
    at_ = std::min(end + 1, text_.size());
    while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
    while (!rest.empty() && is_blank(rest.back())) rest.remove_suffix(1);
    return rest;
  }

  /// It ends with an empty line.
  void skip_metadata() {
    for ((void)line(); !line().empty();) continue;
  }

  Doubles numbers(std::string_view name, const std::string& type, std::size_t wanted) {
    Doubles found;
    const std::string plain = type == "vtkidtype" ? "int" : type;
    const auto kind = std::ranges::find_if(number_kinds, [&](const NumberKind& one) { return plain == one.legacy; });
    if (kind == number_kinds.end()) refuse(fmt::format("{} is no type of numbers", single_line(type)));
    if (binary_) {
      at_ = std::min(text_.find('\n', at_), text_.size() - 1) + 1;
      const std::string_view bytes = text_.substr(at_, kind->size * wanted);
      kind->append(bytes, true, found);
      at_ += bytes.size();
    } else {
      found = words(wanted);
    }
    if (found.size() < wanted) refuse_cut(name);
    return found;
  }

  /// [points of a cell, those, points of the next ...], or from version 5 on offsets and points in two arrays.
  void take_cells(const std::string& kind, VtkGrid& grid) {
    const std::size_t cells = count(word()), size = count(word()), before = at_;
    Doubles &ends = grid.ends[kind], &points = grid.points_of[kind];
    if (next_word() == "offsets") {
      ends = numbers("offsets", next_word(), cells);
      if (!ends.empty()) ends.erase(ends.begin());
      (void)word();  // CONNECTIVITY
      points = numbers("connectivity", next_word(), size);
      return;
    }
    at_ = before;
    const Doubles all = numbers(kind, "int", size);
    for (std::size_t from = 0; from < all.size();) {
      const std::size_t to = from + 1 + static_cast<std::size_t>(std::max(all[from], 0.0));
      if (to > all.size()) refuse_cut(kind);
      points.insert(points.end(), all.begin() + static_cast<std::ptrdiff_t>(from) + 1,
                    all.begin() + static_cast<std::ptrdiff_t>(to));
      ends.push_back(static_cast<double>(points.size()));
      from = to;
    }
  }

  bool binary_ = false;
};

/// Makes rows of points or cells out of their arrays.
class Rows {
 public:
  Rows(const std::filesystem::path& file, const std::vector<VtkArray>& arrays, std::size_t items, NumberTable& table)
      : table_(table) {
    for (const VtkArray& array : arrays) {
      if (array.numbers.size() < array.components * items) {
        throw InputError(fmt::format("{}: the array {} has {} numbers for {} {}s: the file is cut off or damaged",
                                     file.string(), array.name, array.numbers.size(), items, table.row_name));
      }
      const bool vector = array.components == 2 || array.components == 3;
      if (!vector && array.components != 1) continue;
      for (std::size_t k = 0; k < (vector ? 2 : 1); ++k) {
        table.columns.push_back(array.name + (vector ? k == 0 ? "_x" : "_y" : ""));
        taken_.emplace_back(&array, k);
      }
    }
  }
  void add(std::size_t item, std::initializer_list<double> first) {
    table_.numbers.insert(table_.numbers.end(), first);
    for (const auto& [array, component] : taken_) {
      table_.numbers.push_back(array->numbers[item * array->components + component]);
    }
    table_.lines.push_back(item);
  }

 private:
  NumberTable& table_;
  std::vector<std::pair<const VtkArray*, std::size_t>> taken_;
};

}  // namespace

bool is_vtk(std::string_view text) {
  return text.starts_with("# vtk DataFile") || text.substr(0, 1000).find("<VTKFile") != std::string_view::npos;
}

NumberTable read_vtk_table(const std::filesystem::path& file, std::string_view text, TableOf part) {
  const VtkGrid grid =
      text.starts_with("# vtk DataFile") ? LegacyReader(file, text).read() : XmlReader(file, text, part).read();
  const Doubles& at = grid.points;
  const std::size_t points = at.size() / 3;
  if (std::ranges::any_of(at, [](double one) { return std::isnan(one); })) {
    throw InputError(fmt::format("{}: a point is no number", file.string()));
  }
  // Packings that stand upright lie in the plane of x and z.
  bool even_y = true, even_z = true;
  for (std::size_t k = 0; k < points; ++k) {
    even_y = even_y && at[3 * k + 1] == at[1];
    even_z = even_z && at[3 * k + 2] == at[2];
  }
  const std::size_t axis = even_y && !even_z ? 2 : 1;
  NumberTable table;
  table.named = true;
  if (part == TableOf::particles) {
    table.row_name = "point";
    table.columns = {"point", "x", "y"};
    Rows rows(file, grid.of_points, points, table);
    const auto radius = std::ranges::find(grid.of_points, "radius", &VtkArray::name);
    for (std::size_t k = 0; k < points; ++k) {
      if (radius != grid.of_points.end() && radius->numbers[k] == 0) continue;
      rows.add(k, {static_cast<double>(k), at[3 * k], at[3 * k + axis]});
    }
    return table;
  }
  table.row_name = "cell";
  table.columns = {"x1", "y1", "x2", "y2", "point1", "point2"};
  std::size_t cells = 0;
  for (const char* kind : kinds_of_cells) {
    if (const auto found = grid.ends.find(kind); found != grid.ends.end()) cells += found->second.size();
  }
  Rows rows(file, grid.of_cells, cells, table);
  // The points at one place, by the first of them.
  std::vector<std::size_t> order(points);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto place = [&](std::size_t k) { return std::tuple(at[3 * k], at[3 * k + axis]); };
  std::ranges::sort(order, {}, [&](std::size_t k) { return std::tuple_cat(place(k), std::tuple(k)); });
  Doubles first_at(points);
  for (std::size_t k = 0; k < points; ++k) {
    const bool same = k > 0 && place(order[k]) == place(order[k - 1]);
    first_at[order[k]] = same ? first_at[order[k - 1]] : static_cast<double>(order[k]);
  }
  std::size_t cell = 0;
  for (const char* kind : kinds_of_cells) {
    if (!grid.ends.contains(kind) || !grid.points_of.contains(kind)) continue;
    const Doubles& of = grid.points_of.at(kind);
    double from = 0;
    for (const double to : grid.ends.at(kind)) {
      const std::size_t here = cell++;
      if (!(to >= from && to <= static_cast<double>(of.size()))) {
        throw InputError(fmt::format("{}: cell {} has points that are not there", file.string(), here));
      }
      const auto first = static_cast<std::size_t>(from);
      const bool line = to - from == 2;
      from = to;
      if (!line) continue;
      std::array<std::size_t, 2> ends{};
      for (const std::size_t k : {0, 1}) {
        if (!(of[first + k] >= 0 && of[first + k] < static_cast<double>(points))) {
          throw InputError(fmt::format("{}: cell {} has a point {} of {}", file.string(), here, of[first + k], points));
        }
        ends[k] = static_cast<std::size_t>(of[first + k]);
      }
      rows.add(here, {at[3 * ends[0]], at[3 * ends[0] + axis], at[3 * ends[1]], at[3 * ends[1] + axis],
                      first_at[ends[0]], first_at[ends[1]]});
    }
  }
  if (table.lines.empty()) {
    throw InputError(fmt::format("{}: it has no line of two points, and so no contact", file.string()));
  }
  return table;
}

}  // namespace granuscope
