
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "render/gl_context.h"
#include "render/painter.h"
#include "render/picture_distance.h"
#include "render/scene.h"
#include "render/test_piles.h"

namespace granuscope {
namespace {

GlContext& gl_context() {
  static const auto made = make_gl_context("auto");
  return *made;
}

Image without_gl(const Scene& scene, const SceneSpec& spec) {
  Image image;
  const Picture picture(scene, spec);
  image.width = picture.width();
  image.height = picture.height();
  picture.paint(nullptr, {}, [&image](const Image& rows, int) {
    image.rgba.insert(image.rgba.end(), rows.rgba.begin(), rows.rgba.end());
  });
  return image;
}

/// The same pixels as llvmpipe; any other driver may round the ends of slanted bars otherwise.
void check_alike(const Scene& scene, const SceneSpec& spec) {
  const Image here = without_gl(scene, spec), there = paint(scene, spec, gl_context());
  REQUIRE(here.rgba.size() == there.rgba.size());
  if (gl_context().renderer().find("llvmpipe") != std::string::npos) {
    CHECK((here.rgba == there.rgba));
    return;
  }
  const PictureDistance apart = distance(here, there);
  CHECK(apart.root_mean_square <= renderer_distance.root_mean_square);
  CHECK(apart.blocks <= renderer_distance.blocks);
}

TEST_CASE(
    "the processor paints the pixels that OpenGL paints: every scene, windows, all painted or not, seen through or "
    "not") {
  const Pile pile = irregular_pile(40, 30);
  Pile other = frictionless_pile(40, 30), with_friction = pile;
  other.law = pile.law;
  with_friction.mu = other.mu = 0.7;
  const PileView first = view_of(with_friction), second = view_of(other);
  for (const std::string scene : {"forces", "weight", "friction", "response"}) {
    for (const auto& window : std::vector<std::optional<std::array<double, 4>>>{
             std::nullopt, {{-3.3, 7.1, 4, 15}}, {{-19.7, -18.2, 29, 29}}}) {
      for (const int width : {130, 411, 903}) {
        for (const bool skip : {true, false}) {
          CAPTURE(scene, window.has_value(), width, skip);
          SceneSpec spec;
          spec.scene = scene;
          spec.window = window;
          spec.width_px = width;
          spec.dpi = 50;
          spec.skip_invisible = skip;
          spec.colour_map.clear();
          spec.background = width == 411 ? Background::transparent : Background::page;
          const Scene built = build_scene(first, scene == "response" ? &second : nullptr, spec);
          REQUIRE(!built.detail);
          check_alike(built, spec);
        }
      }
    }
  }
}

TEST_CASE("so it does for cells with lines over them, and for bars in every direction and of every size") {
  Field field;
  field.key_title = "response";
  for (int row = 0; row < 20; ++row) {
    FieldRow cells;
    cells.z = 1 + 1.3 * row;
    cells.x0 = -10.2 + 0.5 * (row % 2);
    for (int k = 0; k < 20; ++k) cells.values.push_back((row * 7 + k * 3) % 11 - 1.0);
    field.rows.push_back(cells);
  }
  OverlayLine solid, dashed;
  for (int k = 0; k < 15; ++k) {
    solid.points.push_back({-9.0 + k * 1.1, 2.0 + k * k * 0.1});
    dashed.points.push_back({9.0 - k * 1.3, 12.0});  // level: along a row of samples
  }
  dashed.dashed = true;
  field.lines = {solid, dashed};
  SceneSpec spec;
  spec.width_px = 640;
  spec.dpi = 80;
  check_alike(build_field_scene(field, spec), spec);

  Scene scene = build_field_scene(field, spec);
  std::vector<Element> bars;
  for (int k = 0; k < 4000; ++k) {
    // Steps of irrational ratios, so that no two are alike.
    const auto part = [k](double step) { return k * step - static_cast<int>(k * step); };
    const double x = -9 + 18 * part(0.6180339887), z = 25 * part(0.4142135623);
    const double length = 4 * part(0.7320508075) * part(0.2360679774), turn = 6.2831853 * part(0.1622776601);
    bars.push_back({x, z, x + length * std::cos(turn), z + length * std::sin(turn), 0.6 * part(0.3166247903),
                    static_cast<std::uint8_t>(1 + k % 250)});
  }
  bars.push_back({-5, 3, -5, 9, 0.3, 251});    // upright
  bars.push_back({-5, 3, 5, 3, 0.3, 251});     // level
  bars.push_back({4, 20, 4, 20, 3, 251});      // a disc
  bars.push_back({-90, 5, 80, 22, 0.2, 251});  // from far outside to far outside
  scene.counts.drawn = bars.size();
  scene.elements = [&bars](const Extent&, const Scene::Visit& visit) {
    for (const Element& bar : bars) visit(bar);
  };
  check_alike(scene, spec);
}

TEST_CASE("a picture is small where its start would take OpenGL longer than all of it the processor") {
  const Pile pile = irregular_pile(100, 100);
  SceneSpec spec;
  spec.width_px = 800;
  const Scene window = scene_of(pile, spec);
  CHECK(Picture(window, spec).is_small());
  SceneSpec large = spec;
  large.width_px = 4000;
  const Scene poster = scene_of(pile, large);
  CHECK_FALSE(Picture(poster, large).is_small());
}

}  // namespace
}  // namespace granuscope
