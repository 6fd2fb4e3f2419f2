#include "experiment/experiment.h"

#include <catch2/catch.hpp>

using namespace granuscope;

TEST_CASE("Edit distances of words with known ones") {
  // Counted by hand.
  CHECK(edit_distance("", "") == 0);
  CHECK(edit_distance("", "abc") == 3);
  CHECK(edit_distance("seed", "seed") == 0);
  CHECK(edit_distance("sed", "seed") == 1);
  CHECK(edit_distance("sede", "seed") == 1);  // neighbours swapped
  CHECK(edit_distance("kitten", "sitting") == 3);
  CHECK(edit_distance("saturday", "sunday") == 3);
}

TEST_CASE("The nearest name is found, a far one is not") {
  const std::vector<std::string> known{"columns", "layers", "mu"};
  CHECK(nearest_name("colums", known) == "columns");
  CHECK(nearest_name("layer", known) == "layers");
  CHECK(nearest_name("um", known) == "mu");
  CHECK(nearest_name("C", {"D", "c"}) == "c");
  CHECK(nearest_name("out", {"set", "law"}) == std::nullopt);  // two of three letters are others
  CHECK(nearest_name("temperature", known) == std::nullopt);
  CHECK(nearest_name(std::string(1000, 'x'), known) == std::nullopt);
}
