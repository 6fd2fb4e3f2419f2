#include "bench/suites.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

using granuscope::with_measured_with;

TEST_CASE("A suite's JSON says by what and when it was measured, and keeps its numbers") {
  for (const char* suite :
       {"{\n  \"suite\": \"sampler\",\n  \"cases\": [1.5]\n}\n", R"({"suite":"sampler","cases":[1.5]})"}) {
    const auto json = nlohmann::json::parse(with_measured_with(suite));
    CHECK(json.at("suite") == "sampler");
    CHECK(json.at("cases") == nlohmann::json::array({1.5}));
    for (const char* key : {"program", "commit", "changed", "compiler", "processor", "threads", "date"}) {
      INFO(key);
      CHECK(json.at("measured").contains(key));
    }
    CHECK(json.at("measured").at("date").get<std::string>().size() == 10);
  }
}
