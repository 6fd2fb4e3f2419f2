#include "storage/hdf5_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <stdexcept>
#include <utility>

#include "support/error.h"

namespace granuscope {
namespace {

/// More attributes or links than any file has.
constexpr unsigned many = 1000;

/// Creation lists without times: the same content must give the same bytes whenever it is written. Attributes stay in
/// the object's header, which is covered by a checksum; from 9 on the library would move them to a heap, which is not.
Hdf5Handle creation_list(Hdf5Id list_class) {
  Hdf5Handle list(H5Pcreate(list_class), H5Pclose);
  if (H5Pset_obj_track_times(list.get(), false) < 0 || H5Pset_attr_phase_change(list.get(), many, 0) < 0) {
    return {-1, H5Pclose};
  }
  return list;
}

/// The same for the links of a group or of the file itself.
Hdf5Handle group_creation_list(Hdf5Id list_class) {
  Hdf5Handle list = creation_list(list_class);
  if (H5Pset_link_phase_change(list.get(), many, 0) < 0) return {-1, H5Pclose};
  return list;
}

/// An access list for the format of HDF5 1.8: read by everything since 2008, with checksums on all metadata.
Hdf5Handle access_list(SparseImage* image) {
  Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  if (set_sparse_driver(access.get(), image) < 0 ||
      H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_V18) < 0) {
    return {-1, H5Pclose};
  }
  return access;
}

/// Fixed-length UTF-8, zero-padded. The library knows no length 0.
Hdf5Handle text_type(std::size_t length) {
  Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  if (H5Tset_size(type.get(), std::max<std::size_t>(length, 1)) < 0 || H5Tset_cset(type.get(), H5T_CSET_UTF8) < 0 ||
      H5Tset_strpad(type.get(), H5T_STR_NULLPAD) < 0) {
    return {-1, H5Tclose};
  }
  return type;
}

}  // namespace

