#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/files.h"

namespace granuscope {
/// A file of VTK's XML formats whose arrays stand in base64 where they are declared ("binary"), a form that all readers
/// have: meshio reads raw bytes behind the text no more since Python 3.13. Arrays can be filled piece by piece in any
/// order and take no memory. What is written is the format of VTK 1.0 with 64-bit lengths, little-endian.
class VtkFile {
 public:
  /// `type`: "UnstructuredGrid", "ImageData".
  VtkFile(std::filesystem::path target, std::string type) : file_(std::move(target)), type_(std::move(type)) {}

  /// An array of `items` tuples of `components` numbers: its element, for the text. `kind`: "Float64", "Int64" or
  /// "UInt8". Its place is known by the order of the calls, from 0 on.
  std::string array(const std::string& name, const std::string& kind, std::size_t components, std::uint64_t items);

  /// Once all arrays are known: `comment` and what stands inside the element of the type.
  void begin(std::string_view comment, std::string_view inside);

  /// Numbers of an array from tuple `first` on, each tuple to be put once.
  template <class Number>
  void put(std::size_t array, std::uint64_t first, std::span<const Number> numbers) {
    put_bytes(array, first, numbers.data(), numbers.size_bytes());
  }

  void commit() { file_.commit(); }

 private:
  struct Room {
    std::uint64_t place = 0;                     ///< in the file
    std::uint64_t bytes = 0, bytes_of_item = 0;  ///< without the length, which stands before
  };
  /// Three bytes that make four letters, between two pieces.
  struct Triple {
    std::string bytes = std::string(3, '\0');
    std::size_t known = 0;
  };

  void put_bytes(std::size_t array, std::uint64_t first, const void* numbers, std::size_t bytes);
  void encode(std::size_t array, std::uint64_t from, std::string_view bytes);

  StreamedFile file_;
  std::string type_;
  std::vector<Room> rooms_;
  std::map<std::pair<std::size_t, std::uint64_t>, Triple> begun_;  ///< by array and place
};

}  // namespace granuscope
