#include "analysis/fit_spec.h"

#include <catch2/catch.hpp>
#include <string>

namespace granuscope {
namespace {

/// f: fitted, s: of another shape, u: unidentified; shallowest first.
std::vector<std::size_t> run_of(const std::string& depths) {
  std::vector<DepthUse> uses;
  for (const char depth : depths) {
    uses.push_back(depth == 'f' ? DepthUse::fitted : depth == 's' ? DepthUse::other_shape : DepthUse::unidentified);
  }
  return identifiable_depths(uses);
}

using Run = std::vector<std::size_t>;

}  // namespace

TEST_CASE("the deepest run ends at an unidentified depth and at two of another shape, and leaves a single one out") {
  CHECK(run_of("") == Run{});
  CHECK(run_of("ffff") == Run{0, 1, 2, 3});
  CHECK(run_of("ffuff") == Run{3, 4});
  CHECK(run_of("fffu") == Run{});
  CHECK(run_of("ffsff") == Run{0, 1, 3, 4});
  CHECK(run_of("fsfsf") == Run{0, 2, 4});
  CHECK(run_of("ffssff") == Run{4, 5});
  CHECK(run_of("fffs") == Run{0, 1, 2});
  CHECK(run_of("ffss") == Run{});
  CHECK(run_of("ffusff") == Run{4, 5});
  CHECK(run_of("fsuff") == Run{3, 4});
  CHECK(run_of("sfff") == Run{1, 2, 3});
  CHECK(run_of("ssss") == Run{});
}

}  // namespace granuscope
