#include "render/scenes.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "render/sample_grid.h"
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

}  // namespace
}  // namespace granuscope
