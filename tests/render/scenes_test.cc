// Scenes, their layout and their palettes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "render/layout.h"
#include "render/palette.h"
#include "render/sample_grid.h"
#include "render/scene.h"
#include "render/test_piles.h"
#include "support/error.h"

namespace granuscope {

namespace {

Field small_field() {
  Field field;
  field.key_title = "P(x, z)";
  for (int row = 0; row < 4; ++row) {
    FieldRow cells{10 + 3.0 * row, -5.0 + 0.5 * (row % 2), {}};
    for (int k = 0; k < 10; ++k) cells.values.push_back(0.1 * k - 0.2);
    field.rows.push_back(cells);
  }
  return field;
}

TEST_CASE("a field's rows meet half way, and what is negative is page") {
  const Scene scene = build_field_scene(small_field(), small_spec());
  CHECK(scene.extent.x0 == -5);
  CHECK(scene.extent.x1 == 5.5);
  CHECK(scene.extent.z1 == 20.5);
  CHECK(scene.counts.drawn == 4 * 7);  // 0.1 to 0.7
  CHECK(scene.counts.too_faint == 4 * 3);
  const std::vector<Element> cells = elements_of(scene);
  REQUIRE(cells.size() == 28);
  CHECK(cells.front().z0 == 8.5);
  CHECK(cells.front().z1 == 11.5);
  CHECK(cells.back().z1 == 20.5);
  CHECK(cells.back().x1 - cells.back().x0 == 1);
  CHECK(scene.values.high == Approx(0.8));
  CHECK(std::all_of(cells.begin(), cells.end(), [](const Element& cell) { return cell.level <= levels_below_lines; }));
}

TEST_CASE("a gap between rows is page, not one row painted over all of it") {
  Field field = small_field();
  FieldRow far = field.rows.back();
  far.z = 50;  // the others are 3 apart
  field.rows.push_back(far);
  const std::vector<Element> cells = elements_of(build_field_scene(field, small_spec()));
  REQUIRE(cells.size() == 35);
  CHECK(cells[27].z1 == 20.5);
  CHECK(cells.back().z0 == 48.5);
  CHECK(cells.back().z1 == 51.5);
}

TEST_CASE("lines lie over the field, dashes with gaps, along their whole length") {
  Field field = small_field();
  field.lines = {{{{0, 9}, {3, 18}}, false}, {{{0, 9}, {-3, 18}}, true}};
  const Scene scene = build_field_scene(field, small_spec());
  double solid = 0, dashed = 0;
  for (const Element& element : elements_of(scene)) {
    const double length = std::hypot(element.x1 - element.x0, element.z1 - element.z0);
    if (element.level == solid_line_level) solid += length;
    if (element.level == dashed_line_level) dashed += length;
  }
  const double length = std::hypot(3.0, 9.0);
  CHECK(solid == Approx(length));
  CHECK(dashed < 0.75 * length);  // 5 points of 8
  CHECK(dashed > 0.5 * length);
}

TEST_CASE("a field that cannot be rendered is refused") {
  CHECK_THROWS_AS(build_field_scene({}, small_spec()), InputError);
  Field field = small_field();
  field.rows[2].values[3] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(build_field_scene(field, small_spec()), Catch::Contains("not finite"));
  field = small_field();
  std::swap(field.rows[0], field.rows[1]);
  CHECK_THROWS_WITH(build_field_scene(field, small_spec()), Catch::Contains("order"));
  SceneSpec spec = small_spec();
  spec.window = {{100, 120, 0, 3}};
  CHECK_THROWS_WITH(build_field_scene(small_field(), spec), Catch::Contains("no cell"));
  spec.window = {{3, 2, 0, 3}};
  CHECK_THROWS_WITH(build_field_scene(small_field(), spec), Catch::Contains("empty"));
}

TEST_CASE("every contact of a small pile is painted, half of the lowest ones, and twice across the seam") {
  const Pile pile = irregular_pile(4, 3);
  const Scene scene = scene_of(pile, small_spec());
  CHECK(scene.counts.drawn == 24);
  CHECK(scene.counts.outside == 0);
  CHECK(scene.counts.too_faint == 0);
  CHECK(scene.extent.x0 == -2);
  CHECK(scene.extent.x1 == 2);
  CHECK(scene.extent.z0 == 0);
  CHECK(scene.extent.z1 == Approx(1 + std::sqrt(3.0)));
  // By hand: the window is [-2, 2], a bar reaches 1/4 beyond its ends. Even layers have beads at -2, -1, 0, 1 and odd
  // ones at -1.5 ... 1.5. In layer 0, [-2.5, -2] and [-2, -1.5] (bead -2) come back at 1.5 and 2 as [1.5, 2] and, by
  // its quarter, [2, 2.5]; [1, 1.5] does not reach -2. In layer 1, [1.5, 2] reaches [-2.5, -2] and [-2, -1.5] reaches
  // [2, 2.5]. In layer 2, of half the length, [-2.25, -2] and [-2, -1.75].
  CHECK(elements_of(scene).size() == 24 + 2 + 2 + 2);
  for (const Element& bar : elements_of(scene)) {
    const bool lowest = bar.z0 > 2;
    CHECK(std::abs(bar.x1 - bar.x0) == (lowest ? 0.25 : 0.5));
    CHECK(bar.z1 - bar.z0 == Approx((lowest ? 0.25 : 0.5) * std::sqrt(3.0)));
    CHECK(bar.width == Approx(widest_bar * bar.level / 255));
  }
}

TEST_CASE("a contact goes from its bead to the neighbour on its side, with the magnitude of its force") {
  Pile pile(Lattice({6, 4}));
  const std::size_t k = pile.lattice.index(1, 4);  // odd layer: x = 4.5 - 3 = 1.5
  pile.V_R[k] = 0.6;
  pile.H_R[k] = 0.8;
  const Scene scene = scene_of(pile, small_spec());
  REQUIRE(elements_of(scene).size() == 1);
  CHECK(scene.counts.drawn == 1);
  CHECK(scene.counts.too_faint == 47);
  CHECK(elements_of(scene)[0].x0 == 1.5);
  CHECK(elements_of(scene)[0].x1 == 2.0);
  CHECK(elements_of(scene)[0].z0 == Lattice::depth(1));
  CHECK(elements_of(scene)[0].z1 == Approx(Lattice::depth(2)));
  CHECK(scene.value_max == Approx(1));
  CHECK(elements_of(scene)[0].level == 255);  // one contact of 48 is beyond the quantile that the scale covers
  CHECK(scene.values.high < 1);
}

TEST_CASE("contacts outside the window are counted, not painted") {
  const Pile pile = irregular_pile(4, 3);
  SceneSpec spec = small_spec();
  spec.window = {{-1, 1, 0, 0}};
  const Scene scene = scene_of(pile, spec);
  // Layer 0 only (layer 1 starts 0.116 below the reach of the window): both contacts of the beads at -1, 0 and 1. Those
  // of the bead at -2 end 1/2 beside the window on either side of the seam.
  CHECK(scene.counts.drawn == 6);
  CHECK(scene.counts.outside == 18);
  CHECK(elements_of(scene).size() == 6);
  spec.skip_invisible = false;
  const Scene all = scene_of(pile, spec);
  CHECK(all.counts.drawn == 24);
  CHECK(all.counts.outside == 0);
  CHECK(all.values.high == scene.values.high);
  CHECK(all.value_max == scene.value_max);
}

TEST_CASE("layers far from the window count as outside") {
  const Pile pile = irregular_pile(8, 40);
  SceneSpec spec = small_spec();
  spec.window = {{-2, 2, 20, 22}};
  const SceneCounts counts = scene_of(pile, spec).counts;
  CHECK(counts.drawn + counts.outside + counts.too_faint == 2 * 8 * 40);
  CHECK(counts.drawn > 0);
}

TEST_CASE("a contact is too faint exactly when its colour rounds to the page's") {
  Pile pile = irregular_pile(4, 3);
  SceneSpec spec = small_spec();
  spec.width_px = 1600;  // bars much wider than a sample: the colour alone decides
  const double scale_top = scene_of(pile, spec).values.high;
  const double threshold = scale_top / 510;  // black times half of 1/255
  pile.V_R[5] = threshold * 1.01;
  pile.H_R[5] = 0;
  pile.V_L[6] = threshold * 0.99;
  pile.H_L[6] = 0;
  pile.V_R[7] = 0;
  pile.H_R[7] = 0;
  const Scene scene = scene_of(pile, spec);
  CHECK(scene.values.high == scale_top);
  // A bar of level 1 is wider than a sample here.
  REQUIRE(widest_bar / 255 * scene.pixels_per_diameter * samples_per_axis(scene.pixels_per_diameter) > 1);
  CHECK(scene.counts.too_faint == 2);
  CHECK(scene.counts.drawn + scene.counts.too_faint == 24);
}

TEST_CASE("the force scale covers the chains of an overload however many other contacts there are") {
  const Scene scene = scene_of(frictionless_pile(100, 100), small_spec());
  CHECK(scene.value_max == Approx(2 / std::sqrt(3.0)));
  CHECK(scene.values.high == Approx(1.2));
  REQUIRE(scene.overload);
  CHECK(scene.overload->x == 0);
  CHECK(scene.overload->load == 2);
}

TEST_CASE("the overload is painted only where there is one, in the window") {
  CHECK_FALSE(scene_of(frictionless_pile(10, 10, 1), small_spec()).overload);
  SceneSpec spec = small_spec();
  spec.window = {{-4, 4, 1, 9}};
  CHECK_FALSE(scene_of(frictionless_pile(10, 10), spec).overload);
  spec.window = {{1, 4, 0, 9}};
  CHECK_FALSE(scene_of(frictionless_pile(10, 10), spec).overload);
  Pile patterned = frictionless_pile(10, 10);
  patterned.load[2] = 1.5;
  CHECK_FALSE(scene_of(patterned, small_spec()).overload);
}

TEST_CASE("a pile without any force gives an empty scene with a scale") {
  const Pile empty(Lattice({6, 5}));
  const Scene scene = scene_of(empty, small_spec());
  CHECK(elements_of(scene).empty());
  CHECK(scene.counts.too_faint == 60);
  CHECK(scene.values.high > 0);
  Pile unloaded(Lattice({6, 5}));
  unloaded.load.assign(6, 0.0);
  CHECK(scene_of(unloaded, small_spec()).values.high == 1);
}

TEST_CASE("what cannot be rendered is refused with the reason") {
  const Pile pile = frictionless_pile(10, 10);
  const auto refused = [&](auto&& change) {
    SceneSpec spec = small_spec();
    change(spec);
    try {
      scene_of(pile, spec);
      return std::string("accepted");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
  };
  const auto window = [&](double x0, double x1, double n0, double n1) {
    return refused([&](SceneSpec& spec) { spec.window = {{x0, x1, n0, n1}}; });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(window(nan, 2, 0, 3), Catch::Contains("not made of numbers"));
  CHECK_THAT(window(0, 2, 0, std::numeric_limits<double>::infinity()), Catch::Contains("not made of numbers"));
  CHECK_THAT(window(2, 2, 0, 3), Catch::Contains("is empty"));
  CHECK_THAT(window(3, 2, 0, 3), Catch::Contains("is empty"));
  CHECK_THAT(window(0, 2, 3, 2), Catch::Contains("is empty"));
  CHECK_THAT(window(0, 2, 0.5, 2), Catch::Contains("whole numbers"));
  CHECK_THAT(window(0, 2, -1, 2), Catch::Contains("layers 0 to 9"));
  CHECK_THAT(window(0, 2, 0, 10), Catch::Contains("layers 0 to 9"));
  CHECK_THAT(window(-6, 2, 0, 3), Catch::Contains("around the ring of 10 columns"));
  CHECK_THAT(window(0, 0.5, 0, 3), Catch::Contains("narrower than a bead"));
  CHECK(window(-5, 5, 0, 9) == "accepted");
  CHECK_THAT(refused([](SceneSpec& spec) { spec.scene = "stress"; }), Catch::Contains("'stress'"));
  CHECK_THAT(refused([](SceneSpec& spec) { spec.colour_map = "jet"; }), Catch::Contains("'jet'"));
  for (const int width : {32769, 1000000}) {
    CHECK_THAT(refused([=](SceneSpec& spec) { spec.width_px = width; }), Catch::Contains("at most 32768"));
  }
  for (const double dpi : {0.0, -1.0, nan, 1e9}) {
    CHECK_THAT(refused([=](SceneSpec& spec) { spec.dpi = dpi; }), Catch::Contains("no resolution"));
  }
  for (const int width : {1, 0, -5}) {
    CHECK_THAT(refused([=](SceneSpec& spec) { spec.width_px = width; }), Catch::Contains("the smallest width is"));
  }
  CHECK_THAT(refused([](SceneSpec& spec) {
               spec.width_px = 32768;
               spec.window = {{0, 1, 0, 9}};
             }),
             Catch::Contains("pixels high"));
}

TEST_CASE("forces and loads that are not finite are refused with their place") {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e200}) {
    Pile pile = frictionless_pile(10, 10);
    pile.H_L[pile.lattice.index(7, 3)] = bad;
    CHECK_THROWS_AS(scene_of(pile, small_spec()), InputError);
    CHECK_THROWS_WITH(scene_of(pile, small_spec()), Catch::Contains("bead 3 in layer 7"));
  }
  Pile pile = frictionless_pile(10, 10);
  pile.load[4] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(scene_of(pile, small_spec()), Catch::Contains("load on bead 4"));
}

bool overlap(const Box& a, const Box& b) {
  return a.left < b.right() && b.left < a.right() && a.top < b.bottom() && b.top < a.bottom();
}

/// Everything inside the image; labels clear of each other, of the plot area and of every line.
void check_clear(const Layout& layout) {
  const auto inside = [&](const Box& box) {
    return box.left >= 0 && box.top >= 0 && box.right() <= layout.width && box.bottom() <= layout.height;
  };
  REQUIRE_FALSE(layout.labels.empty());
  CHECK(inside(layout.plot));
  CHECK(inside(layout.legend));
  for (const Rule& rule : layout.rules) CHECK(inside(rule.box));
  for (const Corner& corner : layout.arrow) {
    CHECK(corner.x >= 0);
    CHECK(corner.y >= 0);
    CHECK(corner.x <= layout.width);
    CHECK(corner.y <= layout.plot.top);
  }
  for (std::size_t i = 0; i < layout.labels.size(); ++i) {
    const Label& label = layout.labels[i];
    INFO(label.text);
    CHECK(inside(label.box));
    CHECK_FALSE(overlap(label.box, layout.plot));
    CHECK_FALSE(overlap(label.box, layout.legend));
    for (const Rule& rule : layout.rules) CHECK_FALSE(overlap(label.box, rule.box));
    for (const Corner& corner : layout.arrow) {
      CHECK_FALSE((corner.x > label.box.left && corner.x < label.box.right() && corner.y > label.box.top &&
                   corner.y < label.box.bottom()));
    }
    for (std::size_t k = 0; k < i; ++k) {
      INFO(layout.labels[k].text);
      CHECK_FALSE(overlap(label.box, layout.labels[k].box));
    }
  }
}

Layout layout_of(const Pile& pile, const SceneSpec& spec) {
  const Font font = font_of(spec);
  return lay_out(spec, scene_of(pile, spec), font);
}

TEST_CASE("nothing is clipped and nothing overlaps, at any size and resolution") {
  const Pile pile = frictionless_pile(70, 80);
  const Pile strong = [] {
    Pile changed = frictionless_pile(70, 80);
    changed.V_R[300] = 7;  // a scale that is clipped has a longer last number
    return changed;
  }();
  const std::vector<std::optional<std::array<double, 4>>> windows = {
      std::nullopt,        {{-6, 6, 0, 9}},     {{0, 35, 0, 79}},     {{-35, 0, 0, 40}},
      {{-35, 35, 70, 71}}, {{-0.5, 0.5, 0, 0}}, {{3.25, 5.5, 11, 12}}};
  int drawn = 0;
  for (const auto& window : windows) {
    for (const int width : {800, 1600, 3200}) {
      for (const double dpi : {72.0, 100.0, 300.0, 600.0}) {
        SceneSpec spec;
        spec.width_px = width;
        spec.dpi = dpi;
        spec.window = window;
        INFO(width << " px, " << dpi << " dpi, window " << (window ? (*window)[0] : -99));
        check_clear(layout_of(pile, spec));
        check_clear(layout_of(strong, spec));
        ++drawn;
      }
    }
  }
  CHECK(drawn == 84);
}

TEST_CASE("a colour scale whose title is longer than most, as in French, is as long as that") {
  const Pile pile = frictionless_pile(70, 80);
  SceneSpec spec;
  spec.width_px = 675;
  Scene scene = scene_of(pile, spec);
  scene.key_title = "variation du poids / charge du haut";
  const Layout layout = lay_out(spec, scene, font_of(spec));
  check_clear(layout);
  CHECK(layout.legend.width >= font_of(spec).width(scene.key_title));
}

TEST_CASE("the smallest width named in the refusal is the smallest that is rendered") {
  const Pile pile = frictionless_pile(70, 80);
  for (const double dpi : {100.0, 300.0, 600.0}) {
    SceneSpec spec;
    spec.dpi = dpi;
    spec.width_px = 20;
    std::string message;
    try {
      scene_of(pile, spec);
    } catch (const InputError& error) {
      message = error.what();
    }
    const std::string before = "the smallest width is ";
    REQUIRE_THAT(message, Catch::Contains(before));
    const int smallest = std::stoi(message.substr(message.find(before) + before.size()));
    spec.width_px = smallest - 1;
    CHECK_THROWS_AS(scene_of(pile, spec), InputError);
    spec.width_px = smallest;
    check_clear(layout_of(pile, spec));
  }
}

TEST_CASE("the layout follows the resolution: twice the width at twice the dpi is the same picture") {
  const Pile pile = frictionless_pile(70, 80);
  SceneSpec coarse, fine;
  coarse.width_px = 1200;
  coarse.dpi = 150;
  fine.width_px = 4800;
  fine.dpi = 600;
  const Layout a = layout_of(pile, coarse), b = layout_of(pile, fine);
  REQUIRE(a.labels.size() == b.labels.size());
  constexpr int rounding = 16;  // pixels of the fine layout: four roundings to the coarse one's whole pixels
  CHECK(std::abs(4 * a.height - b.height) <= 2 * rounding);
  for (std::size_t i = 0; i < a.labels.size(); ++i) {
    CHECK(a.labels[i].text == b.labels[i].text);
    CHECK(std::abs(4 * a.labels[i].box.left - b.labels[i].box.left) <= rounding);
    CHECK(std::abs(4 * a.labels[i].box.top - b.labels[i].box.top) <= 2 * rounding);
  }
  CHECK(text_pixels(fine) == Approx(8 * 600 / 72.0));
}

TEST_CASE("axes count from the overloaded bead, with a real minus sign; the scale bar says its length") {
  SceneSpec spec;
  const Layout layout = layout_of(frictionless_pile(70, 80), spec);
  const auto has = [&](const std::string& text) {
    return std::any_of(layout.labels.begin(), layout.labels.end(),
                       [&](const Label& label) { return label.text == text; });
  };
  CHECK(has("\u221230"));
  CHECK(has("30"));
  CHECK(has("10 bead diameters"));
  CHECK(has("force / top load"));
  CHECK(has("load 2"));
  CHECK(has("1.2"));
}

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
