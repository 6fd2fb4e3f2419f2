// Readers meet files damaged at random. They may find the damage or, where a number became another number, not; they
// never crash, hang, or deliver anything that is not finite.
#include <fmt/format.h>

#include <hdf5.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <functional>
#include <random>
#include <string>

#include "storage/ensemble_file.h"
#include "storage/hdf5_handle.h"
#include "storage/pile_file.h"
#include "storage/record_comparison.h"
#include "storage/sample_records.h"
#include "support/atomic_file.h"
#include "support/error.h"
#include "support/temporary_folder.h"

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

/// Reads `count` damaged versions of a file; returns how many were refused.
int refused_of(const std::filesystem::path& good, int count, std::uint64_t seed,
               const std::function<bool(const std::filesystem::path&)>& reads_finite) {
  const std::string bytes = read_file(good);
  Random random(seed);
  int refused = 0;
  const std::string bad = good.string() + ".bad";
  for (int i = 0; i < count; ++i) {
    write_quickly(bad, damaged(bytes, random));
    CAPTURE(seed, i);
    try {
      const bool finite = reads_finite(bad);
      REQUIRE(finite);
    } catch (const InputError& error) {
      ++refused;
      const std::string message = error.what();
      REQUIRE(message.find(bad) != std::string::npos);
      REQUIRE(message.size() < 2000);
    }
  }
  // Nothing is left open, however the reading ended.
  const Hdf5Session session;
  CHECK(H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_ALL) == 0);
  return refused;
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
  CHECK(refused_of(folder / "pile.h5", 600, 1, pile_reads_finite) > 300);
}

TEST_CASE("damaged ensembles are refused or harmless") {
  const TemporaryFolder folder;
  write_ensemble(folder / "ensemble.h5", awkward_ensemble());
  CHECK(refused_of(folder / "ensemble.h5", 600, 2, ensemble_reads_finite) > 300);
}

TEST_CASE("many more damaged files", "[long]") {
  const TemporaryFolder folder;
  write_pile(folder / "pile.h5", awkward_pile(3, 5));
  write_ensemble(folder / "ensemble.h5", awkward_ensemble());
  CHECK(refused_of(folder / "pile.h5", 20'000, 3, pile_reads_finite) > 10'000);
  CHECK(refused_of(folder / "ensemble.h5", 20'000, 4, ensemble_reads_finite) > 10'000);
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