Hdf5Writer::Hdf5Writer(std::filesystem::path target)
    : target_(std::move(target)),
      session_(std::in_place),
      composed_(std::make_unique<SparseImage>()),
      file_(-1, H5Fclose) {
  const Hdf5Handle creation = group_creation_list(H5P_FILE_CREATE);
  const Hdf5Handle access = access_list(composed_.get());
  // The name is never used: there is no such file.
  file_ = {H5Fcreate("in memory", H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose};
  check(file_.get());
}

void Hdf5Writer::fail(int error_number) const {
  throw EnvironmentError("cannot write '{}': {}", target_.string(), system_reason(error_number));
}

Hdf5Id Hdf5Writer::check(Hdf5Id status) const {
  if (status < 0) {
    const std::string reason = hdf5_reason();
    throw EnvironmentError(
        "cannot write '{}': the HDF5 library cannot compose it ({}). Free some memory and try again.", target_.string(),
        reason.empty() ? "no reason given" : reason);
  }
  return status;
}

void Hdf5Writer::group(const std::string& path) {
  const Hdf5Handle creation = group_creation_list(H5P_GROUP_CREATE);
  const Hdf5Handle made(H5Gcreate2(file_.get(), path.c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Gclose);
  check(made.get());
}

void Hdf5Writer::array(const std::string& path, const std::vector<std::uint64_t>& shape, Hdf5Id stored,
                       Hdf5Id in_memory, const void* values, std::size_t count) {
  std::uint64_t expected = 1;
  for (const std::uint64_t length : shape) expected *= length;
  if (expected != count) {
    throw std::logic_error(fmt::format("dataset {} holds {} values, its shape {}", path, count, expected));
  }
  const std::vector<hsize_t> lengths(shape.begin(), shape.end());
  const Hdf5Handle space(H5Screate_simple(static_cast<int>(lengths.size()), lengths.data(), nullptr), H5Sclose);
  check(space.get());
  const Hdf5Handle creation = creation_list(H5P_DATASET_CREATE);
  if (values == nullptr && count > 0) {
    check(H5Pset_alloc_time(creation.get(), H5D_ALLOC_TIME_EARLY));
    check(H5Pset_fill_time(creation.get(), H5D_FILL_TIME_NEVER));
  }
  const Hdf5Handle made(
      H5Dcreate2(file_.get(), path.c_str(), stored, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Dclose);
  check(made.get());
  if (count == 0) return;
  if (values == nullptr) {
    const haddr_t offset = H5Dget_offset(made.get());
    if (offset == HADDR_UNDEF) throw std::logic_error(fmt::format("dataset {} has no place yet", path));
    reserved_[path] = {offset, count};
  } else {
    check(H5Dwrite(made.get(), in_memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
  }
}

void Hdf5Writer::reserve(const std::string& path, const std::vector<std::uint64_t>& shape) {
  std::size_t count = 1;
  for (const std::uint64_t length : shape) count *= length;
  array(path, shape, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, nullptr, count);
}

void Hdf5Writer::dataset(const std::string& path, const std::vector<std::uint64_t>& shape,
                         std::span<const double> values) {
  array(path, shape, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data(), values.size());
}

void Hdf5Writer::dataset(const std::string& path, const std::vector<std::uint64_t>& shape,
                         std::span<const std::uint64_t> values) {
  array(path, shape, H5T_STD_U64LE, H5T_NATIVE_UINT64, values.data(), values.size());
}

void Hdf5Writer::dataset(const std::string& path, const std::vector<std::uint64_t>& shape,
                         std::span<const int> values) {
  array(path, shape, H5T_STD_I32LE, H5T_NATIVE_INT, values.data(), values.size());
}

void Hdf5Writer::dataset(const std::string& path, const std::vector<std::string>& values) {
  std::size_t length = 1;
  for (const std::string& value : values) length = std::max(length, value.size());
  std::string padded;
  for (const std::string& value : values) padded.append(value).append(length - value.size(), '\0');
  const Hdf5Handle type = text_type(length);
  check(type.get());
  array(path, {values.size()}, type.get(), type.get(), padded.data(), values.size());
}

void Hdf5Writer::scalar(const std::string& path, const std::string& name, Hdf5Id stored, Hdf5Id in_memory,
                        const void* value) {
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle made(H5Acreate_by_name(file_.get(), path.c_str(), name.c_str(), stored, space.get(), H5P_DEFAULT,
                                          H5P_DEFAULT, H5P_DEFAULT),
                        H5Aclose);
  check(made.get());
  check(H5Awrite(made.get(), in_memory, value));
}

void Hdf5Writer::attribute(const std::string& path, const std::string& name, double value) {
  scalar(path, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void Hdf5Writer::attribute(const std::string& path, const std::string& name, std::uint64_t value) {
  scalar(path, name, H5T_STD_U64LE, H5T_NATIVE_UINT64, &value);
}

void Hdf5Writer::attribute(const std::string& path, const std::string& name, std::string_view value) {
  const Hdf5Handle type = text_type(value.size());
  check(type.get());
  const std::string terminated(value);  // one byte is read even of an empty text
  scalar(path, name, type.get(), type.get(), terminated.c_str());
}

void Hdf5Writer::write_at(std::uint64_t offset, const void* data, std::size_t bytes) {
  const auto* from = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t written = ::pwrite(file_on_disk_.get(), from, bytes, static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(written == 0 ? EIO : errno);  // a full disk shows as a short count first
    from += written;
    offset += static_cast<std::uint64_t>(written);
    bytes -= static_cast<std::size_t>(written);
  }
}

void Hdf5Writer::end_composing() {
  if (const herr_t status = H5Fclose(file_.release()); status < 0) {
    (void)composed_.release();  // the library may still hold it and try again when the program ends
    check(status);
  }
  session_.reset();
}

void Hdf5Writer::begin_data() {
  end_composing();
  output_.emplace(target_);
  file_on_disk_ = FileDescriptor(::open(output_->temporary_path().c_str(), O_WRONLY | O_CLOEXEC));
  if (!file_on_disk_.valid() || ::ftruncate(file_on_disk_.get(), static_cast<off_t>(composed_->size())) != 0) {
    fail(errno);
  }
  composed_->for_each_page(
      [this](std::uint64_t at, std::span<const char> bytes) { write_at(at, bytes.data(), bytes.size()); });
  composed_.reset();
}

void Hdf5Writer::begin_shared_data(const std::filesystem::path& file) {
  end_composing();
  shared_ = file;
  file_on_disk_ = FileDescriptor(::open(file.c_str(), O_WRONLY | O_CLOEXEC));
  if (!file_on_disk_.valid() || ::ftruncate(file_on_disk_.get(), static_cast<off_t>(composed_->size())) != 0) {
    fail(errno);
  }
}

void Hdf5Writer::sync() const {
  if (::fdatasync(file_on_disk_.get()) != 0 && errno != EINTR) fail(errno);
}

std::map<std::string, std::uint64_t> Hdf5Writer::places() const {
  std::map<std::string, std::uint64_t> found;
  for (const auto& [path, room] : reserved_) found[path] = room.offset;
  return found;
}

/// Pages that hold the end or the beginning of reserved room must not overwrite what others have put there.
void Hdf5Writer::write_beside_data(std::uint64_t at, std::span<const char> bytes) {
  std::map<std::uint64_t, std::uint64_t> data;  // where they begin and end
  for (const auto& [path, room] : reserved_) data[room.offset] = room.offset + room.count * sizeof(double);
  const std::uint64_t end = at + bytes.size();
  std::uint64_t from = at;
  for (const auto& [first, last] : data) {
    if (last <= from || first >= end) continue;
    if (first > from) write_at(from, &bytes[from - at], first - from);
    from = last;
  }
  if (from < end) write_at(from, &bytes[from - at], end - from);
}

void Hdf5Writer::put(const std::string& path, std::size_t first, std::span<const double> values) {
  static_assert(std::endian::native == std::endian::little, "raw data are written as they are in memory");
  if (values.empty()) return;
  const Reserved& room = reserved_.at(path);
  if (first + values.size() > room.count) throw std::logic_error(fmt::format("dataset {} has less room", path));
  write_at(room.offset + first * sizeof(double), values.data(), values.size_bytes());
}

void Hdf5Writer::commit() {
  if (!shared_.empty()) {
    composed_->for_each_page([this](std::uint64_t at, std::span<const char> bytes) { write_beside_data(at, bytes); });
    rename_whole(shared_, target_);
    return;
  }
  if (!output_) begin_data();
  output_->commit();
}

}  // namespace granuscope
