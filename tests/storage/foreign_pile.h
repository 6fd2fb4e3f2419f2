#pragma once
// Piles as other programs write them.
#include <hdf5.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "storage/hdf5_file.h"

namespace granuscope::test {

inline constexpr hsize_t foreign_layers = 3;
inline constexpr hsize_t foreign_columns = 4;

/// An HDF5 file made with the plain library.
class ForeignFile {
 public:
  explicit ForeignFile(const std::filesystem::path& file)
      : file_(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose) {
    REQUIRE(file_.valid());
  }
  explicit ForeignFile(const std::filesystem::path& file, unsigned mode)
      : file_(H5Fopen(file.c_str(), mode, H5P_DEFAULT), H5Fclose) {
    REQUIRE(file_.valid());
  }

  hid_t id() const { return file_.get(); }

  /// Numbers 0, 1, 2, ... of the given type and creation list.
  void dataset(const char* path, const std::vector<hsize_t>& shape, hid_t type, hid_t creation = H5P_DEFAULT) {
    const Hdf5Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
    const Hdf5Handle made(H5Dcreate2(id(), path, type, space.get(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose);
    REQUIRE(made.valid());
    std::vector<double> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get())));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i);
    REQUIRE(H5Dwrite(made.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
  }
  template <class Value>
  void attribute(const char* name, hid_t stored, hid_t in_memory, const Value* value, hsize_t length = 0) {
    const Hdf5Handle space(length == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &length, nullptr), H5Sclose);
    const Hdf5Handle made(H5Acreate2(id(), name, stored, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    REQUIRE(made.valid());
    REQUIRE(H5Awrite(made.get(), in_memory, value) >= 0);
  }
  void remove(const char* path) { REQUIRE(H5Ldelete(id(), path, H5P_DEFAULT) >= 0); }
  void remove_attribute(const char* name) { REQUIRE(H5Adelete(id(), name) >= 0); }

 private:
  Hdf5Handle file_;
};

/// A pile as a script in Python would write it: signed integers, texts of variable length, no word about the format.
inline void write_as_a_script(const std::filesystem::path& path, hid_t type = H5T_IEEE_F64LE,
                              hid_t creation = H5P_DEFAULT) {
  const Hdf5Session session;
  ForeignFile file(path);
  for (const char* name : {"/V_R", "/V_L", "/H_R", "/H_L"})
    file.dataset(name, {foreign_layers, foreign_columns}, type, creation);
  file.dataset("/load", {foreign_columns}, H5T_IEEE_F64LE);
  const double mu = 0.25;
  file.attribute("mu", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &mu);
  const std::int64_t seed = 5, sample = 6;
  file.attribute("seed", H5T_STD_I64LE, H5T_NATIVE_INT64, &seed);
  file.attribute("sample", H5T_STD_I64LE, H5T_NATIVE_INT64, &sample);
  const Hdf5Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(text.get(), H5T_VARIABLE);
  H5Tset_cset(text.get(), H5T_CSET_UTF8);
  const char* law = "granusolve";
  file.attribute("law", text.get(), text.get(), &law);
}

/// Chunks of one layer each, compressed.
inline Hdf5Handle compressed() {
  Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  const hsize_t chunk[] = {1, foreign_columns};
  H5Pset_chunk(creation.get(), 2, chunk);
  H5Pset_deflate(creation.get(), 9);
  return creation;
}

}  // namespace granuscope::test
