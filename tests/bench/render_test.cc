#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "bench/suites.h"
#include "kit/temporary_folder.h"

namespace granuscope {
namespace {

TEST_CASE("the render suite has every size, with and without skipping, and the small window of a large pile") {
  std::set<std::string> names;
  for (const RenderCase& picture : render_cases(false)) names.insert(picture.name);
  CHECK(names.size() == 25);
  for (const char* name : {"1000 x 1000 to 2000 px", "1000 x 1000 to 2000 px, all drawn", "4000 x 4000 to 8000 px",
                           "100 x 100 window of 4000 x 4000 to 800 px"}) {
    CHECK(names.contains(name));
  }
  CHECK(render_cases(true).size() < names.size());
}

TEST_CASE("a picture of the suite is timed in its steps, with its counts and memory; what cannot be rendered says so") {
  const test::TemporaryFolder folder;
  RenderCase picture;
  picture.name = "1000 x 1000 to 2000 px";  // has targets; smaller here
  picture.columns = 30;
  picture.layers = 20;
  picture.spec.width_px = 500;
  RenderCase impossible = picture;
  impossible.name = "impossible";
  impossible.spec.width_px = 1;
  const RenderBench bench = run_render_suite({picture, impossible}, folder.path(), [](const std::string&) {});
  CHECK(folder.contents().empty());
  const nlohmann::json json = nlohmann::json::parse(render_bench_json(bench));
  CHECK(json.at("suite") == "render");
  REQUIRE(json.at("pictures").size() == 2);
  const auto& drawn = json.at("pictures").at(0);
  const auto& seconds = drawn.at("seconds");
  double steps = 0;
  for (const char* step : {"read", "build", "draw", "encode"}) steps += seconds.at(step).get<double>();
  CHECK(steps > 0);
  CHECK(steps <= seconds.at("all").get<double>());
  const auto count = [&](const char* name) { return drawn.at(name).get<int>(); };
  CHECK(count("drawn") + count("outside") + count("too_faint") + count("aggregated") == 2 * 30 * 20);
  CHECK(drawn.at("peak_bytes").get<double>() > 1e6);
  CHECK(json.at("pictures").at(1).at("seconds").is_null());
  REQUIRE(json.at("targets").size() == 1);
  CHECK(json.at("targets").at(0).at("measured") == seconds.at("all"));
  CHECK_THAT(render_bench_table(bench), Catch::Contains("1000 x 1000 to 2000 px") && Catch::Contains("impossible"));
}

}  // namespace
}  // namespace granuscope
