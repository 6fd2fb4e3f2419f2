#include "render/painter.h"

#include <fmt/format.h>

#include "render/colour_scale.h"
#include "render/font.h"
#include "render/furniture.h"
#include "render/layout.h"
#include "render/palette.h"
#include "render/plot_painter.h"

namespace granuscope {

Image paint(const Scene& scene, const SceneSpec& spec, GlContext& context, const PaintOptions& options) {
  const Palette& palette = Palette::builtin();
  const ColourScale scale(palette, spec.colour_map);
  const Font font(text_pixels(spec));
  const Layout layout = lay_out(spec, scene, font);

  Image image(layout.width, layout.height, scale.page());
  paint_plot_area(scene, scale, context, options.tile_px, layout.plot.left, layout.plot.top, image);
  draw_furniture(layout, palette, scale, font, image);

  const SceneCounts& counts = scene.counts;
  image.metadata = {
      {"Scene",
       fmt::format("{}; x {:g} to {:g}, z {:g} to {:g} bead diameters; force scale 0 to {:g}, largest force {:g}; {}",
                   scene.name, scene.extent.x0, scene.extent.x1, scene.extent.z0, scene.extent.z1, scene.scale_top,
                   scene.force_max, spec.colour_map)},
      {"Contacts", fmt::format("{} drawn, {} outside, {} too faint, {} aggregated", counts.drawn, counts.outside,
                               counts.too_faint, counts.aggregated)},
      {"Renderer", fmt::format("{}, OpenGL {} ({})", context.renderer(), context.version(), context.name())}};
  return image;
}

}  // namespace granuscope
