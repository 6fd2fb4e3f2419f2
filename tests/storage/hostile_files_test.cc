// Files that are damaged, foreign or read in a child.
#include <fmt/format.h>
#include <hdf5.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): raise and kill
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <new>
#include <random>
#include <string>
#include <vector>

#include "kit/sanitized.h"
#include "kit/temporary_folder.h"
#include "storage/ensemble_file.h"
#include "storage/foreign_pile.h"
#include "storage/hdf5_file.h"
#include "storage/pile_file.h"
#include "storage/record_comparison.h"
#include "storage/sample_records.h"
#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"

using namespace granuscope;
using namespace granuscope::test;
using Catch::Matchers::Contains;

// Readers meet files damaged at random. They may find the damage or, where a number became another number, not; they
// never crash, hang, or deliver anything that is not finite.

namespace {

using Random = std::mt19937_64;

std::size_t below(std::size_t end, Random& random) {
  return std::uniform_int_distribution<std::size_t>(0, end - 1)(random);
}

/// One of: single bits, bytes, a run of one value, a cut, zeros at the end, one part copied over another.
std::string damaged(std::string bytes, Random& random) {
  switch (below(6, random)) {
    case 0:
      for (std::size_t i = below(4, random) + 1; i > 0; --i) {
        char& byte = bytes[below(bytes.size(), random)];
        byte = static_cast<char>(byte ^ (1 << below(8, random)));
      }
      break;
    case 1:
      for (std::size_t i = below(16, random) + 1; i > 0; --i) {
        bytes[below(bytes.size(), random)] = static_cast<char>(below(256, random));
      }
      break;
    case 2: {
      const std::size_t start = below(bytes.size(), random);
      const std::size_t length = std::min(below(64, random) + 1, bytes.size() - start);
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(start), length, below(2, random) == 0 ? '\0' : '\xff');
      break;
    }
    case 3:
      bytes.resize(below(bytes.size(), random));
      break;
    case 4:
      std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(below(bytes.size(), random)), bytes.end(), '\0');
      break;
    default: {
      const std::size_t length = below(bytes.size() / 4, random) + 1;
      const std::size_t from = below(bytes.size() - length, random);
      bytes.replace(below(bytes.size() - length, random), length, bytes.substr(from, length));
    }
  }
  return bytes;
}

/// Without waiting for the disk, as write_file would.
void write_quickly(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
}

bool all_finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

/// What became of many damaged versions of one file.
struct Tally {
  int read = 0, refused = 0;
  int library_gave_up = 0;  ///< crashes and endless loops of the library, among those refused
};

/// Reads one damaged version.
void read_damaged(const std::string& good, const std::filesystem::path& bad, Random& random,
                  const std::function<bool(const std::filesystem::path&)>& reads_finite, Tally& tally) {
  write_quickly(bad, damaged(good, random));
  try {
    const bool finite = reads_finite(bad);
    REQUIRE(finite);
    ++tally.read;
  } catch (const InputError& error) {
    ++tally.refused;
    const std::string message = error.what();
    REQUIRE(message.find(bad) != std::string::npos);
    REQUIRE(message.size() < 2000);
    if (message.find("the HDF5 library") != std::string::npos) ++tally.library_gave_up;
  }
}

/// Reads `count` damaged versions of a file.
Tally read_many(const std::filesystem::path& good, int count, std::uint64_t seed,
                const std::function<bool(const std::filesystem::path&)>& reads_finite) {
  const std::string bytes = read_file(good);
  Random random(seed);
  Tally tally;
  for (int i = 0; i < count; ++i) {
    CAPTURE(seed, i);
    read_damaged(bytes, good.string() + ".bad", random, reads_finite, tally);
  }
  return tally;
}

/// The same for as long as `seconds`, and `least` versions even if that takes longer: an endless loop in the library
/// takes five seconds of its own. With a seed of its own each time: printed, and taken from the environment variable
/// GRANUSCOPE_FUZZ_SEED if that is there.
Tally read_for(double seconds, int least, const std::filesystem::path& good,
               const std::function<bool(const std::filesystem::path&)>& reads_finite) {
  const char* given = std::getenv("GRANUSCOPE_FUZZ_SEED");  // NOLINT(concurrency-mt-unsafe): no threads here
  const std::uint64_t seed = given != nullptr ? std::strtoull(given, nullptr, 10) : std::random_device()();
  const std::string bytes = read_file(good);
  Random random(seed);
  Tally tally;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  for (int i = 0; i < least || std::chrono::steady_clock::now() < end; ++i) {
    CAPTURE(seed, i);
    read_damaged(bytes, good.string() + ".bad", random, reads_finite, tally);
  }
  std::cout << fmt::format("{}: GRANUSCOPE_FUZZ_SEED={}: {} read, {} refused, {} of them given up by the library\n",
                           good.filename().string(), seed, tally.read, tally.refused, tally.library_gave_up);
  return tally;
}

