#include "render/painter.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "render/layout.h"
#include "render/picture_distance.h"
#include "render/sample_grid.h"
#include "render/test_piles.h"
#include "support/error.h"

namespace granuscope {
namespace {

/// One context for all cases: starting one takes longer than most of them.
GlContext& context() {
  static const auto made = make_gl_context("auto");
  return *made;
}

Image painted(const Pile& pile, const SceneSpec& spec, int tile_px = 0) {
  return paint(scene_of(pile, spec), spec, context(), {tile_px});
}

/// A scene of 10 x 10 bead diameters at 4 pixels each, with these elements.
Scene scene_with(const std::vector<Element>& elements) {
  Scene scene;
  scene.extent = {0, 10, 0, 10};
  scene.plot_width_px = scene.plot_height_px = 40;
  scene.pixels_per_diameter = 4;
  scene.counts.drawn = elements.size();
  scene.elements = [elements](const Extent&, const Scene::Visit& visit) {
    for (const Element& element : elements) visit(element);
  };
  return scene;
}

LevelTable table_of(const Scene& scene) {
  return make_level_table(ColourScale(Palette::builtin(), "grey"), scene.values, Glyph::force_bar, 16);
}

Image painted(const Scene& scene, int tile_px = 0) {
  Image image;
  image.width = scene.plot_width_px;
  image.height = scene.plot_height_px;
  PictureRows rows(image.width, image.height, {255, 255, 255}, 255, {}, [&image](const Image& band, int) {
    image.rgba.insert(image.rgba.end(), band.rgba.begin(), band.rgba.end());
  });
  paint_plot_area(scene, table_of(scene), Background::page, context(), tile_px, 0, rows);
  rows.close();
  return image;
}

double ink(const Image& image) {
  double sum = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) sum += (255 - image.rgba[i]) / 255.0;
  return sum;
}

TEST_CASE("one bar covers exactly the pixels its geometry says") {
  // A vertical bar 4 px wide around x = 20 px, from y = 8 px to 32 px
  const Image image = painted(scene_with({{5, 2, 5, 8, 1, 255}}));
  for (int y = 8; y < 32; ++y) {
    for (int x = 0; x < 40; ++x) {
      INFO(x << ", " << y);
      CHECK(image.at(x, y) == (x >= 18 && x < 22 ? Rgb{0, 0, 0} : Rgb{255, 255, 255}));
    }
  }
  // Round ends of radius 2 px: nothing beyond, and the area of a circle together. A sample is 1/16 pixel.
  for (int x = 0; x < 40; ++x) {
    CHECK(image.at(x, 5) == Rgb{255, 255, 255});
    CHECK(image.at(x, 34) == Rgb{255, 255, 255});
  }
  CHECK(ink(image) == Approx(4 * 24 + std::acos(-1.0) * 4).margin(8.0 / 16));
}

TEST_CASE("a slanted bar has the area and the darkness of its force") {
  const Image image = painted(scene_with({{4, 2, 6, 2 + 2 * sqrt3, 1.5, 127}}));
  // Length 4 diameters = 16 px, width 6 px, round ends of radius 3 px; grey 255 - 127.
  const double area = 16 * 6 + std::acos(-1.0) * 9;
  CHECK(ink(image) == Approx(area * 127 / 255).epsilon(0.02));  // sampling at 16 points a pixel along the edges
  CHECK(image.at(20, 14) == Rgb{128, 128, 128});
}

TEST_CASE("a bar much thinner than a sample keeps its share of the page on average") {
  // Level 26 of 255 is 0.051 diameters = 0.82 samples wide, so that its grey is thinned by as much.
  const double width = widest_bar * 26 / 255;
  const Image image = painted(scene_with({{4, 2, 6, 2 + 2 * sqrt3, width, 26}}));
  CHECK(ink(image) == Approx(16 * 4 * width * 26 / 255).epsilon(0.1));  // few samples are hit: counting noise
}

TEST_CASE("the strong lies on top of the weak") {
  const Element weak{2, 5, 8, 5, 1, 64}, strong{5, 2, 5, 8, 1, 255};
  for (const Scene& scene : {scene_with({weak, strong}), scene_with({strong, weak})}) {
    CHECK(painted(scene).at(20, 20) == Rgb{0, 0, 0});
    CHECK(painted(scene).at(10, 20) == Rgb{191, 191, 191});
  }
}

TEST_CASE("boxes fill the plane without gap or overlap") {
  std::vector<Element> boxes;
  boxes.reserve(7);
  for (int k = 0; k < 7; ++k) {
    boxes.push_back({k * 10 / 7.0, 0, (k + 1) * 10 / 7.0, 10, 1, static_cast<std::uint8_t>(60), Outline::box});
  }
  const Image image = painted(scene_with(boxes));
  int other = 0;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) other += image.at(x, y) != table_of(scene_with({})).colour[60];
  }
  CHECK(other == 0);
}

