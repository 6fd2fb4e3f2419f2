#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "storage/hdf5_file.h"

namespace granuscope {

using Shape = std::vector<std::uint64_t>;

/// "[200, 500]".
std::string describe_shape(const Shape& shape);

/// An HDF5 file open for reading that trusts nothing it reads: shapes, types and sizes are checked before memory is
/// taken, and every floating-point number is finite. All errors are InputError naming the file and what is wrong in it.
/// Paths are absolute inside the file. Holds the Hdf5Session while it lives. The library itself trusts the file, and
/// may crash on a damaged one or never come to an end: use it inside read_in_child.
class Hdf5Reader {
 public:
  /// `kind` is what the file should be, with its article ("a pile file"), for messages.
  Hdf5Reader(std::filesystem::path source, std::string kind);

  bool has_dataset(const std::string& path) const;
  bool has_attribute(const std::string& path, const std::string& name) const;
  /// Names of the groups directly in the file, in alphabetical order.
  std::vector<std::string> groups() const;

  Shape shape(const std::string& dataset) const;
  /// The whole array, row-major, which must have the given shape.
  std::vector<double> numbers(const std::string& dataset, const Shape& expected) const;
  /// Where the numbers stand, without reading them, if they stand there plainly; otherwise the numbers.
  RawData raw_data(const std::string& dataset, const Shape& expected) const;
  std::vector<std::uint64_t> counts(const std::string& dataset, const Shape& expected) const;
  std::vector<int> integers(const std::string& dataset, const Shape& expected) const;
  std::vector<std::string> texts(const std::string& dataset, const Shape& expected) const;

  /// Scalar attributes of the group or dataset at `path`.
  double number(const std::string& path, const std::string& name) const;
  std::uint64_t count(const std::string& path, const std::string& name) const;
  std::string text(const std::string& path, const std::string& name) const;

  /// Throws InputError "cannot read '<file>': <reason>".
  [[noreturn]] void fail(const std::string& reason) const;

 private:
  struct OpenDataset;
  void require_unlocked() const;
  OpenDataset open_dataset(const std::string& path, const Shape& expected) const;
  Hdf5Handle open_attribute(const std::string& path, const std::string& name) const;
  void read(const OpenDataset& dataset, Hdf5Id in_memory, void* values) const;
  [[noreturn]] void fail_with_library_reason(const std::string& what) const;
  std::uint64_t size_on_disk() const;

  std::filesystem::path source_;
  std::string kind_;
  std::uint64_t file_bytes_ = 0;
  Hdf5Session session_;
  Hdf5Handle file_;
};

}  // namespace granuscope
