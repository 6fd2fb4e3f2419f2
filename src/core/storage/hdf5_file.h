#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
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

  static auto fields(auto& raw) { return std::tie(raw.dataset, raw.shape, raw.offset, raw.values); }
};

/// From here on a sum of squares may be infinite: no force, nor a sum of some, is so large.
inline constexpr double beyond_sums = 0x1p500;

/// "'/V_R' at [12, 3] is nan, of which no sum is a number", or nothing if all are below `beyond_sums`. `values` begin
/// at number `first` of the dataset of the given shape.
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