TEST_CASE("tiles do not change a pixel") {
  Pile pile = irregular_pile(20, 15);
  SceneSpec spec;
  spec.width_px = 700;
  spec.dpi = 150;
  for (const auto& window :
       std::vector<std::optional<std::array<double, 4>>>{std::nullopt, {{-3.3, 4.1, 2, 9}}, {{-0.7, 0.6, 3, 3}}}) {
    spec.window = window;
    const Image whole = painted(pile, spec, 4000);  // one tile of up to 2800 samples
    for (const int tile_px : {37, 64, 100, 512}) {
      INFO(tile_px);
      CHECK((painted(pile, spec, tile_px).rgba == whole.rgba));
    }
  }
}

TEST_CASE("rows come from the top, each once, whatever paints them, and never many at a time") {
  SceneSpec spec;
  spec.width_px = 900;
  spec.dpi = 100;
  for (const int columns : {20, 600}) {  // with OpenGL; level of detail
    CAPTURE(columns);
    const Pile pile = irregular_pile(columns, columns);
    const Scene scene = scene_of(pile, spec);
    const Picture picture(scene, spec);
    CHECK(picture.has_use_for_gl() == (columns == 20));
    CHECK(picture.channels() == Channels::grey);
    int next = 0, most = 0;
    std::vector<std::uint8_t> pixels;
    picture.paint(&context(), {100}, [&](const Image& rows, int top) {
      CHECK(top == next);
      CHECK(rows.width == picture.width());
      next += rows.height;
      most = std::max(most, rows.height);
      pixels.insert(pixels.end(), rows.rgba.begin(), rows.rgba.end());
    });
    CHECK(next == picture.height());
    CHECK(most <= 100);
    CHECK((pixels == paint(scene, spec, context()).rgba));
  }
}

TEST_CASE("a picture wider than the driver's largest framebuffer is painted to its last pixel") {
  const Pile pile = irregular_pile(200, 4);
  SceneSpec spec;
  spec.width_px = 20000;
  const Scene scene = scene_of(pile, spec);
  const Image image = paint(scene, spec, context());
  const Font font = font_of(spec);
  const Box plot = lay_out(spec, scene, font).plot;
  // Uniform layers: ink in the last bead's width as in the first one's.
  for (const int left : {plot.left, plot.right() - 100}) {
    bool drawn = false;
    for (int x = left; x < left + 100; ++x) drawn = drawn || image.at(x, plot.top + plot.height / 2).r < 200;
    CHECK(drawn);
  }
}

TEST_CASE("a tile larger than the driver's limit is refused instead of left blank") {
  Scene scene = scene_with({{5, 2, 5, 8, 1, 255}});
  scene.plot_width_px = scene.plot_height_px = context().max_size() / samples_per_axis(4) + 1;
  const auto draw = [&] { painted(scene, 1 << 20); };
  CHECK_THROWS_AS(draw(), EnvironmentError);
  CHECK_THROWS_WITH(draw(), Catch::Contains("blank"));
}

