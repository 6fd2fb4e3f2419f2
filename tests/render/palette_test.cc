#include "render/palette.h"

#include <catch2/catch.hpp>

#include "render/colour_scale.h"
#include "support/error.h"

namespace granuscope {
namespace {

double lightness(Rgb colour) { return 0.2126 * colour.r + 0.7152 * colour.g + 0.0722 * colour.b; }

TEST_CASE("a palette reads names and colours, and passes over comments") {
  const Palette palette("# a comment\n\n page = #ffffff\r\nmap=#000000 #0a0B0c\t#FFFFFF", "text");
  CHECK(palette.colour("page") == Rgb{255, 255, 255});
  CHECK(palette.colours("map") == std::vector<Rgb>{{0, 0, 0}, {10, 11, 12}, {255, 255, 255}});
  CHECK(to_hex(palette.colours("map")[1]) == "#0a0b0c");
  CHECK_THROWS_WITH(palette.colours("nap"), Catch::Contains("nap") && Catch::Contains("map, page"));
  CHECK_THROWS_WITH(palette.colour("map"), Catch::Contains("3 colours"));
}

TEST_CASE("a palette refuses lines it cannot read, with their number") {
  const auto message = [](const char* text) {
    try {
      const Palette palette(text, "file");
      return std::string("accepted");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
  };
  CHECK_THAT(message("a = #000000\nb #000000"), Catch::Contains("file:2: no '='"));
  CHECK_THAT(message("= #000000"), Catch::Contains("file:1: no name"));
  CHECK_THAT(message("a ="), Catch::Contains("'a' has no colour"));
  CHECK_THAT(message("a = #12345"), Catch::Contains("'#12345' is not a colour"));
  CHECK_THAT(message("a = #12345g"), Catch::Contains("'#12345g' is not a colour"));
  CHECK_THAT(message("a = #-12345"), Catch::Contains("is not a colour"));
  CHECK_THAT(message("a = 1234567"), Catch::Contains("is not a colour"));
  CHECK_THAT(message("a = #000000\na = #000000"), Catch::Contains("file:2: 'a' is given twice"));
}

TEST_CASE("the palette of the program has every map and category") {
  const Palette& palette = Palette::builtin();
  for (const char* map : {"grey", "viridis", "cividis", "diverging"}) CHECK(palette.colours(map).size() >= 2);
  CHECK(palette.colours("okabe-ito").size() == 8);
  CHECK(palette.colours("diverging").size() % 2 == 1);
  CHECK(palette.colours("diverging")[palette.colours("diverging").size() / 2] == palette.colour("page"));
}

TEST_CASE("darkness grows with the force from the page on, for every map") {
  for (const char* map : {"grey", "viridis", "cividis"}) {
    INFO(map);
    const ColourScale scale(Palette::builtin(), map);
    CHECK(scale.at(0) == scale.page());
    CHECK(scale.at(-1) == scale.page());
    CHECK(scale.at(2) == scale.at(1));
    bool monotone = true;
    for (int k = 1; k <= 1000; ++k) {
      // Rounding to 8 bits may lighten one channel by one step: at most its weight.
      monotone = monotone && lightness(scale.at(k / 1000.0)) <= lightness(scale.at((k - 1) / 1000.0)) + 0.72;
    }
    CHECK(monotone);
    CHECK(lightness(scale.at(1)) < 0.2 * lightness(scale.page()));
  }
  CHECK_THROWS_WITH(ColourScale(Palette::builtin(), "diverging"), Catch::Contains("grey, viridis or cividis"));
}

TEST_CASE("a bar thinner than a sample is drawn one sample wide and thinned out by as much") {
  const ColourScale scale(Palette::builtin(), "grey");
  const Stroke wide = stroke_of(scale, 0.5, 0.25, 8);
  CHECK(wide.width_px == 2.0);
  CHECK(wide.colour == scale.at(0.5));
  const Stroke thin = stroke_of(scale, 1, 0.01, 10);  // 0.1 px = 0.4 samples of black
  CHECK(thin.width_px == 0.25);
  CHECK(thin.colour == Rgb{153, 153, 153});  // 255 (1 - 0.4)
  CHECK(stroke_of(scale, 1, 0.00004, 10).colour == scale.page());
}

}  // namespace
}  // namespace granuscope
