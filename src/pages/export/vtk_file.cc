#include "export/vtk_file.h"

#include <fmt/format.h>

#include <bit>
#include <stdexcept>
#include <string>

#include "support/plain_text.h"

namespace granuscope {
static_assert(std::endian::native == std::endian::little, "numbers are written as they are in memory");

std::string VtkFile::array(const std::string& name, const std::string& kind, std::size_t components,
                           std::uint64_t items) {
  Room room;
  room.offset = data_bytes_;
  room.bytes_of_item = components * (kind == "UInt8" ? 1 : 8);
  room.bytes = room.bytes_of_item * items;
  data_bytes_ += sizeof room.bytes + room.bytes;
  rooms_.push_back(room);
  // Of one number an item no count is written, as VTK does: readers give a plain array then.
  const std::string tuple = components > 1 ? fmt::format(" NumberOfComponents=\"{}\"", components) : "";
  return fmt::format("<DataArray type=\"{}\" Name=\"{}\"{} format=\"appended\" offset=\"{}\"/>\n", kind, name, tuple,
                     room.offset);
}

void VtkFile::begin(std::string_view comment, std::string_view inside) {
  const std::string head = fmt::format(
      "<?xml version=\"1.0\"?>\n{}\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n{}<AppendedData encoding=\"raw\">\n_",
      xml_comment(comment), type_, inside);
  file_.put(0, head);
  data_begin_ = head.size();
  for (const Room& room : rooms_) {
    file_.put(data_begin_ + room.offset, {reinterpret_cast<const char*>(&room.bytes), sizeof room.bytes});
  }
  file_.put(data_begin_ + data_bytes_, "\n</AppendedData>\n</VTKFile>\n");
}

void VtkFile::put_bytes(std::size_t array, std::uint64_t first, const void* numbers, std::size_t bytes) {
  const Room& room = rooms_.at(array);
  const std::uint64_t from = first * room.bytes_of_item;
  if (from + bytes > room.bytes || bytes % room.bytes_of_item != 0) {
    throw std::logic_error(fmt::format("array {} of a VTK file has less room", array));
  }
  file_.put(data_begin_ + room.offset + sizeof room.bytes + from, {static_cast<const char*>(numbers), bytes});
}

}  // namespace granuscope
