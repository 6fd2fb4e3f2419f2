#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "storage/hdf5_file.h"
#include "support/files.h"

namespace granuscope {

/// An HDF5 file in the making. The library composes it in memory that holds nothing but what was written; it
/// reaches the disk by our own writes in commit(): the library's writing leaves a half-open file behind when the disk
/// is full, and does not say why. Same calls, same bytes: nothing of the moment (times, addresses) is recorded.
/// Metadata carry checksums; data do not, so that whoever needs to notice damage there stores a digest beside them.
///
/// Paths are absolute inside the file ("/weight/sum"); groups must be made before what they hold. All errors are
/// EnvironmentError naming the file. Holds the Hdf5Session until begin_data() or commit().
class Hdf5Writer {
 public:
  explicit Hdf5Writer(std::filesystem::path target);

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

  /// Room for float64 numbers of this shape, which are put there piece by piece and never all in memory.
  void reserve(const std::string& path, const std::vector<std::uint64_t>& shape);
  /// Ends the composing: from here on only put() and commit() may be called.
  void begin_data();
  /// The same with the data in a file that is there, into which other processes that compose the same put theirs; all
  /// but the data is written in commit().
  void begin_shared_data(const std::filesystem::path& file);
  /// What was put is on disk when this returns.
  void sync() const;
  /// Where the reserved datasets begin in the file.
  std::map<std::string, std::uint64_t> places() const;
  /// Numbers `first` and following of a reserved dataset, each to be put once.
  void put(const std::string& path, std::size_t first, std::span<const double> values);

  /// The file appears, whole or not at all. The last call.
  void commit();

 private:
  struct Reserved {
    std::uint64_t offset = 0;
    std::size_t count = 0;
  };

  /// `values` null: room is reserved instead.
  void array(const std::string& path, const std::vector<std::uint64_t>& shape, Hdf5Id stored, Hdf5Id in_memory,
             const void* values, std::size_t count);
  void scalar(const std::string& path, const std::string& name, Hdf5Id stored, Hdf5Id in_memory, const void* value);
  Hdf5Id check(Hdf5Id status) const;
  [[noreturn]] void fail(int error_number) const;
  void end_composing();
  void write_at(std::uint64_t offset, const void* data, std::size_t bytes);
  void write_beside_data(std::uint64_t at, std::span<const char> bytes);

  std::filesystem::path target_;
  std::optional<Hdf5Session> session_;
  std::unique_ptr<SparseImage> composed_;  // before file_, which writes to it until it is closed
  Hdf5Handle file_;
  std::map<std::string, Reserved> reserved_;
  std::optional<AtomicFile> output_;  // from begin_data() on
  std::filesystem::path shared_;      // or from begin_shared_data() on
  FileDescriptor file_on_disk_;
};

}  // namespace granuscope
