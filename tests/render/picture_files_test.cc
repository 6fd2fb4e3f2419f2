// Pictures as files, and pictures of stored piles.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "kit/file_size_limit.h"
#include "kit/png_image.h"
#include "kit/temporary_folder.h"
#include "render/font.h"
#include "render/gl_context.h"
#include "render/layout.h"
#include "render/painter.h"
#include "render/picture_distance.h"
#include "render/picture_file.h"
#include "render/render_pile.h"
#include "render/scene.h"
#include "render/test_piles.h"
#include "storage/pile_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"

namespace granuscope {
namespace {

using test::TemporaryFolder;
namespace fs = std::filesystem;

const fs::path pictures = fs::path(GRANUSCOPE_SOURCE_DIR) / "tests/data/pictures";

struct Golden {
  std::string name;
  SceneSpec spec;
};

std::vector<Golden> goldens() {
  const auto spec = [](const char* scene, const char* colour_map, int width = 300, double dpi = 72) {
    SceneSpec one;
    one.scene = scene;
    one.colour_map = colour_map;
    one.width_px = width;
    one.dpi = dpi;
    return one;
  };
  std::vector<Golden> all = {{"forces", spec("forces", "grey")},
                             {"forces-of-window", spec("forces", "cividis", 320, 110)},
                             {"forces-far-away", spec("forces", "grey", 130)},
                             {"forces-transparent", spec("forces", "viridis")},
                             {"weight", spec("weight", "grey")},
                             {"friction", spec("friction", "viridis")},
                             {"response", spec("response", "diverging")},
                             {"field", spec("field", "grey")}};
  all[1].spec.window = {{-20, -5, 12, 21}};
  all[3].spec.background = Background::transparent;
  return all;
}

/// Two bands that leave the middle and widen, with a ray and an envelope: exact numbers only.
Field field_of_two_bands() {
  Field field;
  field.key_title = "P(x, z)";
  for (int row = 0; row < 12; ++row) {
    FieldRow cells{2.0 + 3 * row, -24, {}};
    for (int k = 0; k < 48; ++k) {
      const double from_band = std::abs(std::abs(k + 0.5 - 24) - 0.5 * cells.z) / (1 + 0.125 * cells.z);
      cells.values.push_back(0.25 / (1 + from_band * from_band) - 0.03125);
    }
    field.rows.push_back(cells);
  }
  field.lines = {{{{1, 2}, {17.5, 35}}, false}, {{{-1, 2}, {-17.5, 35}}, true}};
  return field;
}

Image drawn(const Golden& golden, const fs::path& image) {
  if (golden.spec.scene == "field") {
    render_scene(build_field_scene(field_of_two_bands(), golden.spec), golden.spec, image);
  } else {
    const bool pair = golden.spec.scene == "response";
    render_pile_file({pictures / "point.h5", pair ? pictures / "uniform.h5" : "", image}, golden.spec);
  }
  return test::read_png(image);
}

/// A folder's name: what the renderer calls itself, without what a name should not have.
std::string key_of(const GlContext& context) {
  std::string key;
  for (const char c : context.renderer() + " " + context.version() + " " + typesetter()) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.';
    if (plain) key += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (!plain && !key.empty() && key.back() != '-') key += '-';
  }
  return key;
}

TEST_CASE("every scene is rendered as it was: the same pixels by the same renderer, nearly the same by any other",
          "[golden]") {
  const std::string here = key_of(*make_gl_context("auto"));
  INFO("drawn by " << here);
  const bool renew = std::getenv("GRANUSCOPE_RENEW_PICTURES") != nullptr;
  if (renew) fs::create_directories(pictures / here);
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(pictures)) {
    if (entry.is_directory()) folders.push_back(entry.path());
  }
  REQUIRE_FALSE(folders.empty());

  const test::TemporaryFolder scratch;
  for (const Golden& golden : goldens()) {
    const Image now = drawn(golden, scratch / "now.png");
    for (const fs::path& folder : folders) {
      const fs::path old = folder / (golden.name + ".png");
      INFO(old.string());
      if (renew && folder.filename() == here) {
        fs::copy_file(scratch / "now.png", old, fs::copy_options::overwrite_existing);
      }
      const Image before = test::read_png(old);
      bool same = before.width == now.width && before.height == now.height;
      REQUIRE(same);
      const PictureDistance apart = distance(before, now);
      INFO("root mean square " << apart.root_mean_square << ", of blocks " << apart.blocks << ", mean " << apart.mean
                               << ", largest " << apart.largest);
      if (folder.filename() == here) {
        same = before.rgba == now.rgba;
      } else {
        same = apart.root_mean_square <= renderer_distance.root_mean_square &&
               apart.blocks <= renderer_distance.blocks && std::abs(apart.mean) <= renderer_distance.mean &&
               apart.largest <= renderer_distance.largest;
      }
      if (!same) {
        fs::copy_file(scratch / "now.png", folder / (golden.name + ".new.png"), fs::copy_options::overwrite_existing);
      }
      CHECK(same);
    }
  }
}

