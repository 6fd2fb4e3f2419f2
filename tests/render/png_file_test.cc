#include "render/png_file.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "kit/file_size_limit.h"
#include "kit/temporary_folder.h"
#include "render/gl_context.h"
#include "render/painter.h"
#include "render/render_pile.h"
#include "render/test_piles.h"
#include "support/atomic_file.h"
#include "support/error.h"
#include "support/interruption.h"

namespace granuscope {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

struct Chunk {
  std::string type, data;
};

std::uint32_t big_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
  return value;
}

std::vector<Chunk> chunks_of(const fs::path& path) {
  const std::string bytes = read_file(path);
  std::vector<Chunk> chunks;
  for (std::size_t at = 8; at < bytes.size();) {
    const std::size_t length = big_endian(bytes, at);
    chunks.push_back({bytes.substr(at + 4, 4), bytes.substr(at + 8, length)});
    at += length + 12;
  }
  return chunks;
}

std::vector<Chunk> of_type(const std::vector<Chunk>& chunks, const std::string& type) {
  std::vector<Chunk> found;
  for (const Chunk& chunk : chunks) {
    if (chunk.type == type) found.push_back(chunk);
  }
  return found;
}

Image small_image() {
  Image image(5, 3, {10, 20, 30});
  image.rgba[image.offset(4, 2)] = 200;
  image.metadata = {{"Scene", "forces"}};
  return image;
}

TEST_CASE("an image carries its resolution, colour space and texts, and no time") {
  const TemporaryFolder folder;
  write_png(folder / "a.png", small_image(), 300, {{"Software", "granuscope \u03bc = 0.1"}});
  const auto chunks = chunks_of(folder / "a.png");
  REQUIRE(of_type(chunks, "pHYs").size() == 1);
  const std::string resolution = of_type(chunks, "pHYs")[0].data;
  CHECK(big_endian(resolution, 0) == 11811);  // 300 / 0.0254, rounded
  CHECK(big_endian(resolution, 4) == 11811);
  CHECK(resolution[8] == 1);  // the metre
  CHECK(of_type(chunks, "sRGB").size() == 1);
  CHECK(of_type(chunks, "tIME").empty());
  REQUIRE(of_type(chunks, "iTXt").size() == 2);
  CHECK(of_type(chunks, "iTXt")[0].data == std::string("Scene\0\0\0\0\0forces", 16));
  CHECK_THAT(of_type(chunks, "iTXt")[1].data, Catch::Contains("granuscope \u03bc = 0.1"));
  CHECK(chunks.back().type == "IEND");
  CHECK(of_type(chunks, "IHDR")[0].data[9] == 2);  // opaque: RGB
}

TEST_CASE("what is written is read back") {
  const TemporaryFolder folder;
  Image image = small_image();
  image.rgba[3] = 7;  // one translucent pixel
  write_png(folder / "a.png", image, 100);
  const Image back = read_png(folder / "a.png");
  CHECK(back.width == 5);
  CHECK(back.height == 3);
  CHECK(back.rgba == image.rgba);
  CHECK(back.metadata == image.metadata);
  CHECK(of_type(chunks_of(folder / "a.png"), "IHDR")[0].data[9] == 6);  // RGBA
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

TEST_CASE("a file that is not a whole PNG is refused") {
  const TemporaryFolder folder;
  CHECK_THROWS_AS(read_png(folder / "none.png"), InputError);
  std::ofstream(folder / "text.png") << "not a picture";
  CHECK_THROWS_WITH(read_png(folder / "text.png"), Catch::Contains("not a whole PNG"));
  write_png(folder / "a.png", small_image(), 100);
  const std::string whole = read_file(folder / "a.png");
  std::ofstream(folder / "half.png", std::ios::binary) << whole.substr(0, whole.size() - 20);
  CHECK_THROWS_AS(read_png(folder / "half.png"), InputError);
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

TEST_CASE("a pile is drawn to a file, twice the same bytes, with its numbers") {
  const TemporaryFolder folder;
  const Pile pile = frictionless_pile(12, 10);
  SceneSpec spec = small_spec();
  const SceneStatistics statistics = render_pile(pile, spec, folder / "a.png", {{"Software", "granuscope"}});
  render_pile(pile, spec, folder / "b.png", {{"Software", "granuscope"}});
  CHECK((read_file(folder / "a.png") == read_file(folder / "b.png")));
  CHECK(folder.contents().size() == 2);
  const Image image = read_png(folder / "a.png");
  CHECK(image.width == 400);
  CHECK(statistics.counts.pixels == 400U * static_cast<unsigned>(image.height));
  CHECK(statistics.counts.drawn == 240);
  CHECK(statistics.seconds.draw > 0);
  std::string contacts;
  for (const auto& [keyword, text] : image.metadata) contacts += keyword == "Elements" ? text : "";
  CHECK(contacts == "240 drawn, 0 outside, 0 too faint, 0 aggregated");
  spec.window = {{3, 3, 0, 0}};
  CHECK_THROWS_AS(render_pile(pile, spec, folder / "c.png"), InputError);
  CHECK(folder.contents().size() == 2);
}

}  // namespace
}  // namespace granuscope
