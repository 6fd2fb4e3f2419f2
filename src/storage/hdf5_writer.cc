#include "storage/hdf5_writer.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <utility>

#include "support/atomic_file.h"
#include "support/error.h"

namespace granuscope {
namespace {

/// Room for the metadata when memory is taken for the file.
constexpr std::size_t metadata_bytes = std::size_t{1} << 16;
/// Length of the first block of every file (format specification, superblock version 2).
constexpr std::size_t superblock_bytes = 48;

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

// The library's in-memory driver asks these for memory and gives it back when the file is closed: the file is complete
// only then. (H5Fget_file_image, which can be called earlier, spoils the checksum of this format's first block.)
void* resize(void* bytes, std::size_t size, H5FD_file_image_op_t /*reason*/, void* image) {
  void* resized = std::realloc(bytes, size);
  if (resized != nullptr) {
    static_cast<Hdf5Writer::Image*>(image)->bytes = resized;
    static_cast<Hdf5Writer::Image*>(image)->capacity = size;
  }
  return resized;
}

herr_t keep(void* /*bytes*/, H5FD_file_image_op_t /*reason*/, void* /*image*/) { return 0; }

void* same(void* image) { return image; }

herr_t leave(void* /*image*/) { return 0; }

/// An access list for a file in `image`, in the format of HDF5 1.8: read by everything since 2008, with checksums on
/// all metadata.
Hdf5Handle in_memory_access(std::size_t data_bytes, Hdf5Writer::Image* image) {
  Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5FD_file_image_callbacks_t callbacks = {nullptr, nullptr, resize, keep, same, leave, image};
  if (H5Pset_fapl_core(access.get(), data_bytes + metadata_bytes, false) < 0 ||
      H5Pset_file_image_callbacks(access.get(), &callbacks) < 0 ||
      H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_V18) < 0) {
    return {-1, H5Pclose};
  }
  return access;
}

/// The end of the file as its first block tells it (superblock version 2 of the format specification): the memory
/// reaches further.
std::uint64_t end_of_file(const unsigned char* bytes) {
  constexpr int end_of_file_address = 28;
  std::uint64_t end = 0;
  for (int i = 7; i >= 0; --i) end = end << 8 | bytes[end_of_file_address + i];
  return end;
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

Hdf5Writer::Image::~Image() { std::free(bytes); }

Hdf5Writer::Hdf5Writer(std::filesystem::path target, std::size_t data_bytes)
    : target_(std::move(target)), image_(std::make_unique<Image>()), file_(-1, H5Fclose) {
  const Hdf5Handle creation = group_creation_list(H5P_FILE_CREATE);
  const Hdf5Handle access = in_memory_access(data_bytes, image_.get());
  // The name is never used: there is no such file.
  file_ = {H5Fcreate("in memory", H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose};
  check(file_.get());
}

Hdf5Id Hdf5Writer::check(Hdf5Id status) const {
  if (status < 0) {
    const std::string reason = hdf5_reason();
    throw EnvironmentError(
        fmt::format("cannot write '{}': the HDF5 library cannot compose it ({}). Free some memory and try again.",
                    target_.string(), reason.empty() ? "no reason given" : reason));
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
  const Hdf5Handle made(
      H5Dcreate2(file_.get(), path.c_str(), stored, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Dclose);
  check(made.get());
  if (count > 0) check(H5Dwrite(made.get(), in_memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
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

void Hdf5Writer::commit() {
  if (const herr_t status = H5Fclose(file_.release()); status < 0) {
    image_->bytes = nullptr;  // the library may still hold it and try again when the program ends
    check(status);
  }
  const std::uint64_t size =
      image_->capacity < superblock_bytes ? 0 : end_of_file(static_cast<const unsigned char*>(image_->bytes));
  if (size < superblock_bytes || size > image_->capacity) {
    throw std::logic_error("HDF5 composed a file without an end");
  }
  write_file(target_, {static_cast<const char*>(image_->bytes), static_cast<std::size_t>(size)});
}

}  // namespace granuscope
