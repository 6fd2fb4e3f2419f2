// Readers meet files damaged at random. They may find the damage or, where a number became another number, not; they
// never crash, hang, or deliver anything that is not finite.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <random>
#include <string>

#include "kit/temporary_folder.h"
#include "storage/ensemble_file.h"
#include "storage/foreign_pile.h"
#include "storage/pile_file.h"
#include "storage/record_comparison.h"
#include "storage/sample_records.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using namespace granuscope::test;

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

TEST_CASE("damaged piles are refused or harmless") {
  const TemporaryFolder folder;
  write_pile(folder / "pile.h5", awkward_pile(3, 5));
  // Most bytes of so small a file are metadata, which carry checksums.
  const Tally tally = read_many(folder / "pile.h5", 300, 1, pile_reads_finite);
  CHECK(tally.refused > 150);
  CHECK(tally.library_gave_up == 0);
}

TEST_CASE("damaged ensembles are refused or harmless") {
  const TemporaryFolder folder;
  write_ensemble(folder / "ensemble.h5", awkward_ensemble());
  const Tally tally = read_many(folder / "ensemble.h5", 300, 2, ensemble_reads_finite);
  CHECK(tally.refused > 150);
  CHECK(tally.library_gave_up == 0);
}

TEST_CASE("damaged piles of other programs are refused or harmless") {
  const TemporaryFolder folder;
  write_as_a_script(folder / "pile.h5");
  CHECK(read_many(folder / "pile.h5", 200, 3, pile_reads_finite).refused > 50);
}

TEST_CASE("files damaged again and again", "[fuzz]") {
  constexpr double seconds = 12;
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

TEST_CASE("every possible cut of a pile is refused") {
  const TemporaryFolder folder;
  write_pile(folder / "pile.h5", awkward_pile(1, 4));
  const std::string bytes = read_file(folder / "pile.h5");
  for (std::size_t length = 0; length < bytes.size(); length += 7) {
    write_quickly(folder / "cut.h5", bytes.substr(0, length));
    CAPTURE(length);
    REQUIRE_THROWS_AS(read_pile(folder / "cut.h5"), InputError);
  }
}
