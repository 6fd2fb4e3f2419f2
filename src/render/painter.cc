#include "render/painter.h"

#include <fmt/format.h>

#include "render/colour_scale.h"
#include "render/decorations.h"
#include "render/detail_painter.h"
#include "render/font.h"
#include "render/layout.h"
#include "render/level_table.h"
#include "render/palette.h"
#include "render/plot_painter.h"
#include "render/span_painter.h"

namespace granuscope {

namespace {

bool is_grey(Rgb colour) { return colour.r == colour.g && colour.r == colour.b; }

LevelTable level_table_of(const Scene& scene, const ColourScale& scale) {
  const double samples_per_diameter = scene.detail
                                          ? detail_samples_per_diameter
                                          : scene.pixels_per_diameter * samples_per_axis(scene.pixels_per_diameter);
  return make_level_table(scale, scene.values, scene.glyph, samples_per_diameter);
}

}  // namespace

struct Picture::Parts {
  Parts(const Scene& scene_, const SceneSpec& spec_)
      : scene(scene_),
        spec(spec_),
        scale(Palette::builtin(), scene.colour_map, scene.values.sign),
        font(text_pixels(spec)),
        layout(lay_out(spec, scene, font)),
        decorations(scene, layout, Palette::builtin(), scale, font),
        table(level_table_of(scene, scale)) {}

  const Scene& scene;
  const SceneSpec& spec;
  ColourScale scale;
  Font font;
  Layout layout;
  Decorations decorations;
  LevelTable table;
};

Picture::Picture(const Scene& scene, const SceneSpec& spec) : parts_(std::make_unique<const Parts>(scene, spec)) {}
Picture::~Picture() = default;

int Picture::width() const { return parts_->layout.width; }
int Picture::height() const { return parts_->layout.height; }

Channels Picture::channels() const {
  if (parts_->spec.background == Background::transparent) return Channels::rgba;
  const Palette& palette = Palette::builtin();
  bool grey = is_grey(palette.colour("ink")) && is_grey(palette.colour("frame")) && is_grey(parts_->scale.page());
  for (const Rgb colour : parts_->table.colour) grey = grey && is_grey(colour);
  for (const Rgb colour : parts_->table.full_colour) grey = grey && is_grey(colour);
  return grey ? Channels::grey : Channels::rgb;
}

bool Picture::has_use_for_gl() const { return !parts_->scene.detail && parts_->scene.counts.drawn > 0; }

bool Picture::is_small() const {
  // Measured on one core (500 x 200 beads at 4000 px, 100 x 100 at 800 px): what the processor takes for an element and
  // for a sample, and a good half of what loading and starting a software OpenGL takes.
  constexpr double element_seconds = 0.4e-6, sample_seconds = 1e-9, start_seconds = 0.02;
  const Scene& scene = parts_->scene;
  const double samples = samples_per_axis(scene.pixels_per_diameter);
  const double area = samples * samples * scene.plot_width_px * scene.plot_height_px;
  return element_seconds * static_cast<double>(scene.counts.drawn) + sample_seconds * area < start_seconds;
}

void Picture::paint(GlContext* context, const PaintOptions& options, const PictureRows::Rows& take) const {
  const Parts& of = *parts_;
  const bool transparent = of.spec.background == Background::transparent;
  PictureRows rows(
      width(), height(), transparent ? Rgb{} : of.scale.page(), transparent ? 0 : 255,
      [&of](Image& band, int top) { of.decorations.paint(band, top); }, take);
  const Box& plot = of.layout.plot;
  rows.pass(plot.top);
  if (of.scene.detail) {
    paint_detail(of.scene, of.table, of.spec.background, plot.left, rows);
  } else if (has_use_for_gl() && context == nullptr) {
    paint_spans(of.scene, of.table, of.spec.background, plot.left, rows);
  } else if (has_use_for_gl()) {
    paint_plot_area(of.scene, of.table, of.spec.background, *context, options.tile_px, plot.left, rows);
  }
  rows.pass(height() - rows.opened());
  rows.close();
}

Image paint(const Scene& scene, const SceneSpec& spec, GlContext& context, const PaintOptions& options) {
  const Picture picture(scene, spec);
  Image image;
  image.width = picture.width();
  image.height = picture.height();
  picture.paint(&context, options, [&image](const Image& rows, int) {
    image.rgba.insert(image.rgba.end(), rows.rgba.begin(), rows.rgba.end());
  });
  return image;
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
