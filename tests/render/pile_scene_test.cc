#include "render/scenes.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "render/test_piles.h"
#include "support/error.h"

namespace granuscope {
namespace {

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
  for (const int width : {0, -5, 32769, 1000000}) {
    CHECK_THAT(refused([=](SceneSpec& spec) { spec.width_px = width; }), Catch::Contains("from 1 to 32768"));
  }
  for (const double dpi : {0.0, -1.0, nan, 1e9}) {
    CHECK_THAT(refused([=](SceneSpec& spec) { spec.dpi = dpi; }), Catch::Contains("no resolution"));
  }
  CHECK_THAT(refused([](SceneSpec& spec) { spec.width_px = 1; }), Catch::Contains("the smallest width is"));
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

}  // namespace
}  // namespace granuscope