bool pile_reads_finite(const std::filesystem::path& file) {
  const Pile pile = read_pile(file);
  return all_finite(pile.V_R) && all_finite(pile.V_L) && all_finite(pile.H_R) && all_finite(pile.H_L) &&
         all_finite(pile.load) && std::isfinite(pile.mu) && pile.V_R.size() == pile.lattice.beads() &&
         pile.load.size() == static_cast<std::size_t>(pile.lattice.columns());
}

bool ensemble_reads_finite(const std::filesystem::path& file) {
  const EnsembleRecord record = read_ensemble(file);
  return std::all_of(record.sums.quantities.begin(), record.sums.quantities.end(), [](const auto& entry) {
    return all_finite(entry.second.sum) && all_finite(entry.second.sum_of_squares);
  });
}

}  // namespace

namespace {
constexpr int damaged_files = test::sanitized ? 120 : 300;  // the cases of label fuzz try more
}

TEST_CASE("damaged piles are refused or harmless") {
  const TemporaryFolder folder;
  write_pile(folder / "pile.h5", awkward_pile(3, 5));
  // Most bytes of so small a file are metadata, which carry checksums.
  const Tally tally = read_many(folder / "pile.h5", damaged_files, 1, pile_reads_finite);
  CHECK(tally.refused > damaged_files / 2);
  CHECK(tally.library_gave_up == 0);
}

TEST_CASE("damaged ensembles are refused or harmless") {
  const TemporaryFolder folder;
  write_ensemble(folder / "ensemble.h5", awkward_ensemble());
  const Tally tally = read_many(folder / "ensemble.h5", damaged_files, 2, ensemble_reads_finite);
  CHECK(tally.refused > damaged_files / 2);
  CHECK(tally.library_gave_up == 0);
}

TEST_CASE("damaged piles of other programs are refused or harmless") {
  const TemporaryFolder folder;
  write_as_a_script(folder / "pile.h5");
  CHECK(read_many(folder / "pile.h5", damaged_files / 3 * 2, 3, pile_reads_finite).refused > damaged_files / 6);
}

TEST_CASE("files damaged again and again", "[fuzz]") {
  constexpr double seconds = test::sanitized ? 12 : 4;
  constexpr int least = 150;  // fewer would mean nothing; about half of them or more are refused
  const TemporaryFolder folder;
  write_pile(folder / "pile.h5", awkward_pile(3, 5));
  write_ensemble(folder / "ensemble.h5", awkward_ensemble());
  write_as_a_script(folder / "old-format.h5");
  write_as_a_script(folder / "compressed.h5", H5T_IEEE_F64LE, compressed().get());
  CHECK(read_for(seconds, least, folder / "pile.h5", pile_reads_finite).refused > least / 3);
  CHECK(read_for(seconds, least, folder / "ensemble.h5", ensemble_reads_finite).refused > least / 3);
  // These have no checksums: the library meets the damage itself.
  CHECK(read_for(seconds, least, folder / "old-format.h5", pile_reads_finite).refused > least / 3);
  CHECK(read_for(seconds, least, folder / "compressed.h5", pile_reads_finite).refused > least / 3);
}

TEST_CASE("a pile that is cut anywhere is refused") {
  constexpr std::size_t step = test::sanitized ? 29 : 7;  // bytes
  const TemporaryFolder folder;
  write_pile(folder / "pile.h5", awkward_pile(1, 4));
  const std::string bytes = read_file(folder / "pile.h5");
  for (std::size_t length = 0; length < bytes.size(); length += step) {
    write_quickly(folder / "cut.h5", bytes.substr(0, length));
    CAPTURE(length);
    REQUIRE_THROWS_AS(read_pile(folder / "cut.h5"), InputError);
  }
}

// Files that other programs wrote: what follows the published layout is read, whatever wrote it; the rest is refused.

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
  for (const double mu : {-1.0, -1e-9, 1.8, 1e100}) {  // as audit has it, whichever verb opens the file
    CHECK_THAT(with("mu", [&](ForeignFile& f) { f.attribute("mu", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &mu); }),
               Contains("friction coefficient"));
  }
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