TEST_CASE("skipping what cannot be seen does not change a pixel") {
  Pile pile = irregular_pile(30, 25);
  for (std::size_t k = 0; k < pile.lattice.beads(); ++k) {
    // A wide range of forces, so that many are around the threshold of what is visible.
    const double factor = std::pow(10.0, -4.0 * static_cast<double>(k * 7919 % 1000) / 1000);
    pile.V_R[k] *= factor;
    pile.H_R[k] *= factor;
    pile.V_L[k] *= factor;
    pile.H_L[k] *= factor;
  }
  for (const char* map : {"grey", "viridis", "cividis"}) {
    for (const auto& window : std::vector<std::optional<std::array<double, 4>>>{std::nullopt, {{-4, 7.5, 3, 11}}}) {
      SceneSpec spec;
      spec.width_px = 450;
      spec.dpi = 100;
      spec.colour_map = map;
      spec.window = window;
      const Scene skipped = scene_of(pile, spec);
      CHECK(skipped.counts.too_faint > 0);
      spec.skip_invisible = false;
      const Scene all = scene_of(pile, spec);
      CHECK(all.counts.drawn == 2 * pile.lattice.beads());
      CHECK((paint(skipped, spec, context()).rgba == paint(all, spec, context()).rgba));
    }
  }
}

TEST_CASE("a mirrored pile gives the mirrored plot area") {
  const Pile pile = irregular_pile(16, 11);
  SceneSpec spec;
  spec.width_px = 601;
  spec.dpi = 100;
  for (const auto& window : std::vector<std::optional<std::array<double, 4>>>{std::nullopt, {{-4.3, 4.3, 2, 8}}}) {
    spec.window = window;
    const Image image = painted(pile, spec), mirror = painted(mirrored(pile), spec);
    const Font font = font_of(spec);
    const Box plot = lay_out(spec, scene_of(pile, spec), font).plot;
    int different = 0;
    for (int y = plot.top; y < plot.bottom(); ++y) {
      for (int x = 0; x < plot.width; ++x) {
        different += image.at(plot.left + x, y) != mirror.at(plot.right() - 1 - x, y);
      }
    }
    CHECK(different == 0);
  }
}

TEST_CASE("a contact across the seam is seen at both sides") {
  Pile pile(Lattice({8, 4}));
  const std::size_t k = pile.lattice.index(2, 0);  // x = -4, on the seam; its lower-left contact leaves the window
  pile.V_L[k] = 1;
  const SceneSpec spec = small_spec();
  const Scene scene = scene_of(pile, spec);
  CHECK(scene.counts.drawn == 1);
  CHECK(elements_of(scene).size() == 2);
  const Image image = paint(scene, spec, context());
  const Font font = font_of(spec);
  const Box plot = lay_out(spec, scene, font).plot;
  const int row = plot.top + static_cast<int>(Lattice::depth(2) * scene.pixels_per_diameter);
  CHECK(image.at(plot.left, row).r < 100);
  CHECK(image.at(plot.right() - 1, row).r < 100);
}

TEST_CASE("two runs and two contexts give the same bytes") {
  const Pile pile = irregular_pile(20, 15);
  SceneSpec spec;
  spec.width_px = 500;
  spec.dpi = 100;
  const Image first = painted(pile, spec);
  CHECK((painted(pile, spec).rgba == first.rgba));
  const auto other = make_gl_context("osmesa");
  CHECK((paint(scene_of(pile, spec), spec, *other).rgba == first.rgba));
}

TEST_CASE("a pile without forces is an empty frame with its legend") {
  SceneSpec spec;
  const Image image = painted(Pile(Lattice({10, 10})), spec);
  CHECK(image.width == spec.width_px);
  CHECK(ink(image) > 0);
}

TEST_CASE("backends: osmesa is there and says why it was chosen, others do not exist") {
  CHECK(context().name() == "osmesa");
  CHECK(context().max_size() >= 2048);
  CHECK_FALSE(context().renderer().empty());
  CHECK_THAT(context().reason(), Catch::Contains("OSMesa"));
  CHECK_THROWS_AS(make_gl_context("vulkan"), InputError);
}

