#include "render/palette.h"

#include <catch2/catch.hpp>
#include <limits>

#include "render/sample_grid.h"
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

TEST_CASE("a bar thinner than a sample is painted one sample wide and thinned out by as much") {
  const ColourScale scale(Palette::builtin(), "grey");
  const ValueScale values;
  // At 8 samples to a diameter a bar of level 51, 0.1 diameters wide, covers 0.8 of a sample; one of 64 is wider.
  const LevelTable table = make_level_table(scale, values, Glyph::force_bar, 8);
  CHECK(table.colour[51] == Rgb{214, 214, 214});  // 255 (1 - 0.8 * 0.2) = 214.2
  CHECK(table.full_colour[51] == Rgb{204, 204, 204});
  CHECK(table.ink[51] == 204);
  CHECK(table.colour[64] == Rgb{191, 191, 191});
  CHECK(table.ink[64] == 255);
  // Level k: 255 (k/255) (8 k/510) rounds to less than one grey up to k = 5 (0.39) and to more from 6 on (0.56).
  CHECK_FALSE(table.visible[5]);
  CHECK(table.visible[6]);
  // Beads do not get thinner: every level is seen.
  CHECK(make_level_table(scale, values, Glyph::bead, 8).visible[1]);
}

TEST_CASE("a scale of both signs counts from its middle, the stronger level the higher") {
  const ValueScale scale{-2, 2, Sign::both, 255};
  CHECK(scale.level(0) == 0);
  CHECK(scale.level(2) == 254);
  CHECK(scale.level(-2) == 255);
  CHECK(scale.level(-9) == 255);
  CHECK(scale.level(1.5) > scale.level(-1.4));
  CHECK(scale.level(-1.5) > scale.level(1.4));
  CHECK(scale.strength(254) == 1);
  CHECK(scale.strength(255) == -1);
  CHECK(scale.strength(scale.level(-1)) == Approx(-0.5).margin(1.0 / 254));
  const ColourScale colours(Palette::builtin(), "diverging", Sign::both);
  CHECK(colours.at(0) == colours.page());
  CHECK(colours.at(1).r > colours.at(1).b);
  CHECK(colours.at(-1).b > colours.at(-1).r);
  CHECK_THROWS_WITH(ColourScale(Palette::builtin(), "grey", Sign::both), Catch::Contains("choose diverging"));
}

TEST_CASE("a histogram of magnitudes knows its quantiles to 2^-9, and zeros") {
  MagnitudeHistogram histogram;
  CHECK(histogram.quantile(0.5) == 0);
  for (int k = 1; k <= 1000; ++k) histogram.add(k * 1e-3);
  CHECK(histogram.quantile(0.97) == Approx(0.97).epsilon(1.0 / 256));
  CHECK(histogram.quantile(0.01) == Approx(0.01).epsilon(1.0 / 256));
  for (int k = 0; k < 9000; ++k) histogram.add(0);
  CHECK(histogram.quantile(0.5) == 0);
}

TEST_CASE("a range of the scale is refused if it cannot be one") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(checked_range({1, 1}, Sign::one), Catch::Contains("empty"));
  CHECK_THROWS_WITH(checked_range({2, 1}, Sign::one), Catch::Contains("empty"));
  CHECK_THROWS_WITH(checked_range({nan, 1}, Sign::one), Catch::Contains("not made of numbers"));
  CHECK_THROWS_WITH(checked_range({-1e308, 1e308}, Sign::both), Catch::Contains("not made of numbers"));
  CHECK_THROWS_WITH(checked_range({-1, 2}, Sign::both), Catch::Contains("symmetric"));
  CHECK(checked_range({0.5, 2}, Sign::one)[0] == 0.5);
}

}  // namespace
}  // namespace granuscope
