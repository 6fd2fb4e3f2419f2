// Files that other programs wrote: what follows the published layout is read, whatever wrote it; the rest is refused.
#include <hdf5.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "kit/temporary_folder.h"
#include "storage/ensemble_file.h"
#include "storage/foreign_pile.h"
#include "storage/hdf5_file.h"
#include "storage/hdf5_reader.h"
#include "storage/pile_file.h"
#include "storage/record_comparison.h"
#include "storage/sample_records.h"
#include "support/files.h"

using namespace granuscope;
using namespace granuscope::test;
using Catch::Matchers::Contains;

namespace {

constexpr hsize_t layers = foreign_layers;
constexpr hsize_t columns = foreign_columns;

std::string refusal(const std::filesystem::path& file) {
  return input_error_of([&] { (void)read_pile(file); });
}

/// The refusal of a pile that `change` has been made to.
std::string refusal_after(const std::function<void(ForeignFile&)>& change) {
  const TemporaryFolder folder;
  write_as_a_script(folder / "pile.h5");
  {
    const Hdf5Session session;
    ForeignFile file(folder / "pile.h5", H5F_ACC_RDWR);
    change(file);
  }
  return refusal(folder / "pile.h5");
}

}  // namespace

TEST_CASE("a pile that a script wrote is read") {
  const TemporaryFolder folder;
  SECTION("plain") { write_as_a_script(folder / "pile.h5"); }
  SECTION("of the other byte order") { write_as_a_script(folder / "pile.h5", H5T_IEEE_F64BE); }
  SECTION("compressed") { write_as_a_script(folder / "pile.h5", H5T_IEEE_F64LE, compressed().get()); }
  const Pile pile = read_pile(folder / "pile.h5");
  CHECK(pile.lattice.layers() == layers);
  CHECK(pile.lattice.columns() == columns);
  CHECK(pile.H_R == std::vector<double>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
  CHECK(pile.load == std::vector<double>{0, 1, 2, 3});
  CHECK(pile.mu == 0.25);
  CHECK(pile.law == "granusolve");
  CHECK(pile.seed == 5);
  CHECK(pile.sample == 6);
}

TEST_CASE("piles with something missing or misshapen are refused") {
  CHECK_THAT(refusal_after([](ForeignFile& file) { file.remove("/V_L"); }),
             Contains("no dataset '/V_L'") && Contains("Name a pile file"));
  CHECK_THAT(refusal_after([](ForeignFile& file) { file.remove("/load"); }), Contains("no dataset '/load'"));
  for (const char* name : {"mu", "law", "seed", "sample"}) {
    CHECK_THAT(refusal_after([name](ForeignFile& file) { file.remove_attribute(name); }),
               Contains("no attribute '" + std::string(name) + "'"));
  }
  CHECK_THAT(refusal_after([](ForeignFile& file) {
               file.remove("/H_R");
               file.dataset("/H_R", {layers, columns + 1}, H5T_IEEE_F64LE);
             }),
             Contains("'/H_R' has the shape [3, 5] where [3, 4] is needed"));
  CHECK_THAT(refusal_after([](ForeignFile& file) {
               file.remove("/V_R");
               file.dataset("/V_R", {layers, 3}, H5T_IEEE_F64LE);
             }),
             Contains("'/V_R' has the shape [3, 3]") && Contains("4 columns"));
  CHECK_THAT(refusal_after([](ForeignFile& file) {
               file.remove("/V_R");
               file.dataset("/V_R", {layers * columns}, H5T_IEEE_F64LE);
             }),
             Contains("'/V_R' has the shape [12]"));
  CHECK_THAT(refusal_after([](ForeignFile& file) {
               file.remove("/V_R");
               file.dataset("/V_R", {1, 1, layers, columns}, H5T_IEEE_F64LE);
             }),
             Contains("'/V_R' is not an array of 1 to 3 dimensions"));
  CHECK_THAT(refusal_after([](ForeignFile& file) {
               file.remove("/load");
               H5Gclose(H5Gcreate2(file.id(), "/load", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
             }),
             Contains("no dataset '/load'"));
}

TEST_CASE("numbers of another type are refused") {
  for (const hid_t type : {H5T_IEEE_F32LE, H5T_STD_I64LE, H5T_STD_I32LE}) {
    CHECK_THAT(refusal_after([type](ForeignFile& file) {
                 file.remove("/H_L");
                 file.dataset("/H_L", {layers, columns}, type);
               }),
               Contains("'/H_L' does not hold 64-bit floating-point numbers"));
  }
}

TEST_CASE("attributes of another type are refused") {
  const auto with = [](const char* name, const auto& write) {
    return refusal_after([&](ForeignFile& file) {
      file.remove_attribute(name);
      write(file);
    });
  };
  const std::int64_t minus_one = -1;
  const double half = 0.5;
  const double two[] = {0.1, 0.2};
  CHECK_THAT(with("seed", [&](ForeignFile& f) { f.attribute("seed", H5T_STD_I64LE, H5T_NATIVE_INT64, &minus_one); }),
             Contains("'seed' is not a whole number from 0 on"));
  CHECK_THAT(with("sample", [&](ForeignFile& f) { f.attribute("sample", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &half); }),
             Contains("'sample' is not a whole number"));
  CHECK_THAT(with("mu", [&](ForeignFile& f) { f.attribute("mu", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, two, 2); }),
             Contains("'mu' is not a single value"));
  CHECK_THAT(with("mu", [&](ForeignFile& f) { f.attribute("mu", H5T_C_S1, H5T_C_S1, "x"); }),
             Contains("'mu' is not a finite number"));
  CHECK_THAT(with("law", [&](ForeignFile& f) { f.attribute("law", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &half); }),
             Contains("'law' is not a text"));
}

TEST_CASE("another version or format is named") {
  const std::uint64_t version = 2;
  CHECK_THAT(refusal_after([&](ForeignFile& file) {
               file.attribute("format_version", H5T_STD_U64LE, H5T_NATIVE_UINT64, &version);
             }),
             Contains("version 2 of the format where 1 is known"));
  CHECK_THAT(refusal_after([](ForeignFile& file) { file.attribute("format", H5T_C_S1, H5T_C_S1, "x"); }),
             Contains("it is a x file"));
}

TEST_CASE("numbers kept in other files are not followed") {
  const TemporaryFolder folder;
  write_as_a_script(folder / "other.h5");
  const std::string other = folder / "other.h5";
  CHECK_THAT(refusal_after([&](ForeignFile& file) {
               file.remove("/V_R");
               REQUIRE(H5Lcreate_external(other.c_str(), "/V_R", file.id(), "/V_R", H5P_DEFAULT, H5P_DEFAULT) >= 0);
             }),
             Contains("no dataset '/V_R'"));

  const std::string raw = folder / "raw";
  std::ofstream(raw) << std::string(layers * columns * 8, '\0');
  CHECK_THAT(refusal_after([&](ForeignFile& file) {
               file.remove("/V_R");
               const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
               REQUIRE(H5Pset_external(creation.get(), raw.c_str(), 0, layers * columns * 8) >= 0);
               file.dataset("/V_R", {layers, columns}, H5T_IEEE_F64LE, creation.get());
             }),
             Contains("in other files"));

  CHECK_THAT(refusal_after([&](ForeignFile& file) {
               file.remove("/V_R");
               const hsize_t shape[] = {layers, columns};
               const Hdf5Handle space(H5Screate_simple(2, shape, nullptr), H5Sclose);
               const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
               REQUIRE(H5Pset_virtual(creation.get(), space.get(), other.c_str(), "/V_R", space.get()) >= 0);
               const Hdf5Handle made(
                   H5Dcreate2(file.id(), "/V_R", H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                   H5Dclose);
               REQUIRE(made.valid());
             }),
             Contains("in other files"));
}

TEST_CASE("a claimed size is not believed before memory is taken") {
  // A billion layers of nothing, in a file of a few kilobytes.
  const auto claim = [](const std::vector<hsize_t>& shape, bool chunked) {
    return refusal_after([&](ForeignFile& file) {
      const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
      const std::vector<hsize_t> chunk(shape.size(), 4);
      if (chunked) H5Pset_chunk(creation.get(), static_cast<int>(chunk.size()), chunk.data());
      for (const char* name : {"/V_R", "/V_L", "/H_R", "/H_L"}) {
        file.remove(name);
        const Hdf5Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
        const Hdf5Handle made(
            H5Dcreate2(file.id(), name, H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
            H5Dclose);
        REQUIRE(made.valid());
      }
    });
  };
  for (const bool chunked : {false, true}) {
    CHECK_THAT(claim({1'000'000'000, 4}, chunked), Contains("claims the shape [1000000000, 4], more than a file of"));
    CHECK_THAT(claim({2'000'000'000, 1'000'000'000}, chunked), Contains("more than a file of"));
    CHECK_THAT(claim({std::uint64_t{1} << 40, 4}, chunked), Contains("not [layers, columns]"));
  }
  CHECK_THAT(claim({3, 4}, false), Contains("never filled"));
}

TEST_CASE("compressed numbers that cannot be unpacked are an error, not zeros") {
  const TemporaryFolder folder;
  write_as_a_script(folder / "pile.h5", H5T_IEEE_F64LE, compressed().get());
  haddr_t address = 0;
  hsize_t size = 0;
  {
    const Hdf5Session session;
    const ForeignFile file(folder / "pile.h5", H5F_ACC_RDONLY);
    const Hdf5Handle dataset(H5Dopen2(file.id(), "/H_R", H5P_DEFAULT), H5Dclose);
    const hsize_t second_layer[] = {1, 0};
    unsigned mask = 0;
    REQUIRE(H5Dget_chunk_info_by_coord(dataset.get(), second_layer, &mask, &address, &size) >= 0);
  }
  std::string bytes = read_file(folder / "pile.h5");
  for (hsize_t i = 0; i < size; ++i) bytes[address + i] = '\x5a';
  write_file(folder / "pile.h5", bytes);
  CHECK_THAT(refusal(folder / "pile.h5"), Contains("'/H_R' cannot be read to its end"));
}

TEST_CASE("a file that shrinks while it is read is an error, not zeros") {
  const TemporaryFolder folder;
  write_pile(folder / "pile.h5", awkward_pile(50, 50));
  const Hdf5Reader reader(folder / "pile.h5", "a pile file");
  CHECK(reader.numbers("/V_R", {50, 50}).size() == 2500);
  std::filesystem::resize_file(folder / "pile.h5", 30'000);
  CHECK_THAT(input_error_of([&] { (void)reader.numbers("/H_L", {50, 50}); }), Contains("changed while it was read"));
}

TEST_CASE("an ensemble of another program is refused") {
  const TemporaryFolder folder;
  write_as_a_script(folder / "pile.h5");
  CHECK_THAT(input_error_of([&] { (void)read_ensemble(folder / "pile.h5"); }),
             Contains("does not say that it is an ensemble"));

  write_ensemble(folder / "ensemble.h5", awkward_ensemble());
  const auto refusal_of_changed = [&](const std::function<void(ForeignFile&)>& change) {
    std::filesystem::copy_file(folder / "ensemble.h5", folder / "changed.h5",
                               std::filesystem::copy_options::overwrite_existing);
    {
      const Hdf5Session session;
      ForeignFile file(folder / "changed.h5", H5F_ACC_RDWR);
      change(file);
    }
    return input_error_of([&] { (void)read_ensemble(folder / "changed.h5"); });
  };
  CHECK_THAT(refusal_of_changed([](ForeignFile& file) { file.remove("/count"); }), Contains("no dataset '/count'"));
  CHECK_THAT(refusal_of_changed([](ForeignFile& file) { file.remove("/thrust/sum_of_squares"); }),
             Contains("no dataset '/thrust/sum_of_squares'"));
  CHECK_THAT(refusal_of_changed([](ForeignFile& file) {
               file.remove("/weight/sum");
               file.dataset("/weight/sum", {3, 2, 5}, H5T_IEEE_F64LE);
             }),
             Contains("'/weight/sum' has the shape [3, 2, 5], not [3, 3, width]"));
  CHECK_THAT(refusal_of_changed([](ForeignFile& file) {
               file.remove("/layers");
               file.dataset("/layers", {3}, H5T_STD_I64LE);
             }),
             Contains("'/layers' does not hold 32-bit integers"));
  CHECK_THAT(refusal_of_changed([](ForeignFile& file) { file.remove("/counters"); }), Contains("/counters"));
  CHECK_THAT(refusal_of_changed([](ForeignFile& file) { file.remove("/failed"); }), Contains("/failed"));
  CHECK_THAT(refusal_of_changed([](ForeignFile& file) { file.remove_attribute("configuration"); }),
             Contains("'configuration'"));
}
