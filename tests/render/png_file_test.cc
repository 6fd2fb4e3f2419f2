#include "render/png_file.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "kit/file_size_limit.h"
#include "kit/png_image.h"
#include "kit/temporary_folder.h"
#include "render/gl_context.h"
#include "render/painter.h"
#include "render/render_pile.h"
#include "render/test_piles.h"
#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"

namespace granuscope {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

Image small_image() {
  Image image(5, 3, {10, 20, 30});
  image.rgba[image.offset(4, 2)] = 200;
  return image;
}

void write_png(const fs::path& path, const Image& image, double dpi, const ImageMetadata& metadata = {},
               Channels channels = Channels::rgb) {
  PngWriter writer(path, {image.width, image.height, channels, dpi}, metadata);
  writer.add(image);
  writer.commit();
}

TEST_CASE("an image carries its resolution, colour space and texts, and no time") {
  const TemporaryFolder folder;
  write_png(folder / "a.png", small_image(), 300, {{"Scene", "forces"}, {"Software", "granuscope \u03bc = 0.1"}});
  const auto chunks = [&](const char* type) { return test::png_chunks(folder / "a.png", type); };
  REQUIRE(chunks("pHYs").size() == 1);
  const std::string resolution = chunks("pHYs")[0];
  CHECK(test::big_endian(resolution, 0) == 11811);  // 300 / 0.0254, rounded
  CHECK(test::big_endian(resolution, 4) == 11811);
  CHECK(resolution[8] == 1);  // the metre
  CHECK(chunks("sRGB").size() == 1);
  CHECK(chunks("tIME").empty());
  REQUIRE(chunks("iTXt").size() == 2);
  CHECK(chunks("iTXt")[0] == std::string("Scene\0\0\0\0\0forces", 16));
  CHECK_THAT(chunks("iTXt")[1], Catch::Contains("granuscope \u03bc = 0.1"));
  CHECK(chunks("IEND").size() == 1);
  CHECK(chunks("IHDR")[0][9] == 2);  // RGB
}

TEST_CASE("what is written is read back") {
  const TemporaryFolder folder;
  Image image = small_image();
  image.rgba[3] = 7;  // one translucent pixel
  write_png(folder / "a.png", image, 100, {}, Channels::rgba);
  const Image back = test::read_png(folder / "a.png");
  CHECK(back.width == 5);
  CHECK(back.height == 3);
  CHECK(back.rgba == image.rgba);
  CHECK(test::png_chunks(folder / "a.png", "IHDR")[0][9] == 6);  // RGBA
}

TEST_CASE("a PNG that cannot be written leaves nothing behind") {
  const TemporaryFolder folder;
  CHECK_THROWS_AS(write_png(folder / "no/such/folder.png", small_image(), 100), EnvironmentError);
  CHECK_THROWS_AS(write_png(folder / "a.png", Image(), 100), InputError);
  CHECK_THROWS_AS(write_png(folder / "a.png", small_image(), 0), InputError);
  CHECK_THROWS_AS(write_png(folder / "a.png", small_image(), 100, {{"", "text"}}), InputError);
  CHECK_THROWS_AS(write_png(folder / "a.png", small_image(), 100, {{std::string(80, 'k'), "text"}}), InputError);
  CHECK(folder.contents().size() == 0);
}

TEST_CASE("a disk that fills up while writing leaves nothing behind and says so") {
  const TemporaryFolder folder;
  Image image(200, 200, {});
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    if (i % 4 != 3) image.rgba[i] = static_cast<std::uint8_t>(i * i * 2654435761U >> 16);  // compresses badly
  }
  // A limit on the size of files stands in for the full disk: writing fails at the same place.
  std::string message;
  {
    const test::FileSizeLimit full(4096);
    try {
      write_png(folder / "a.png", image, 100);
    } catch (const EnvironmentError& error) {
      message = error.what();
    }
  }
  CHECK_THAT(message, Catch::Contains("cannot write") && Catch::Contains("a.png"));
  CHECK(folder.contents().size() == 0);
}

TEST_CASE("a request to stop ends any picture, and leaves no file") {
  const TemporaryFolder folder;
  const Pile pile = frictionless_pile(60, 40);
  const SceneSpec spec = small_spec();
  const Scene scene = scene_of(pile, spec);
  SceneSpec small = spec;
  small.width_px = 120;
  small.dpi = 72;
  const Scene detail = scene_of(pile, small);
  REQUIRE(detail.detail);
  const auto context = make_gl_context("auto");
  request_interruption(true);
  CHECK_THROWS_AS(scene_of(pile, spec), Interrupted);
  CHECK_THROWS_AS(paint(scene, spec, *context), Interrupted);
  CHECK_THROWS_AS(paint(detail, small, *context), Interrupted);
  CHECK_THROWS_AS(write_png(folder / "a.png", small_image(), 100), Interrupted);
  request_interruption(false);
  CHECK(folder.contents().size() == 0);
}

TEST_CASE("a pile is rendered to a file, twice the same bytes, with its numbers") {
  const TemporaryFolder folder;
  const Pile pile = frictionless_pile(12, 10);
  SceneSpec spec = small_spec();
  const SceneStatistics statistics = render_pile(pile, nullptr, spec, folder / "a.png", {{"Software", "granuscope"}});
  render_pile(pile, nullptr, spec, folder / "b.png", {{"Software", "granuscope"}});
  CHECK((read_file(folder / "a.png") == read_file(folder / "b.png")));
  CHECK(folder.contents().size() == 2);
  const Image image = test::read_png(folder / "a.png");
  CHECK(image.width == 400);
  CHECK(statistics.counts.pixels == 400U * static_cast<unsigned>(image.height));
  CHECK(statistics.counts.drawn == 240);
  CHECK(statistics.seconds.draw > 0);
  CHECK(test::png_text(folder / "a.png", "Elements") == "240 drawn, 0 outside, 0 too faint, 0 aggregated");
  spec.window = {{3, 3, 0, 0}};
  CHECK_THROWS_AS(render_pile(pile, nullptr, spec, folder / "c.png"), InputError);
  CHECK(folder.contents().size() == 2);
}

}  // namespace
}  // namespace granuscope
