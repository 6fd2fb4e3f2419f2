#include "storage/hdf5_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "support/error.h"
#include "support/files.h"

namespace granuscope {
namespace {

/// No pile or ensemble is larger; a number above it comes from a damaged file.
constexpr std::uint64_t max_dataset_bytes = std::uint64_t{64} << 30;
/// Deflate, the densest filter in use, makes at most 1032 bytes of one.
constexpr std::uint64_t max_compression = 1032;
constexpr std::size_t max_text_bytes = std::size_t{16} << 20;
constexpr int max_rank = 3;

constexpr const char* make_again = "Make the file again or name another one.";

/// Drops the zero padding of a fixed-length text.
std::string unpadded(const char* text, std::size_t length) {
  while (length > 0 && text[length - 1] == '\0') --length;
  return std::string(text, length);
}

}  // namespace

std::string describe_shape(const Shape& shape) { return fmt::format("[{}]", fmt::join(shape, ", ")); }

/// A dataset whose type class and size have been looked at.
struct Hdf5Reader::OpenDataset {
  std::string path;
  Hdf5Handle handle;
  Hdf5Handle type;
  std::size_t values = 0;
};

Hdf5Reader::Hdf5Reader(std::filesystem::path source, std::string kind)
    : source_(std::move(source)), kind_(std::move(kind)), file_(-1, H5Fclose) {
  struct stat status = {};
  if (::stat(source_.c_str(), &status) != 0) fail(system_reason(errno));
  if (S_ISDIR(status.st_mode)) {
    const std::filesystem::path piles = source_ / "piles";
    fail(system_reason(EISDIR) + (folder_exists(piles) ? " Piles of a run lie in " + piles.string() + "." : ""));
  }
  if (!S_ISREG(status.st_mode)) fail(fmt::format("it is not an ordinary file. Name {}.", kind_));
  if (status.st_size == 0) fail(fmt::format("it is empty. {}", make_again));
  file_bytes_ = static_cast<std::uint64_t>(status.st_size);
  if (FILE* readable = std::fopen(source_.c_str(), "re")) {
    std::fclose(readable);
  } else {
    fail(system_reason(errno));
  }

  require_unlocked();
  if (H5Fis_hdf5(source_.c_str()) <= 0) {
    fail(fmt::format("it is not an HDF5 file. Name {}; contact forces of other programs are for `granuscope contacts`.",
                     kind_));
  }
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // Files appear whole, by rename, so there is nothing to lock out; and some network folders know no locks.
  H5Pset_file_locking(access.get(), false, true);
  file_ = {H5Fopen(source_.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose};
  if (!file_.valid()) fail_with_library_reason("it is damaged or cut short");
}

/// HDF5_USE_FILE_LOCKING=TRUE overrules what the access list below says; the library then takes a lock that it cannot
/// have for damage.
void Hdf5Reader::require_unlocked() const {
  const char* asked = std::getenv("HDF5_USE_FILE_LOCKING");
  if (asked == nullptr || *asked == '\0' ||
      std::string_view("TRUE 1 BEST_EFFORT").find(asked) == std::string_view::npos)
    return;
  const FileDescriptor file(::open(source_.c_str(), O_RDONLY | O_CLOEXEC));
  if (!lock_file(file, true)) {
    throw EnvironmentError(
        "cannot read '{}': another program has it locked, and HDF5_USE_FILE_LOCKING asks to heed that; wait for its "
        "end, or set HDF5_USE_FILE_LOCKING=FALSE",
        source_.string());
  }
}

void Hdf5Reader::fail(const std::string& reason) const {
  throw InputError("cannot read '{}' as {}: {}", source_.string(), kind_, reason);
}

void Hdf5Reader::fail_with_library_reason(const std::string& what) const {
  const std::string reason = hdf5_reason();
  fail(fmt::format("{}{}. {}", what, reason.empty() ? "" : fmt::format(" (HDF5: {})", reason), make_again));
}

bool Hdf5Reader::has_dataset(const std::string& path) const {
  // Each part of the path must be there, as a plain link: others lead to other files.
  for (std::size_t slash = path.find('/', 1);; slash = path.find('/', slash + 1)) {
    const std::string part = path.substr(0, slash);
    H5L_info_t link = {};
    if (H5Lexists(file_.get(), part.c_str(), H5P_DEFAULT) <= 0 ||
        H5Lget_info(file_.get(), part.c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD) {
      return false;
    }
    if (slash == std::string::npos) break;
  }
  const Hdf5Handle object(H5Oopen(file_.get(), path.c_str(), H5P_DEFAULT), H5Oclose);
  return object.valid() && H5Iget_type(object.get()) == H5I_DATASET;
}

bool Hdf5Reader::has_attribute(const std::string& path, const std::string& name) const {
  const htri_t found = H5Aexists_by_name(file_.get(), path.c_str(), name.c_str(), H5P_DEFAULT);
  if (found < 0) fail_with_library_reason(fmt::format("its attributes of '{}' are damaged", path));
  return found > 0;
}

std::vector<std::string> Hdf5Reader::groups() const {
  std::vector<std::string> names;
  const auto take_name = [](hid_t group, const char* name, const H5L_info_t* link, void* list) -> herr_t {
    if (link->type != H5L_TYPE_HARD) return 0;
    const Hdf5Handle object(H5Oopen(group, name, H5P_DEFAULT), H5Oclose);
    if (!object.valid()) return -1;
    if (H5Iget_type(object.get()) == H5I_GROUP) static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  hsize_t next = 0;
  if (H5Literate(file_.get(), H5_INDEX_NAME, H5_ITER_INC, &next, take_name, &names) < 0) {
    fail_with_library_reason("its list of contents is damaged");
  }
  return names;
}

Shape Hdf5Reader::shape(const std::string& dataset) const {
  if (!has_dataset(dataset)) {
    fail(fmt::format("it has no dataset '{}', so another program wrote it or it is damaged. Name {}.", dataset, kind_));
  }
  const Hdf5Handle opened(H5Dopen2(file_.get(), dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (!opened.valid()) fail_with_library_reason(fmt::format("its dataset '{}' is damaged", dataset));
  const Hdf5Handle space(H5Dget_space(opened.get()), H5Sclose);
  const int rank = space.valid() ? H5Sget_simple_extent_ndims(space.get()) : -1;
  if (rank < 1 || rank > max_rank || H5Sget_simple_extent_type(space.get()) != H5S_SIMPLE) {
    fail(fmt::format("its dataset '{}' is not an array of 1 to {} dimensions. {}", dataset, max_rank, make_again));
  }
  std::vector<hsize_t> lengths(static_cast<std::size_t>(rank));
  if (H5Sget_simple_extent_dims(space.get(), lengths.data(), nullptr) != rank) {
    fail_with_library_reason(fmt::format("the shape of its dataset '{}' is damaged", dataset));
  }
  return Shape(lengths.begin(), lengths.end());
}

Hdf5Reader::OpenDataset Hdf5Reader::open_dataset(const std::string& path, const Shape& expected) const {
  const Shape actual = shape(path);
  if (actual != expected) {
    fail(fmt::format("its dataset '{}' has the shape {} where {} is needed. {}", path, describe_shape(actual),
                     describe_shape(expected), make_again));
  }
  Hdf5Handle handle(H5Dopen2(file_.get(), path.c_str(), H5P_DEFAULT), H5Dclose);
  Hdf5Handle type(H5Dget_type(handle.get()), H5Tclose);
  const Hdf5Handle creation(H5Dget_create_plist(handle.get()), H5Pclose);
  if (!handle.valid() || !type.valid() || !creation.valid()) {
    fail_with_library_reason(fmt::format("its dataset '{}' is damaged", path));
  }

  const H5D_layout_t layout = H5Pget_layout(creation.get());
  if ((layout != H5D_COMPACT && layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED) ||
      H5Pget_external_count(creation.get()) > 0) {
    fail(fmt::format(
        "its dataset '{}' keeps its numbers in other files, which is not supported. Copy them into one file.", path));
  }

  // The size is a claim until the file is seen to be large enough for it.
  const std::uint64_t value_bytes = H5Tget_size(type.get());
  const std::uint64_t capacity = layout == H5D_CHUNKED && file_bytes_ < max_dataset_bytes
                                     ? std::min(max_dataset_bytes, file_bytes_ * max_compression)
                                     : std::min(max_dataset_bytes, file_bytes_);
  std::uint64_t values = 1;
  bool plausible = value_bytes > 0 && value_bytes <= capacity;
  for (const std::uint64_t length : actual) {
    plausible = plausible && (length == 0 || values <= capacity / value_bytes / length);
    if (plausible) values *= length;
  }
  if (!plausible) {
    fail(fmt::format("its dataset '{}' claims the shape {}, more than a file of {} bytes can hold. {}", path,
                     describe_shape(actual), file_bytes_, make_again));
  }
  if (layout == H5D_CONTIGUOUS && H5Dget_storage_size(handle.get()) != values * value_bytes) {
    fail(fmt::format("its dataset '{}' was never filled or is cut short. {}", path, make_again));
  }
  return {path, std::move(handle), std::move(type), static_cast<std::size_t>(values)};
}

std::uint64_t Hdf5Reader::size_on_disk() const {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(source_, error);
  return error ? 0 : size;
}

void Hdf5Reader::read(const OpenDataset& dataset, Hdf5Id in_memory, void* values) const {
  if (dataset.values == 0) return;
  if (H5Dread(dataset.handle.get(), in_memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) {
    fail_with_library_reason(fmt::format("its dataset '{}' cannot be read to its end", dataset.path));
  }
  // Past the end of a file the library delivers zeros without a word.
  if (size_on_disk() != file_bytes_) fail("it changed while it was read. Try again once it is complete.");
}

std::vector<double> Hdf5Reader::numbers(const std::string& dataset, const Shape& expected) const {
  const OpenDataset opened = open_dataset(dataset, expected);
  // Only these two: the library's conversions from other formats round, and trust what a damaged type says.
  if (H5Tequal(opened.type.get(), H5T_IEEE_F64LE) <= 0 && H5Tequal(opened.type.get(), H5T_IEEE_F64BE) <= 0) {
    fail(fmt::format("its dataset '{}' does not hold 64-bit floating-point numbers. {}", dataset, make_again));
  }
  std::vector<double> values(opened.values);
  read(opened, H5T_NATIVE_DOUBLE, values.data());
  if (const auto wrong = find_not_finite(dataset, expected, 0, values)) fail(fmt::format("{}. {}", *wrong, make_again));
  return values;
}

RawData Hdf5Reader::raw_data(const std::string& dataset, const Shape& expected) const {
  RawData stored;
  stored.dataset = dataset;
  stored.shape = expected;
  {
    const OpenDataset opened = open_dataset(dataset, expected);
    const haddr_t offset = H5Dget_offset(opened.handle.get());  // none if compact, in chunks or empty
    if (std::endian::native == std::endian::little && H5Tequal(opened.type.get(), H5T_IEEE_F64LE) > 0 &&
        offset != HADDR_UNDEF) {
      const std::uint64_t bytes = opened.values * sizeof(double);
      if (offset > file_bytes_ || bytes > file_bytes_ - offset) {
        fail(fmt::format("its dataset '{}' is cut short. {}", dataset, make_again));
      }
      stored.offset = offset;
      return stored;
    }
  }
  stored.values = numbers(dataset, expected);
  return stored;
}

std::vector<std::uint64_t> Hdf5Reader::counts(const std::string& dataset, const Shape& expected) const {
  const OpenDataset opened = open_dataset(dataset, expected);
  if (H5Tequal(opened.type.get(), H5T_STD_U64LE) <= 0 && H5Tequal(opened.type.get(), H5T_STD_U64BE) <= 0) {
    fail(fmt::format("its dataset '{}' does not hold 64-bit counts. {}", dataset, make_again));
  }
  std::vector<std::uint64_t> values(opened.values);
  read(opened, H5T_NATIVE_UINT64, values.data());
  return values;
}

std::vector<int> Hdf5Reader::integers(const std::string& dataset, const Shape& expected) const {
  const OpenDataset opened = open_dataset(dataset, expected);
  if (H5Tequal(opened.type.get(), H5T_STD_I32LE) <= 0 && H5Tequal(opened.type.get(), H5T_STD_I32BE) <= 0) {
    fail(fmt::format("its dataset '{}' does not hold 32-bit integers. {}", dataset, make_again));
  }
  std::vector<int> values(opened.values);
  read(opened, H5T_NATIVE_INT, values.data());
  return values;
}

std::vector<std::string> Hdf5Reader::texts(const std::string& dataset, const Shape& expected) const {
  const OpenDataset opened = open_dataset(dataset, expected);
  if (H5Tget_class(opened.type.get()) != H5T_STRING || H5Tis_variable_str(opened.type.get()) != 0) {
    fail(fmt::format("its dataset '{}' does not hold texts of fixed length. {}", dataset, make_again));
  }
  const std::size_t length = H5Tget_size(opened.type.get());
  std::string padded(opened.values * length, '\0');
  read(opened, opened.type.get(), padded.data());
  std::vector<std::string> values;
  for (std::size_t i = 0; i < opened.values; ++i) values.push_back(unpadded(padded.data() + i * length, length));
  return values;
}

Hdf5Handle Hdf5Reader::open_attribute(const std::string& path, const std::string& name) const {
  if (!has_attribute(path, name)) {
    fail(fmt::format("'{}' has no attribute '{}', so another program wrote the file or it is damaged. Name {}.", path,
                     name, kind_));
  }
  Hdf5Handle attribute(H5Aopen_by_name(file_.get(), path.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const Hdf5Handle space(attribute.valid() ? H5Aget_space(attribute.get()) : -1, H5Sclose);
  if (!space.valid()) fail_with_library_reason(fmt::format("its attribute '{}' is damaged", name));
  if (H5Sget_simple_extent_npoints(space.get()) != 1) {
    fail(fmt::format("its attribute '{}' is not a single value. {}", name, make_again));
  }
  return attribute;
}

double Hdf5Reader::number(const std::string& path, const std::string& name) const {
  const Hdf5Handle attribute = open_attribute(path, name);
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.get());
  double value = 0;
  if ((kind != H5T_FLOAT && kind != H5T_INTEGER) || H5Tget_size(type.get()) > sizeof value ||
      H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, &value) < 0 || !(std::abs(value) < beyond_sums)) {
    fail(fmt::format("its attribute '{}' is not a finite number, or one that no sum can hold. {}", name, make_again));
  }
  return value;
}

std::uint64_t Hdf5Reader::count(const std::string& path, const std::string& name) const {
  const Hdf5Handle attribute = open_attribute(path, name);
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose);
  bool good = H5Tget_class(type.get()) == H5T_INTEGER && H5Tget_size(type.get()) <= sizeof(std::uint64_t);
  std::uint64_t value = 0;
  if (good && H5Tget_sign(type.get()) != H5T_SGN_NONE) {
    // Other programs write small numbers as signed ones; the library would turn a negative one into 0.
    std::int64_t with_sign = 0;
    good = H5Aread(attribute.get(), H5T_NATIVE_INT64, &with_sign) >= 0 && with_sign >= 0;
    value = static_cast<std::uint64_t>(with_sign);
  } else if (good) {
    good = H5Aread(attribute.get(), H5T_NATIVE_UINT64, &value) >= 0;
  }
  if (!good) fail(fmt::format("its attribute '{}' is not a whole number from 0 on. {}", name, make_again));
  return value;
}

std::string Hdf5Reader::text(const std::string& path, const std::string& name) const {
  const Hdf5Handle attribute = open_attribute(path, name);
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose);
  if (H5Tget_class(type.get()) != H5T_STRING) {
    fail(fmt::format("its attribute '{}' is not a text. {}", name, make_again));
  }
  if (H5Tis_variable_str(type.get()) > 0) {  // what Python's h5py writes
    const Hdf5Handle in_memory(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(in_memory.get(), H5T_VARIABLE);
    H5Tset_cset(in_memory.get(), H5Tget_cset(type.get()));
    char* value = nullptr;
    if (H5Aread(attribute.get(), in_memory.get(), &value) < 0) {
      fail_with_library_reason(fmt::format("its attribute '{}' is damaged", name));
    }
    std::string result = value == nullptr ? "" : value;
    H5free_memory(value);
    return result;
  }
  const std::size_t length = H5Tget_size(type.get());
  if (length == 0 || length > max_text_bytes || length > file_bytes_) {
    fail(fmt::format("its attribute '{}' claims a length of {} bytes. {}", name, length, make_again));
  }
  std::string value(length, '\0');
  if (H5Aread(attribute.get(), type.get(), value.data()) < 0) {
    fail_with_library_reason(fmt::format("its attribute '{}' is damaged", name));
  }
  return unpadded(value.data(), value.size());
}

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
