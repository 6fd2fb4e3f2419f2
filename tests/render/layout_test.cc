#include "render/layout.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "render/scenes.h"
#include "render/test_piles.h"
#include "support/error.h"

namespace granuscope {
namespace {

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
  const Font font(text_pixels(spec));
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

}  // namespace
}  // namespace granuscope
