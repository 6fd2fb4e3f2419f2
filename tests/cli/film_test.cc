// A film of a window that slides down a pile.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "cli/in_process.h"
#include "kit/png_image.h"
#include "kit/temporary_folder.h"
#include "support/files.h"

using namespace granuscope;
using Catch::Matchers::Contains;

TEST_CASE("A film slides down a pile: frames of one size, the same bytes for every number of threads") {
  const test::TemporaryFolder folder;
  const std::string at = folder.path().string(), pile = at + "/pile.h5";
  REQUIRE(
      granuscope_command({"sample", "--mu", "0.3", "--columns", "24", "--layers", "40", "--load", "point", "-o", pile})
          .code == 0);
  const auto film = [&](const std::string& to, std::vector<std::string> flags) {
    std::vector<std::string> arguments = {"render", pile, "--film", at + "/" + to, "--height", "270", "--dpi", "60"};
    if (flags[0] != "--width") arguments.insert(arguments.end(), {"--width", "480"});
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return granuscope_command(arguments);
  };
  const auto one = film("one", {"-j", "1"});
  INFO(one.err);
  REQUIRE(one.code == 0);
  REQUIRE(film("two", {"-j", "2"}).code == 0);
  std::size_t frames = 0;
  std::string before;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "one")) {
    const std::string bytes = read_file(entry.path());
    CHECK((bytes == read_file(folder / "two" / entry.path().filename())));
    const Image image = test::read_png(entry.path());
    CHECK(image.width == 480);
    CHECK(image.height == 270);
    CHECK((bytes != before));
    before = bytes;
    ++frames;
  }
  CHECK(frames > 20);
  CHECK(one.err.find("pad=") == std::string::npos);
  const auto odd = film("it's 5%", {"--width", "481", "--step", "10"});
  CHECK_THAT(odd.err, Contains("it'\\''s 5%%/frame-%05d.png' -vf 'pad="));
  CHECK_THAT(one.err, Contains("wrote " + std::to_string(frames) + " frames of"));

  // The frame is in one place from the first to the last, whatever numbers stand beside it: nothing but white above it,
  // and its corner where both have it.
  const Image first = test::read_png(folder / "one/frame-00000.png");
  const Image last = test::read_png(folder / ("one/frame-000" + std::to_string(frames - 1) + ".png"));
  const auto corner = [](const Image& image) {
    for (int y = 0; y < image.height; ++y) {
      int dark = 0;
      for (int x = 0; x < image.width; ++x) dark += image.at(x, y).r < 200 ? 1 : 0;
      if (dark > image.width / 2) return y;
    }
    return -1;
  };
  CHECK(corner(first) > 0);
  CHECK(corner(first) == corner(last));

  const auto shorter = film("one", {"--step", "2"});
  CHECK(shorter.code == 2);
  CHECK_THAT(shorter.err, Contains("this is a frame of another film"));
  const auto shallow = film("none", {"--window=-12,12,0,5"});
  CHECK(shallow.code == 2);
  CHECK_THAT(shallow.err, Contains("nothing is left to slide over"));
  CHECK(film("none", {"--height", "40"}).code == 2);
  CHECK(film("none", {"--step", "0"}).code == 2);
  CHECK(film("none", {"--image", at + "/a.png"}).code == 2);
  CHECK_FALSE(std::filesystem::exists(folder / "none"));
}
