// Source: merging is adding.
#include "ensemble/ensemble_runner.h"

#include <catch2/catch.hpp>

#include "kit/temporary_folder.h"
#include "storage/record_comparison.h"
#include "storage/sample_records.h"

namespace granuscope {
namespace {

TEST_CASE("every counter is merged, stored and read back") {
  EnsembleRecord whole = test::awkward_ensemble(), part = whole, expected = whole;
  whole.failed.clear();
  std::uint64_t count = 1;
  for (const auto& [name, counter] : sampler_counters) {
    whole.counts.*counter = count;
    part.counts.*counter = count << 20;
    expected.counts.*counter = count + (count << 20);
    ++count;
  }
  merge_into(whole, part);
  for (const auto& [name, counter] : sampler_counters) {
    INFO(name);
    CHECK(whole.counts.*counter == expected.counts.*counter);
  }
  const test::TemporaryFolder folder;
  write_ensemble(folder / "merged.h5", whole);
  test::check_same(read_ensemble(folder / "merged.h5"), whole);
}

}  // namespace
}  // namespace granuscope
