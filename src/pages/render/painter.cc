#include "render/painter.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "render/font.h"
#include "render/layout.h"
#include "render/palette.h"
#include "support/error.h"
#include "support/progress.h"

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
        font(font_of(spec)),
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
           fmt::format(
               "{}; x {:g} to {:g}, z {:g} to {:g} bead diameters; {} from {:g} to {:g}, values from {:g} to {:g}; {}",
               scene.name, scene.extent.x0, scene.extent.x1, scene.extent.z0, scene.extent.z1, scene.key_title,
               scene.values.low, scene.values.high, scene.value_min, scene.value_max, scene.colour_map)},
          {"Elements", fmt::format("{} drawn, {} outside, {} too faint, {} aggregated", counts.drawn, counts.outside,
                                   counts.too_faint, counts.aggregated)}};
}

namespace {

/// Edge of a tile's framebuffer: 4 MB of samples, whatever the size of the image.
constexpr int tile_samples_wanted = 2048;

/// Elements sent to GL at once, most welcome first. Their texels are a quarter of those that every driver must take in
/// one buffer. The second is for drivers that forget where they are after some thousand corners (softpipe of Mesa 22:
/// 4096).
constexpr std::array<std::size_t, 2> batch_sizes = {8192, 512};

constexpr const char* vertex_source = R"(#version 330 core
uniform isamplerBuffer elements;
uniform ivec2 tile_origin;   // samples
uniform int tile_size;       // samples, edge of the framebuffer
flat out ivec4 ends;         // units
flat out float radius;       // units; negative for a box
flat out float level;
const float units = 256.0;

void main() {
  int number = gl_VertexID / 6;
  int corner = gl_VertexID % 6;
  ends = texelFetch(elements, 2 * number);
  ivec4 look = texelFetch(elements, 2 * number + 1);
  radius = float(look.x);
  level = float(look.y) / 255.0;

  // A box around the element, a quarter of a sample wider on every side: more than single precision loses here.
  vec2 first = vec2(ends.xy - tile_origin * int(units)) / units;
  vec2 last = vec2(ends.zw - tile_origin * int(units)) / units;
  bool at_end = corner == 1 || corner == 2 || corner == 4;
  bool at_right = corner == 2 || corner == 4 || corner == 5;
  vec2 place;
  if (look.x < 0) {
    place = vec2(at_end ? last.x + 0.25 : first.x - 0.25, at_right ? last.y + 0.25 : first.y - 0.25);
  } else {
    float size = length(last - first);
    vec2 along = size > 0.0 ? (last - first) / size : vec2(1.0, 0.0);
    vec2 across = vec2(-along.y, along.x);
    float reach = radius / units + 0.25;
    place = (at_end ? last + along * reach : first - along * reach) + (at_right ? across : -across) * reach;
  }
  gl_Position = vec4(2.0 * place / float(tile_size) - 1.0, 0.0, 1.0);
}
)";

constexpr const char* fragment_source = R"(#version 330 core
uniform ivec2 tile_origin;
flat in ivec4 ends;
flat in float radius;
flat in float level;
out float sample_level;

void main() {
  ivec2 here = (ivec2(gl_FragCoord.xy) + tile_origin) * 256 + 128;
  if (radius < 0.0) {
    if (any(lessThan(here, ends.xy)) || any(greaterThanEqual(here, ends.zw))) discard;
  } else {
    vec2 offset = vec2(here - ends.xy);
    vec2 axis = vec2(ends.zw - ends.xy);
    float square = dot(axis, axis);
    float share = square > 0.0 ? clamp(dot(offset, axis) / square, 0.0, 1.0) : 0.0;
    vec2 away = offset - share * axis;
    if (dot(away, away) > radius * radius) discard;
  }
  sample_level = level;
}
)";

/// Paints elements into the framebuffer bound at construction.
class ElementProgram {
 public:
  ElementProgram(const GlContext& context, int tile_samples)
      : context_(context),
        gl_(context.gl()),
        program_(context, vertex_source, fragment_source),
        vertex_array_(context),
        buffer_(context),
        texture_(context) {
    gl_.UseProgram(program_.id());
    gl_.BindVertexArray(vertex_array_.id());
    gl_.BindBuffer(GL_TEXTURE_BUFFER, buffer_.id());
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.BindTexture(GL_TEXTURE_BUFFER, texture_.id());
    gl_.Uniform1i(program_.uniform("elements"), 0);
    gl_.Uniform1i(program_.uniform("tile_size"), tile_samples);
    origin_ = program_.uniform("tile_origin");
    check_gl(context_, "setting up its program");
  }

  void set_origin(int x, int y) { gl_.Uniform2i(origin_, x, y); }

  /// Paints `count` elements of one sample each, side by side, and looks whether all of them are there: drivers do not
  /// report what they leave out.
  bool draws_whole_batch(std::size_t count, int tile_samples) {
    const auto wide = static_cast<std::size_t>(std::min(tile_samples, 128));
    const std::size_t high = (count + wide - 1) / wide;
    if (high > static_cast<std::size_t>(tile_samples)) return draws_whole_batch(wide * wide, tile_samples);
    const auto level_of = [](std::size_t k) { return static_cast<std::uint8_t>(1 + k % 251); };
    std::vector<PackedElement> elements;
    elements.reserve(count);
    for (std::size_t k = 0; k < count; ++k) {
      const auto x = static_cast<std::int32_t>(k % wide) * units_per_sample;
      const auto y = static_cast<std::int32_t>(k / wide) * units_per_sample;
      elements.push_back({x, y, x + units_per_sample, y + units_per_sample, -1, level_of(k), {0, 0}});
    }
    gl_.Clear(GL_COLOR_BUFFER_BIT);
    set_origin(0, 0);
    paint(elements);
    std::vector<std::uint8_t> seen(wide * high);
    gl_.ReadPixels(0, 0, static_cast<GLsizei>(wide), static_cast<GLsizei>(high), GL_RED, GL_UNSIGNED_BYTE, seen.data());
    for (std::size_t k = 0; k < count; ++k) {
      if (seen[k] != level_of(k)) return false;
    }
    return true;
  }