TEST_CASE("what is allowed between renderers would not let another scale, a shift or a lost contact pass", "[golden]") {
  const Golden golden = goldens().front();
  const test::TemporaryFolder scratch;
  const Image whole = drawn(golden, scratch / "whole.png");

  Golden scaled = golden;
  scaled.spec.range = {{0, 1}};
  CHECK(distance(whole, drawn(scaled, scratch / "scaled.png")).root_mean_square > renderer_distance.root_mean_square);

  Image shifted = whole;
  std::rotate(shifted.rgba.begin(), shifted.rgba.end() - 4, shifted.rgba.end());  // by one pixel
  CHECK(distance(whole, shifted).root_mean_square > renderer_distance.root_mean_square);

  // The darkest pixel of the middle, which is part of a strong contact, and its neighbours turned to page.
  Image lost = whole;
  int at_x = 0, at_y = 0, darkest = 255;
  for (int y = whole.height / 4; y < whole.height / 2; ++y) {
    for (int x = whole.width / 4; x < whole.width / 2; ++x) {
      const int grey = whole.rgba[whole.offset(x, y)];
      if (grey < darkest) darkest = grey, at_x = x, at_y = y;
    }
  }
  for (int y = at_y - 1; y <= at_y + 1; ++y) {
    for (int x = at_x - 1; x <= at_x + 1; ++x)
      std::fill_n(lost.rgba.begin() + static_cast<long>(lost.offset(x, y)), 3, 255);
  }
  CHECK(distance(whole, lost).largest > renderer_distance.largest);
}

TEST_CASE("a pile read band by band gives the picture of the pile in memory, in every scene, in windows and out") {
  const TemporaryFolder folder;
  // Several bands high, so that bands end within the picture and within rows of tiles.
  Pile pile = irregular_pile(48, 2 * band_layers + 77), other = frictionless_pile(48, 2 * band_layers + 77);
  other.law = pile.law;
  pile.mu = other.mu = 0.7;
  write_pile(folder / "pile.h5", pile);
  write_pile(folder / "other.h5", other);
  const auto context = make_gl_context("auto");
  for (const std::string scene : {"forces", "weight", "friction", "response"}) {
    for (const auto& window : std::vector<std::optional<std::array<double, 4>>>{
             std::nullopt, {{-9.5, 12, band_layers - 4.0, 2 * band_layers + 30.0}}}) {
      for (const bool skip : {true, false}) {
        for (const int width : {140, 90}) {  // with OpenGL; level of detail, if skipping
          CAPTURE(scene, window.has_value(), skip, width);
          SceneSpec spec;
          spec.scene = scene;
          spec.window = window;
          spec.width_px = width;
          spec.dpi = width == 90 ? 30 : 50;
          spec.skip_invisible = skip;
          spec.colour_map.clear();
          const bool pair = scene == "response";
          const auto choose = [&spec](const Lattice& lattice) { return range_needed(lattice, spec); };
          const PileView whole = view_of(pile), minus = view_of(other);
          const Scene in_memory = build_scene(whole, pair ? &minus : nullptr, spec);
          const Scene in_bands = build_scene(open_pile_layers(folder / "pile.h5", choose, 0),
                                             pair ? open_pile_layers(folder / "other.h5", choose, 0) : nullptr, spec);
          CHECK((in_bands.detail != nullptr) == (skip && width == 90 && !window));
          CHECK(in_bands.counts.drawn == in_memory.counts.drawn);
          CHECK(in_bands.counts.too_faint == in_memory.counts.too_faint);
          CHECK(in_bands.counts.aggregated == in_memory.counts.aggregated);
          CHECK(in_bands.values.high == in_memory.values.high);
          CHECK((paint(in_bands, spec, *context).rgba == paint(in_memory, spec, *context).rgba));
        }
      }
    }
  }
}

TEST_CASE("reading is timed as reading, wherever it happens") {
  const TemporaryFolder folder;
  write_pile(folder / "a.h5", irregular_pile(500, 500));
  SceneSpec spec = small_spec();
  const auto layers = open_pile_layers(folder / "a.h5", whole_range, 0);
  CHECK(layers->seconds_reading() == 0);
  layers->hold(0, 1);
  const double once = layers->seconds_reading();
  CHECK(once > 0);
  layers->hold(100, 101);  // has been brought
  CHECK(layers->seconds_reading() == once);
  layers->hold(400, 401);
  CHECK(layers->seconds_reading() > once);
  for (const char* name : {"a.png", "b.svg"}) {
    if (name[0] == 'b') spec.window = {{-20, 20, 0, 20}};
    const SceneStatistics::Seconds seconds = render_pile_file({folder / "a.h5", {}, folder / name}, spec).seconds;
    CHECK(seconds.read > 0);
    CHECK(seconds.build > 0);
    CHECK(seconds.draw >= 0);
    CHECK(seconds.encode > 0);
  }
}

