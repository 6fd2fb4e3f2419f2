#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "storage/hdf5_handle.h"

namespace granuscope {

/// An HDF5 file in the making. It is built in memory and reaches the disk in one piece in commit(): the library's own
/// writing leaves a half-open file behind when the disk is full, and does not say why. Same calls, same bytes: nothing
/// of the moment (times, addresses) is recorded. Metadata carry checksums; data do not, so that whoever needs to notice
/// damage there stores a digest beside them.
///
/// Paths are absolute inside the file ("/weight/sum"); groups must be made before what they hold. All errors are
/// EnvironmentError naming the file. Holds the Hdf5Session while it lives.
class Hdf5Writer {
 public:
  /// `data_bytes`: the expected size of all datasets together, so that the memory is taken once.
  Hdf5Writer(std::filesystem::path target, std::size_t data_bytes);

  void group(const std::string& path);

  /// Row-major arrays; the shape's product must be the number of values.
  void dataset(const std::string& path, const std::vector<std::uint64_t>& shape, std::span<const double> values);
  void dataset(const std::string& path, const std::vector<std::uint64_t>& shape, std::span<const std::uint64_t> values);
  void dataset(const std::string& path, const std::vector<std::uint64_t>& shape, std::span<const int> values);
  /// Fixed-length UTF-8, as long as the longest.
  void dataset(const std::string& path, const std::vector<std::string>& values);

  /// Scalar attributes of the group or dataset at `path` ("/" is the file itself).
  void attribute(const std::string& path, const std::string& name, double value);
  void attribute(const std::string& path, const std::string& name, std::uint64_t value);
  void attribute(const std::string& path, const std::string& name, std::string_view value);

  /// Writes the file, whole or not at all. The last call.
  void commit();

  /// The memory that HDF5 composes the file in.
  struct Image {
    Image() = default;
    Image(const Image&) = delete;
    Image& operator=(const Image&) = delete;
    ~Image();
    void* bytes = nullptr;
    std::size_t capacity = 0;
  };

 private:
  void array(const std::string& path, const std::vector<std::uint64_t>& shape, Hdf5Id stored, Hdf5Id in_memory,
             const void* values, std::size_t count);
  void scalar(const std::string& path, const std::string& name, Hdf5Id stored, Hdf5Id in_memory, const void* value);
  Hdf5Id check(Hdf5Id status) const;

  std::filesystem::path target_;
  Hdf5Session session_;
  std::unique_ptr<Image> image_;  // before file_, which writes to it until it is closed
  Hdf5Handle file_;
};

}  // namespace granuscope