  void paint(std::span<const PackedElement> elements) {
    gl_.BufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(elements.size_bytes()), elements.data(), GL_STREAM_DRAW);
    gl_.TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32I, buffer_.id());
    gl_.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(6 * elements.size()));
  }

 private:
  const GlContext& context_;
  const GlFunctions& gl_;
  GlProgram program_;
  GlVertexArray vertex_array_;
  GlBuffer buffer_;
  GlTexture texture_;
  GLint origin_ = 0;
};

/// The largest batch that arrives whole. Throws EnvironmentError if none does.
std::size_t batch_size_of(ElementProgram& program, const GlContext& context, int tile_samples) {
  for (const std::size_t size : batch_sizes) {
    if (program.draws_whole_batch(size, tile_samples)) return size;
  }
  throw EnvironmentError(
      "the driver {} ({}) leaves out what it is told to paint, so a picture would be wrong; choose another by "
      "--backend, and unset GALLIUM_DRIVER if it is set",
      context.renderer(), context.version());
}

/// Where the elements of a tile may lie. A tile at the edge of the plot area also takes what lies beyond.
Extent region_of(const Scene& scene, int column, int row, int columns, int rows, int tile_px) {
  const double tile = tile_px / scene.pixels_per_diameter;
  const double margin = 1 / scene.pixels_per_diameter;  // for rounding, and for bars painted a sample wide
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Extent& all = scene.extent;
  return {column == 0 ? -infinity : all.x0 + column * tile - margin,
          column + 1 == columns ? infinity : all.x0 + (column + 1) * tile + margin,
          row == 0 ? -infinity : all.z0 + row * tile - margin,
          row + 1 == rows ? infinity : all.z0 + (row + 1) * tile + margin};
}

}  // namespace

void paint_plot_area(const Scene& scene, const LevelTable& table, Background background, GlContext& context,
                     int tile_px, int left, PictureRows& rows) {
  const int samples = samples_per_axis(scene.pixels_per_diameter);
  if (tile_px == 0) tile_px = tile_samples_wanted / samples;
  tile_px = std::min(tile_px, std::max(scene.plot_width_px, scene.plot_height_px));
  const int tile_samples = tile_px * samples;
  if (tile_px < 1 || tile_samples > context.max_size()) {
    throw EnvironmentError(
        "a tile of {} samples is more than {} can paint ({}), and the rest would stay blank; use smaller tiles",
        tile_samples, context.renderer(), context.max_size());
  }
  const int tile_columns = (scene.plot_width_px + tile_px - 1) / tile_px;
  const int tile_rows = (scene.plot_height_px + tile_px - 1) / tile_px;
  const Projection projection(scene, samples);

  context.make_current();
  const GlFunctions& gl = context.gl();
  const GlFramebuffer framebuffer(context, tile_samples, tile_samples);
  ElementProgram program(context, tile_samples);
  gl.Viewport(0, 0, tile_samples, tile_samples);
  gl.Disable(GL_DITHER);
  // The higher level is seen, in whatever order the elements come.
  gl.Enable(GL_BLEND);
  gl.BlendEquation(GL_MAX);
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.ClearColor(0, 0, 0, 0);

  const std::size_t batch_size = batch_size_of(program, context, tile_samples);
  std::vector<PackedElement> batch;
  std::vector<std::uint8_t> levels;
  for (int row = 0; row < tile_rows; ++row) {
    const int height = std::min(tile_px, scene.plot_height_px - row * tile_px);
    Image& image = rows.open(height);
    for (int column = 0; column < tile_columns; ++column) {
      bool any = false;
      const auto send = [&] {
        if (batch.empty()) return;
        if (!any) {
          gl.Clear(GL_COLOR_BUFFER_BIT);
          program.set_origin(column * tile_samples, row * tile_samples);
        }
        any = true;
        throw_if_interrupted();
        program.paint(batch);
        batch.clear();
      };
      scene.elements(region_of(scene, column, row, tile_columns, tile_rows, tile_px), [&](const Element& element) {
        batch.push_back(projection.pack(element));
        if (batch.size() == batch_size) send();
      });
      send();
      throw_if_interrupted();
      if (!any) continue;  // nothing but page
      // Rows of the framebuffer count upwards and are read upwards: its row 0 is the uppermost one of the picture.
      const int width = std::min(tile_px, scene.plot_width_px - column * tile_px);
      const int row_samples = width * samples;
      const auto stride = static_cast<std::size_t>(row_samples);
      levels.resize(stride * static_cast<std::size_t>(height * samples));
      gl.ReadPixels(0, 0, row_samples, height * samples, GL_RED, GL_UNSIGNED_BYTE, levels.data());
      check_gl(context, "painting the plot area");

      std::vector<std::size_t> first_sample;
      for (int x = 0; x <= width; ++x) {
        const int first = x * samples;
        first_sample.push_back(static_cast<std::size_t>(first));
      }
      SampleAverager averager(table, background, first_sample);
      for (int y = 0; y < height; ++y) {
        for (int k = 0; k < samples; ++k) {
          averager.add_row(levels.data() + static_cast<std::size_t>(y * samples + k) * stride);
        }
        averager.write_pixels(image, left + column * tile_px, y);
      }
    }
  }
}

}  // namespace granuscope