/// The colour type of a PNG of these pixels that stores no channel it could do without.
int colour_type_needed(const Image& image) {
  int type = PNG_COLOR_TYPE_GRAY;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    if (image.rgba[i + 3] != 255) return PNG_COLOR_TYPE_RGB_ALPHA;
    if (image.rgba[i] != image.rgba[i + 1] || image.rgba[i] != image.rgba[i + 2]) type = PNG_COLOR_TYPE_RGB;
  }
  return type;
}

TEST_CASE("a picture rendered to a file row by row holds the pixels and channels of one rendered at once") {
  const TemporaryFolder folder;
  const Pile pile = irregular_pile(30, 30), other = frictionless_pile(30, 30);
  const auto context = make_gl_context("auto");
  const PileView whole = view_of(pile);
  for (const std::string map : {"grey", "viridis"}) {
    for (const Background background : {Background::page, Background::transparent}) {
      SceneSpec spec;
      spec.width_px = 600;
      spec.dpi = 150;
      spec.colour_map = map;
      spec.background = background;
      render_pile(pile, nullptr, spec, folder / "rows.png");
      const Image at_once = paint(build_scene(whole, nullptr, spec), spec, *context);
      CHECK((test::read_png(folder / "rows.png").rgba == at_once.rgba));
      CHECK(test::png_chunks(folder / "rows.png", "IHDR")[0][9] == colour_type_needed(at_once));
    }
  }
}

TEST_CASE("a force that is not finite is met before anything is painted, whatever band it stands in") {
  const TemporaryFolder folder;
  Pile pile = irregular_pile(8, 2 * band_layers);
  for (const int layer : {3, band_layers + 5, 2 * band_layers - 1}) {
    Pile damaged = pile;
    damaged.V_L[damaged.lattice.index(layer, 5)] = std::numeric_limits<double>::quiet_NaN();
    write_pile(folder / "damaged.h5", damaged);
    SceneSpec spec;
    spec.width_px = 300;
    spec.dpi = 100;
    const auto choose = [&spec](const Lattice& lattice) { return range_needed(lattice, spec); };
    const std::string place = "[" + std::to_string(layer) + ", 5]";
    CHECK_THROWS_WITH(build_scene(open_pile_layers(folder / "damaged.h5", choose, 0), nullptr, spec),
                      Catch::Contains("V_L") && Catch::Contains(place));
    CHECK_THROWS_AS(render_pile_file({folder / "damaged.h5", {}, folder / "a.png"}, spec), InputError);
    CHECK(!std::filesystem::exists(folder / "a.png"));
  }
}

#if !defined(__SANITIZE_ADDRESS__)  // which takes memory of its own
/// Bytes that a process of its own had at most while doing this.
std::size_t peak_of(const std::function<void()>& work) {
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    try {
      work();
      ::_exit(0);
    } catch (const std::exception&) {
      ::_exit(1);
    }
  }
  int status = 0;
  rusage used{};
  REQUIRE(::wait4(child, &status, 0, &used) == child);
  REQUIRE(WIFEXITED(status));
  REQUIRE(WEXITSTATUS(status) == 0);
  return static_cast<std::size_t>(used.ru_maxrss) * 1024;
}

TEST_CASE("memory is bounded by bands, not by the pile or the height of the picture") {
  const TemporaryFolder folder;
  constexpr int columns = 128, layers = 40000;
  constexpr std::size_t pile_bytes = std::size_t{4} * 8 * columns * layers;  // 164 MB
  write_pile(folder / "high.h5", irregular_pile(columns, layers));
  SceneSpec spec;
  spec.width_px = 90;
  spec.dpi = 30;
  const std::size_t nothing = peak_of([] {});
  const std::size_t detail = peak_of([&] { render_pile_file({folder / "high.h5", {}, folder / "a.png"}, spec); });
  CHECK(detail - nothing < pile_bytes * 2 / 3);
  // All of one colour, so that it takes no time: 4000 x 26000 pixels, in memory 416 MB.
  spec.window = {{-64, 64, 0, 950}};
  spec.range = {{1e8, 1e9}};
  spec.width_px = 4000;
  const std::size_t large = peak_of([&] {
    const SceneStatistics drawn = render_pile_file({folder / "high.h5", {}, folder / "b.png"}, spec);
    if (drawn.counts.pixels < 90000000) throw std::length_error("a smaller picture than the test is about");
  });
  CHECK(large - nothing < std::size_t{100} << 20);
}
#endif

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
