#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "kit/png_image.h"
#include "kit/temporary_folder.h"
#include "render/layout.h"
#include "render/painter.h"
#include "render/render_pile.h"
#include "render/test_piles.h"
#include "storage/pile_file.h"
#include "support/error.h"
#include "support/files.h"

namespace granuscope {
namespace {

using test::TemporaryFolder;

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

}  // namespace
}  // namespace granuscope
