#include "storage/ensemble_file.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <limits>
#include <stdexcept>
#include <thread>

#include "kit/file_size_limit.h"
#include "kit/temporary_folder.h"
#include "storage/pile_file.h"
#include "storage/record_comparison.h"
#include "storage/sample_records.h"
#include "support/atomic_file.h"
#include "support/error.h"

using namespace granuscope;
using namespace granuscope::test;
using Catch::Matchers::Contains;

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
    record.sums.quantities["weight"].sum_of_squares[1 * 15 + 2 * 5 + 3] = std::numeric_limits<double>::infinity();
    CHECK_THAT(message(), Contains("'/weight/sum_of_squares' at [1, 2, 3] is infinite"));
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
