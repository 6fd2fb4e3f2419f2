// Files of ensembles.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <thread>

#include "kit/file_size_limit.h"
#include "kit/sanitized.h"
#include "kit/temporary_folder.h"
#include "storage/ensemble_file.h"
#include "storage/pile_file.h"
#include "storage/record_comparison.h"
#include "storage/sample_records.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using namespace granuscope::test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

TEST_CASE("an ensemble comes back bit by bit") {
  const TemporaryFolder folder;
  EnsembleRecord record = awkward_ensemble();
  SECTION("as it is") {}
  SECTION("nothing failed") { record.failed.clear(); }
  SECTION("many failed") {
    for (std::uint64_t i = 0; i < 1000; ++i) record.failed.push_back({i, 3, std::string(i % 90, 'r')});
  }
  SECTION("no quantity") { record.sums.quantities.clear(); }
  SECTION("no layer") {
    record.sums.layers.clear();
    for (auto& [name, sums] : record.sums.quantities) {
      sums.sum.clear();
      sums.sum_of_squares.clear();
    }
  }
  SECTION("no block") {
    record.sums.count.clear();
    record.sums.quantities.clear();
  }
  SECTION("no text") { record.configuration = record.configuration_key = record.sampling_version = ""; }
  SECTION("a configuration beyond the 64 KiB of a common attribute") {
    record.configuration = std::string(300'000, 'c') + "end";
  }
  SECTION("many quantities") {
    for (int i = 0; i < 40; ++i) {
      record.sums.quantities["quantity " + std::to_string(i)] = record.sums.quantities["weight"];
    }
  }
  write_ensemble(folder / "ensemble.h5", record);
  check_same(read_ensemble(folder / "ensemble.h5"), record);
  CHECK(folder.contents() == std::vector<std::string>{"ensemble.h5"});
}

TEST_CASE("the same ensemble gives the same bytes at any time") {
  const TemporaryFolder folder;
  const EnsembleRecord record = awkward_ensemble();
  write_ensemble(folder / "first.h5", record);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // HDF5's times count seconds
  write_ensemble(folder / "second.h5", record);
  CHECK(read_file(folder / "first.h5") == read_file(folder / "second.h5"));
}

TEST_CASE("an ensemble written and read block by block is the same") {
  const TemporaryFolder folder;
  const EnsembleRecord whole = awkward_ensemble();
  write_ensemble(folder / "whole.h5", whole);
  std::vector<std::string> keys;
  for (int b = 0; b < whole.sums.blocks(); ++b) {
    EnsembleRecord one = whole;
    one.sums = take_blocks(whole.sums, static_cast<std::size_t>(b), 1);
    CHECK(one.sums.first_block == b);
    write_ensemble(folder / std::to_string(b), one);
    const EnsembleReader reader(folder / std::to_string(b));
    CHECK(reader.header().sums.first_block == b);
    keys.push_back(reader.keys().at(0));
    CHECK(keys.back() == EnsembleReader(folder / "whole.h5").keys().at(static_cast<std::size_t>(b)));
    one.sums = reader.read_block(0);
    check_same(read_ensemble(folder / std::to_string(b)), one);
  }
  EnsembleRecord header = whole;
  for (auto& [name, quantity] : header.sums.quantities) quantity.sum = quantity.sum_of_squares = {};
  write_ensemble(folder / "joined.h5", header, keys,
                 [&](std::size_t b) { return EnsembleReader(folder / std::to_string(b)).read_block(0); });
  CHECK(read_file(folder / "joined.h5") == read_file(folder / "whole.h5"));
}

TEST_CASE("an opened ensemble gives each layer as the one in memory does") {
  const TemporaryFolder folder;
  const EnsembleRecord whole = awkward_ensemble();
  write_ensemble(folder / "whole.h5", whole);
  const EnsembleRecord opened = open_ensemble(folder / "whole.h5");
  CHECK(opened.sums.quantities.at("weight").sum.empty());
  write_file(folder / "another", "replaced");
  fs::rename(folder / "another", folder / "whole.h5");  // what is open stays what it was
  for (const auto& [name, quantity] : whole.sums.quantities) {
    for (std::size_t row = 0; row < whole.sums.layers.size(); ++row) {
      const LayerSums one = whole.sums.layer(name, row), other = opened.sums.layer(name, row);
      REQUIRE(one.blocks() == whole.sums.count.size());
      REQUIRE(other.blocks() == one.blocks());
      REQUIRE(other.width() == one.width());
      for (std::size_t b = 0; b < one.blocks(); ++b) {
        CHECK(std::memcmp(one.block(b), other.block(b), one.width() * sizeof(double)) == 0);
      }
    }
  }
  CHECK_THROWS_AS(take_blocks(opened.sums, 0, 1), std::logic_error);
  EnsembleRecord loaded = opened;
  loaded.sums = in_memory(opened.sums);
  check_same(loaded, whole);
}

TEST_CASE("blocks put into a shared file in any order make the bytes of the whole") {
  const TemporaryFolder folder;
  EnsembleRecord whole = awkward_ensemble();
  const bool failures = GENERATE(true, false);
  if (!failures) whole.failed.clear();
  write_ensemble(folder / "whole.h5", whole);
  const EnsembleReader reader(folder / "whole.h5");
  EnsembleRecord header = reader.header();
  header.sums.count.assign(header.sums.count.size(), 0);  // not known yet
  header.counts = {};
  header.failed.clear();
  write_file(folder / "shared", "");
  {
    SharedEnsemble one(folder / "shared", header), other(folder / "shared", header);
    one.put(2, reader.read_block(2));
    other.put(0, reader.read_block(0));
    SharedEnsemble(folder / "shared", header).put(1, reader.read_block(1));
  }
  REQUIRE(finish_shared(folder / "shared", folder / "joined.h5", reader.header(), reader.keys()));
  CHECK(read_file(folder / "joined.h5") == read_file(folder / "whole.h5"));
  CHECK_FALSE(fs::exists(folder / "shared"));
}

TEST_CASE("an ensemble larger than the memory left is written block by block and read layer by layer") {
  // 200 MB in 24 blocks, of which a process with 60 MB more than now holds one or two at a time; a layer has 13 MB.
  const TemporaryFolder folder;
  EnsembleRecord header;
  header.sums.layers = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  header.sums.count.assign(24, 8);
  header.sums.quantities["weight"].width = 1 << 16;
  const auto block = [&](std::size_t b) {
    BlockSums one = zero_sums(header.sums, static_cast<int>(b), 1);
    one.count = {8};
    one.quantities["weight"].sum.back() = static_cast<double>(b);
    return one;
  };
  std::vector<std::string> keys;
  for (std::size_t b = 0; b < header.sums.count.size(); ++b) keys.push_back(key_of_block(block(b), 0));
  rlimit before = {};
  ::getrlimit(RLIMIT_DATA, &before);
  std::ifstream statm("/proc/self/statm");
  std::uint64_t pages = 0, skipped = 0;
  statm >> pages >> skipped >> skipped >> skipped >> skipped >> pages;  // the sixth: data
  const rlimit limited = {pages * static_cast<std::uint64_t>(::getpagesize()) + (std::uint64_t{60} << 20),
                          before.rlim_max};
  if (!sanitized) ::setrlimit(RLIMIT_DATA, &limited);
  CHECK_NOTHROW(write_ensemble(folder / "large.h5", header, keys, block));
  double last = 0;
  CHECK_NOTHROW(last = open_ensemble(folder / "large.h5").sums.layer("weight", 15).block(23)[(1 << 16) - 1]);
  ::setrlimit(RLIMIT_DATA, &before);
  CHECK(last == 23);
  CHECK(std::filesystem::file_size(folder / "large.h5") > std::uint64_t{24} << 23);
}

TEST_CASE("what is not an ensemble file is refused") {
  const TemporaryFolder folder;
  const auto message = [&folder](const std::string& name) {
    return input_error_of([&] { (void)read_ensemble(folder / name); });
  };
  CHECK_THAT(message("missing.h5"), Contains("No such file or directory"));
  write_file(folder / "text.h5", "mu = 0.1\n");
  CHECK_THAT(message("text.h5"), Contains("not an HDF5 file"));
  write_pile(folder / "pile.h5", awkward_pile(4, 4));
  CHECK_THAT(message("pile.h5"), Contains("it is a granuscope pile file"));
}

TEST_CASE("damaged sums are refused where they are") {
  const TemporaryFolder folder;
  EnsembleRecord record = awkward_ensemble();
  const auto message = [&] {
    write_ensemble(folder / "ensemble.h5", record);
    return input_error_of([&] { (void)read_ensemble(folder / "ensemble.h5"); });
  };
  SECTION("not finite") {
    record.sums.quantities["weight"].sum[1 * 15 + 2 * 5 + 3] = std::numeric_limits<double>::infinity();
    CHECK_THAT(message(), Contains("'/weight/sum' at [1, 2, 3] is infinite"));
  }
  SECTION("layers out of order") {
    record.sums.layers = {0, 4, 4};
    CHECK_THAT(message(), Contains("ascending"));
  }
  SECTION("layers below the top") {
    record.sums.layers = {-1, 4, 5};
    CHECK_THAT(message(), Contains("ascending from 0"));
  }
}

TEST_CASE("one flipped bit of the numbers is noticed") {
  const TemporaryFolder folder;
  EnsembleRecord record = awkward_ensemble();
  const double marker = 1234567.0625;  // a pattern of bytes found once in the file
  record.sums.quantities["weight"].sum.back() = marker;
  write_ensemble(folder / "ensemble.h5", record);
  std::string bytes = read_file(folder / "ensemble.h5");
  const std::size_t at = bytes.find(std::string_view(reinterpret_cast<const char*>(&marker), sizeof marker));
  REQUIRE(at != std::string::npos);
  bytes[at] = static_cast<char>(bytes[at] ^ 1);  // the last bit of its mantissa
  write_file(folder / "ensemble.h5", bytes);
  CHECK_THROWS_WITH(read_ensemble(folder / "ensemble.h5"), Contains("damaged"));
}

TEST_CASE("a record that contradicts itself is not written") {
  const TemporaryFolder folder;
  EnsembleRecord record = awkward_ensemble();
  SECTION("sums of the wrong size") { record.sums.quantities["weight"].sum.pop_back(); }
  SECTION("squares of the wrong size") { record.sums.quantities["thrust"].sum_of_squares.push_back(1); }
  SECTION("no width") { record.sums.quantities["thrust"].width = 0; }
  SECTION("a name that is taken") { record.sums.quantities["counters"] = record.sums.quantities["thrust"]; }
  SECTION("a name that is a path") { record.sums.quantities["a/b"] = record.sums.quantities["thrust"]; }
  CHECK_THROWS_AS(write_ensemble(folder / "ensemble.h5", record), std::logic_error);
  CHECK(folder.contents().empty());
}

TEST_CASE("a full disk keeps the old ensemble") {
  const TemporaryFolder folder;
  EnsembleRecord record = awkward_ensemble();
  write_ensemble(folder / "ensemble.h5", record);
  {
    const FileSizeLimit limit(5'000);
    CHECK_THROWS_AS(write_ensemble(folder / "ensemble.h5", record), EnvironmentError);
  }
  CHECK(folder.contents() == std::vector<std::string>{"ensemble.h5"});
  check_same(read_ensemble(folder / "ensemble.h5"), record);
}

// Source: what is written must be read again; files of beads must not change.

TEST_CASE("where the rows of a model lie is stored with its sums, and goes without saying for beads") {
  const test::TemporaryFolder folder;
  EnsembleRecord record = test::awkward_ensemble();
  write_ensemble(folder.path() / "beads.h5", record);
  CHECK(read_ensemble(folder.path() / "beads.h5").sums.rows == RowGeometry{});
  CHECK(read_file(folder.path() / "beads.h5").find("row_spacing") == std::string::npos);
  record.sums.rows = {.spacing = sqrt3, .staggered = false};
  write_ensemble(folder.path() / "legs.h5", record);
  CHECK(read_ensemble(folder.path() / "legs.h5").sums.rows == record.sums.rows);
}

TEST_CASE("a change of what an ensemble says beside its numbers is noticed") {
  const TemporaryFolder folder;
  EnsembleRecord record = awkward_ensemble();
  record.counts.beads = 0x123456789abc;  // found once
  const fs::path file = folder / "ensemble.h5";
  const auto in_file = [](const auto& value) {
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const double deepest = RowGeometry{}.depth(4);
  for (const std::string& written : {in_file(record.failed[1].sample), in_file(deepest), in_file(record.counts.beads),
                                     std::string("--sample 17"), std::string("mu = 0.1")}) {
    write_ensemble(file, record);
    std::string bytes = read_file(file);
    const std::size_t at = bytes.rfind(written);
    REQUIRE(at != std::string::npos);
    bytes[at + written.size() - 1] = static_cast<char>(bytes[at + written.size() - 1] ^ 1);
    write_file(file, bytes);
    CHECK_THROWS_WITH(read_ensemble(file), Contains("damaged"));  // HDF5 itself looks at its attributes
  }
}

TEST_CASE("a file that is locked is not called damaged") {
  const TemporaryFolder folder;
  const fs::path file = folder / "ensemble.h5";
  write_ensemble(file, awkward_ensemble());
  const FileDescriptor other(::open(file.c_str(), O_RDWR | O_CLOEXEC));
  REQUIRE(::flock(other.get(), LOCK_EX) == 0);
  CHECK_NOTHROW(read_ensemble(file));
  ::setenv("HDF5_USE_FILE_LOCKING", "TRUE", 1);
  CHECK_THROWS_AS(read_ensemble(file), EnvironmentError);
  CHECK_THROWS_WITH(read_ensemble_configuration(file), Contains("another program has it locked"));
  ::flock(other.get(), LOCK_UN);
  CHECK_NOTHROW(read_ensemble(file));
  ::unsetenv("HDF5_USE_FILE_LOCKING");
}