// Whatever a damaged file makes the library do: here each of it is done on purpose.

namespace {

std::size_t open_files() {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}

bool has_children() { return !(::waitpid(-1, nullptr, WNOHANG) == -1 && errno == ECHILD); }

std::string refusal_of(const std::function<std::string()>& read, ReadPatience patience = {}) {
  return input_error_of([&] { (void)read_in_child("file.h5", "a pile file", read, patience); });
}

}  // namespace

TEST_CASE("what the child returns arrives whole") {
  const std::size_t before = open_files();
  CHECK(read_in_child("file.h5", "a pile file", [] { return std::string(); }).empty());
  CHECK(read_in_child("file.h5", "a pile file", [] { return std::string("a\0b", 3); }) == std::string("a\0b", 3));
  std::string much(30'000'000, 'x');
  much.back() = 'y';
  CHECK(read_in_child("file.h5", "a pile file", [&much] { return much; }) == much);
  CHECK(open_files() == before);
  CHECK_FALSE(has_children());
}

TEST_CASE("a pipe that the shell has opened is called so") {
  int ends[2] = {};
  REQUIRE(::pipe(ends) == 0);
  const std::string pipe = "/dev/fd/" + std::to_string(ends[0]);
  const auto read = [] { return std::string("not asked"); };
  CHECK_THAT(input_error_of([&] { (void)read_in_child(pipe, "a pile file", read); }),
             Contains("in a pipe. Name a file"));
  for (const int end : ends) ::close(end);
}

TEST_CASE("what the child does to its memory stays there") {
  int value = 1;
  CHECK(read_in_child("file.h5", "a pile file", [&value] { return std::to_string(++value); }) == "2");
  CHECK(value == 1);
}

TEST_CASE("errors of the child keep their kind and words") {
  CHECK(refusal_of([]() -> std::string { throw InputError("not this one"); }) == "not this one");
  CHECK_THROWS_AS(read_in_child("f", "k", []() -> std::string { throw EnvironmentError("no"); }), EnvironmentError);
  CHECK_THROWS_AS(read_in_child("f", "k", []() -> std::string { throw std::bad_alloc(); }), std::bad_alloc);
  CHECK_THROWS_WITH(read_in_child("f", "k", []() -> std::string { throw std::logic_error("a fault"); }), "a fault");
  CHECK_FALSE(has_children());
}

TEST_CASE("a crash ends the child only") {
  const std::size_t before = open_files();
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE}) {
    const std::string message = refusal_of([signal]() -> std::string {
      ::signal(signal, SIG_DFL);  // a sanitizer would tell a tale first
      ::raise(signal);
      return "never";
    });
    CHECK_THAT(message, Contains("cannot read 'file.h5' as a pile file") && Contains("crashed") &&
                            Contains("damaged") && Contains("Make the file again"));
  }
  // A library that ends the process by itself, with the status of success.
  CHECK_THAT(refusal_of([]() -> std::string { ::_exit(0); }), Contains("crashed"));
  CHECK(open_files() == before);
  CHECK_FALSE(has_children());
}

TEST_CASE("an endless loop and an endless wait are ended") {
  const auto started = std::chrono::steady_clock::now();
  CHECK_THAT(refusal_of(
                 []() -> std::string {
                   for (volatile unsigned i = 0;;) i = i + 1;
                 },
                 {.processor_seconds = 1, .wall_seconds = 60}),
             Contains("did not come to an end"));
  CHECK_THAT(refusal_of(
                 []() -> std::string {
                   for (;;) ::pause();
                 },
                 {.processor_seconds = 10, .wall_seconds = 0.3}),
             Contains("did not come to an end within 0 s"));
  CHECK(std::chrono::steady_clock::now() - started < std::chrono::seconds(50));
  CHECK_FALSE(has_children());
}

TEST_CASE("a request to stop ends the reading") {
  request_interruption(true);
  CHECK_THROWS_AS(read_in_child("f", "k",
                                []() -> std::string {
                                  for (;;) ::pause();
                                }),
                  Interrupted);
  request_interruption(false);
  CHECK_FALSE(has_children());
}

TEST_CASE("the child does not hold the caller's files open") {
  const TemporaryFolder folder;
  std::ofstream other(folder / "other");
  const std::string open = read_in_child("f", "k", [] { return std::to_string(open_files()); });
  CHECK(open == "5");  // nothing three times, the answer, and the folder that is looked at
}
