#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "support/files.h"

namespace granuscope {
/// HDF5's hid_t. Spelled out so that only the .cc files of this room include the library's headers.
using Hdf5Id = std::int64_t;

/// Owns one HDF5 identifier and closes it with the function it came with. A negative identifier is none.
class Hdf5Handle {
 public:
  using Close = int (*)(Hdf5Id);

  Hdf5Handle(Hdf5Id id, Close close) : id_(id), close_(close) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }

  Hdf5Id get() const { return id_; }
  bool valid() const { return id_ >= 0; }
  /// Gives the identifier up, for a close whose status matters.
  Hdf5Id release() { return std::exchange(id_, -1); }

 private:
  Hdf5Id id_;
  Close close_;
};

/// The right to call HDF5, which Debian builds without thread safety: one thread at a time holds it. Also silences the
/// library, which prints its errors by itself unless told otherwise. Not recursive: hold one at a time.
class Hdf5Session {
 public:
  Hdf5Session();

 private:
  std::unique_lock<std::mutex> lock_;
};

/// The innermost complaint of the last failed call, "" if there is none.
std::string hdf5_reason();

/// The numbers of a dataset: where they stand in the file or, if they stand there in another form (compressed, other
/// byte order), the numbers themselves.
struct RawData {
  std::string dataset;                  ///< for messages
  std::vector<std::uint64_t> shape;     ///< row-major
  std::optional<std::uint64_t> offset;  ///< of the first one in the file, each 8 bytes of this machine's doubles
  std::vector<double> values;           ///< all of them, if there is no offset
};

/// "'/V_R' at [12, 3] is nan, not a finite number", or nothing if all are finite. `values` begin at number `first` of
/// the dataset of the given shape.
std::optional<std::string> find_not_finite(const std::string& dataset, const std::vector<std::uint64_t>& shape,
                                           std::size_t first, std::span<const double> values);

/// A file whose plain numbers are read where they stand, without the HDF5 library. All errors are InputError naming the
/// file, the dataset and, for a number that is not finite, its place.
class RawDataFile {
 public:
  /// `kind` is what the file should be, with its article ("a pile file"), for messages.
  RawDataFile(std::filesystem::path source, std::string kind);

  /// Numbers `first` to `first + target.size() - 1` in row-major order; all are finite.
  void read(const RawData& numbers, std::size_t first, std::span<double> target) const;

 private:
  [[noreturn]] void fail(const std::string& reason) const;

  std::filesystem::path source_;
  std::string kind_;
  FileDescriptor file_;
};

/// The bytes of a file that is being composed. Only pages that were written take memory: what is reserved and filled
/// later, on disk, takes none. Bytes never written are zero.
class SparseImage {
 public:
  void write(std::uint64_t at, const void* bytes, std::size_t size);
  void read(std::uint64_t at, void* bytes, std::size_t size) const;
  std::uint64_t size() const { return size_; }
  void resize(std::uint64_t size) { size_ = size; }
  /// Each page that was written, in order, without what lies beyond the end.
  void for_each_page(const std::function<void(std::uint64_t at, std::span<const char> bytes)>& visit) const;

 private:
  std::map<std::uint64_t, std::vector<char>> pages_;  ///< by number
  std::uint64_t size_ = 0;
};

/// Makes HDF5 keep the file opened with this access list in `image`, which must outlive it. (The library's own driver
/// for files in memory fills everything that is reserved with zeros.) Negative if that fails.
int set_sparse_driver(Hdf5Id access_list, SparseImage* image);

/// How long a file may take to read before it counts as damaged. Both grow with the file's size.
struct ReadPatience {
  double processor_seconds = 5;  ///< what a library in an endless loop uses up
  double wall_seconds = 120;     ///< for a disk or network that does not answer
};

/// Runs `read` in a child process and returns the bytes that it returns. The HDF5 library crashes on some damaged files
/// and never comes to an end on others; here only the child does, and this throws InputError saying so. Errors that
/// `read` throws are passed on with their kind and message. `kind` is what the file should be, with its article ("a
/// pile file"), for messages. Throws EnvironmentError if there can be no child, Interrupted if a stop is requested
/// meanwhile.
std::string read_in_child(const std::filesystem::path& source, const std::string& kind,
                          const std::function<std::string()>& read, ReadPatience patience = {});

}  // namespace granuscope
