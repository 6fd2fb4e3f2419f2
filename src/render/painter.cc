#include "render/painter.h"

#include <fmt/format.h>

#include "render/colour_scale.h"
#include "render/detail_painter.h"
#include "render/font.h"
#include "render/furniture.h"
#include "render/layout.h"
#include "render/level_table.h"
#include "render/palette.h"
#include "render/plot_painter.h"

namespace granuscope {

Image paint(const Scene& scene, const SceneSpec& spec, const GlSource& gl, const PaintOptions& options) {
  const Palette& palette = Palette::builtin();
  const ColourScale scale(palette, scene.colour_map, scene.values.sign);
  const Font font(text_pixels(spec));
  const Layout layout = lay_out(spec, scene, font);
  const bool transparent = spec.background == Background::transparent;

  Image image(layout.width, layout.height, transparent ? Rgb{} : scale.page(), transparent ? 0 : 255);
  const int left = layout.plot.left, top = layout.plot.top;
  if (scene.detail) {
    const LevelTable table = make_level_table(scale, scene.values, scene.glyph, detail_samples_per_diameter);
    paint_detail(scene, table, spec.background, left, top, image);
  } else if (scene.counts.drawn > 0) {
    const double samples_per_diameter = scene.pixels_per_diameter * samples_per_axis(scene.pixels_per_diameter);
    const LevelTable table = make_level_table(scale, scene.values, scene.glyph, samples_per_diameter);
    paint_plot_area(scene, table, spec.background, gl(), options.tile_px, left, top, image);
  }
  draw_furniture(scene, layout, palette, scale, font, image);
  image.metadata = describe(scene);
  return image;
}

Image paint(const Scene& scene, const SceneSpec& spec, GlContext& context, const PaintOptions& options) {
  return paint(
      scene, spec, [&]() -> GlContext& { return context; }, options);
}

ImageMetadata describe(const Scene& scene) {
  const SceneCounts& counts = scene.counts;
  return {{"Scene",
           fmt::format("{}; x {:g} to {:g}, z {:g} to {:g} bead diameters; {} from {:g} to {:g}, values from {:g} to "
                       "{:g}; {}",
                       scene.name, scene.extent.x0, scene.extent.x1, scene.extent.z0, scene.extent.z1, scene.key_title,
                       scene.values.low, scene.values.high, scene.value_min, scene.value_max, scene.colour_map)},
          {"Elements", fmt::format("{} drawn, {} outside, {} too faint, {} aggregated", counts.drawn, counts.outside,
                                   counts.too_faint, counts.aggregated)}};
}

}  // namespace granuscope
