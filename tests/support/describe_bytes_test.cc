#include "support/plain_text.h"

#include <catch2/catch.hpp>

using namespace granuscope;

TEST_CASE("sizes are told in megabytes, gigabytes and terabytes") {
  CHECK(describe_bytes(0) == "0.0 MB");
  CHECK(describe_bytes(2.5e6) == "2.5 MB");
  CHECK(describe_bytes(25.3e9) == "25.3 GB");
  CHECK(describe_bytes(1.58e14) == "158 TB");
  CHECK(describe_bytes(4.611686e20) == "4.61e+08 TB");
}
