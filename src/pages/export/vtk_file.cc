#include "export/vtk_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <stdexcept>

#include "support/plain_text.h"

namespace granuscope {
static_assert(std::endian::native == std::endian::little, "numbers are written as they are in memory");

namespace {

/// Where an array is to stand; no text has it.
constexpr char mark = '\1';
constexpr std::uint64_t triple = 3, letters = 4;

}  // namespace

std::string VtkFile::array(const std::string& name, const std::string& kind, std::size_t components,
                           std::uint64_t items) {
  Room room;
  room.bytes_of_item = components * (kind == "UInt8" ? 1 : 8);
  room.bytes = room.bytes_of_item * items;
  rooms_.push_back(room);
  // Of one number an item no count is written, as VTK does: readers give a plain array then.
  const std::string tuple = components > 1 ? fmt::format(" NumberOfComponents=\"{}\"", components) : "";
  return fmt::format("<DataArray type=\"{}\" Name=\"{}\"{} format=\"binary\">\n{}\n</DataArray>\n", kind, name, tuple,
                     mark);
}

void VtkFile::begin(std::string_view comment, std::string_view inside) {
  const std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n{}\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n{}</VTKFile>\n",
      xml_comment(comment), type_, inside);
  std::uint64_t place = 0;
  std::size_t from = 0;
  for (std::size_t array = 0; array <= rooms_.size(); ++array) {
    const std::size_t to = std::min(text.find(mark, from), text.size());
    file_.put(place, std::string_view(text).substr(from, to - from));
    place += to - from;
    from = to + 1;
    if (array == rooms_.size()) break;
    Room& room = rooms_[array];
    room.place = place;
    encode(array, 0, {reinterpret_cast<const char*>(&room.bytes), sizeof room.bytes});
    place += (sizeof room.bytes + room.bytes + triple - 1) / triple * letters;
  }
}

void VtkFile::put_bytes(std::size_t array, std::uint64_t first, const void* numbers, std::size_t bytes) {
  const Room& room = rooms_.at(array);
  const std::uint64_t from = first * room.bytes_of_item;
  if (from + bytes > room.bytes || bytes % room.bytes_of_item != 0) {
    throw std::logic_error(fmt::format("array {} of a VTK file has less room", array));
  }
  encode(array, sizeof room.bytes + from, {static_cast<const char*>(numbers), bytes});
}

/// `bytes`, which begin at `from`, the length of the array being at 0. What is less than three of them waits for the
/// piece that has the others.
void VtkFile::encode(std::size_t array, std::uint64_t from, std::string_view bytes) {
  const Room& room = rooms_[array];
  const std::uint64_t end = sizeof room.bytes + room.bytes;
  while (!bytes.empty()) {
    const std::uint64_t number = from / triple, place = room.place + number * letters;
    const std::size_t whole = from % triple == 0 ? bytes.size() / triple * triple : 0;
    std::size_t used = whole;
    if (whole > 0) {
      file_.put(place, base64(bytes.substr(0, whole)));
    } else {
      const std::uint64_t inside = from % triple, size = std::min(triple, end - number * triple);
      used = std::min<std::size_t>(bytes.size(), size - inside);
      Triple& begun = begun_[{array, number}];
      begun.bytes.replace(inside, used, bytes.substr(0, used));
      begun.known += used;
      if (begun.known == size) {
        file_.put(place, base64(std::string_view(begun.bytes).substr(0, size)));
        begun_.erase({array, number});
      }
    }
    bytes.remove_prefix(used);
    from += used;
  }
}

}  // namespace granuscope
