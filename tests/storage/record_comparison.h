#pragma once
#include <catch2/catch.hpp>
#include <cstring>
#include <string>

#include "kit/same_bytes.h"
#include "model/pile.h"
#include "storage/ensemble_file.h"
#include "support/error.h"

namespace granuscope::test {

inline void check_same(const Pile& a, const Pile& b) {
  CHECK(a.lattice.layers() == b.lattice.layers());
  CHECK(a.lattice.columns() == b.lattice.columns());
  CHECK(same_bytes(a.V_R, b.V_R));
  CHECK(same_bytes(a.V_L, b.V_L));
  CHECK(same_bytes(a.H_R, b.H_R));
  CHECK(same_bytes(a.H_L, b.H_L));
  CHECK(same_bytes(a.load, b.load));
  CHECK(same_key(a, b));
}

inline void check_same(const EnsembleRecord& a, const EnsembleRecord& b) {
  CHECK(a.configuration == b.configuration);
  CHECK(a.configuration_key == b.configuration_key);
  CHECK(a.sampling_version == b.sampling_version);
  CHECK(a.sums.layers == b.sums.layers);
  CHECK(a.sums.first_block == b.sums.first_block);
  CHECK(a.sums.count == b.sums.count);
  REQUIRE(a.sums.quantities.size() == b.sums.quantities.size());
  for (const auto& [name, sums] : a.sums.quantities) {
    REQUIRE(b.sums.quantities.count(name) == 1);
    const QuantitySums& other = b.sums.quantities.at(name);
    CHECK(sums.width == other.width);
    CHECK(same_bytes(sums.sum, other.sum));
    CHECK(same_bytes(sums.sum_of_squares, other.sum_of_squares));
  }
  CHECK(std::memcmp(&a.counts, &b.counts, sizeof a.counts) == 0);
  REQUIRE(a.failed.size() == b.failed.size());
  for (std::size_t i = 0; i < a.failed.size(); ++i) {
    CHECK(a.failed[i].sample == b.failed[i].sample);
    CHECK(a.failed[i].layer == b.failed[i].layer);
    CHECK(a.failed[i].replay == b.failed[i].replay);
  }
}

/// The message of the InputError that `action` throws.
template <class Action>
std::string input_error_of(const Action& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  FAIL("no InputError was thrown");
  return "";
}

}  // namespace granuscope::test