TEST_CASE("EGL without a window system paints the same pixels as OSMesa, where it is installed") {
  std::unique_ptr<GlContext> egl;
  try {
    egl = make_gl_context("egl");
  } catch (const EnvironmentError& absent) {
    WARN("not compared, since " << absent.what());
    return;
  }
  CHECK(egl->name() == "egl");
  const Pile pile = irregular_pile(30, 25);
  for (const char* scene_name : {"forces", "weight"}) {
    SceneSpec spec;
    spec.scene = scene_name;
    spec.width_px = 700;
    spec.dpi = 100;
    const Scene scene = scene_of(pile, spec);
    const Image here = paint(scene, spec, context()), there = paint(scene, spec, *egl);
    // Another driver (a graphics card's, or another Mesa's) may decide otherwise on the edge of a sample.
    if (egl->renderer() == context().renderer() && egl->version() == context().version()) {
      CHECK((here.rgba == there.rgba));
    } else {
      CHECK(distance(here, there).root_mean_square < 1);
    }
    context().make_current();
  }
}

TEST_CASE("the level of detail is as near to the full picture as stated", "[unsanitized]") {
  struct Case {
    int columns, layers, width;
    const char* scene;
  };
  // From just below two pixels a bead to a tenth.
  for (const Case& one : {Case{300, 250, 620, "forces"}, Case{300, 250, 400, "forces"}, Case{600, 460, 280, "forces"},
                          Case{1200, 900, 165, "forces"}, Case{300, 250, 620, "weight"}, Case{600, 460, 280, "weight"},
                          Case{300, 250, 620, "friction"}, Case{600, 460, 280, "friction"}}) {
    Pile pile = irregular_pile(one.columns, one.layers);
    pile.mu = 0.5;
    SceneSpec spec;
    spec.scene = one.scene;
    spec.width_px = one.width;
    spec.dpi = 72;
    const Scene detail = scene_of(pile, spec);
    REQUIRE(detail.detail);
    CHECK(detail.counts.aggregated > 0);
    CHECK(detail.counts.drawn == 0);
    spec.skip_invisible = false;
    const Scene full = scene_of(pile, spec);
    REQUIRE_FALSE(full.detail);
    const PictureDistance apart = distance(paint(detail, spec, context()), paint(full, spec, context()));
    INFO(one.scene << ", " << detail.pixels_per_diameter << " pixels a diameter: root mean square "
                   << apart.root_mean_square << ", of blocks " << apart.blocks << ", mean " << apart.mean);
    CHECK(apart.root_mean_square < detail_distance.root_mean_square);
    CHECK(apart.blocks < detail_distance.blocks);
    CHECK(std::abs(apart.mean) < detail_distance.mean);
  }
}

TEST_CASE("a transparent picture laid on the page is the opaque one") {
  const Pile pile = irregular_pile(30, 25);
  for (const double width : {100.0, 500.0}) {  // with the level of detail, and without
    SceneSpec spec;
    spec.width_px = static_cast<int>(width);
    spec.dpi = width > 200 ? 100 : 20;
    const Scene scene = scene_of(pile, spec);
    const Image opaque = paint(scene, spec, context());
    spec.background = Background::transparent;
    Image clear = paint(scene, spec, context());
    CHECK(clear.rgba[3] == 0);
    for (std::size_t i = 0; i < clear.rgba.size(); i += 4) {
      const int alpha = clear.rgba[i + 3];
      for (std::size_t c = 0; c < 3; ++c) {
        clear.rgba[i + c] = static_cast<std::uint8_t>((clear.rgba[i + c] * alpha + 255 * (255 - alpha) + 127) / 255);
      }
      clear.rgba[i + 3] = 255;
    }
    const PictureDistance apart = distance(clear, opaque);
    CHECK(apart.largest <= 3);  // roundings of colour and of alpha
    CHECK(apart.root_mean_square < 0.7);
  }
}

}  // namespace
}  // namespace granuscope
