#include "render/plot_painter.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "render/gl_objects.h"
#include "support/error.h"

namespace granuscope {
namespace {

/// Positions reach GL as whole numbers of 1/256 sample. Whether a sample lies in a bar is then decided from differences
/// of whole numbers, the same for whatever tile the sample is drawn in; the triangles only say where to look.
constexpr int units_per_sample = 256;

/// Bars sent to GL at once: 4 MB.
constexpr std::size_t batch_size = 1U << 17;

constexpr const char* vertex_source = R"(#version 330 core
uniform isamplerBuffer bars;
uniform ivec2 tile_origin;   // samples
uniform int tile_size;       // samples, edge of the framebuffer
flat out ivec4 ends;         // units
flat out float radius;       // units
flat out vec3 colour;
const float units = 256.0;

void main() {
  int bar = gl_VertexID / 6;
  int corner = gl_VertexID % 6;
  ends = texelFetch(bars, 2 * bar);
  ivec4 look = texelFetch(bars, 2 * bar + 1);
  radius = float(look.x);
  colour = vec3(look.y & 255, (look.y >> 8) & 255, (look.y >> 16) & 255) / 255.0;

  // A box around the bar, a quarter of a sample wider on every side: more than single precision loses here.
  vec2 first = vec2(ends.xy - tile_origin * int(units)) / units;
  vec2 last = vec2(ends.zw - tile_origin * int(units)) / units;
  float size = length(last - first);
  vec2 along = size > 0.0 ? (last - first) / size : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  float reach = radius / units + 0.25;
  bool at_end = corner == 1 || corner == 2 || corner == 4;
  bool at_right = corner == 2 || corner == 4 || corner == 5;
  vec2 place = (at_end ? last + along * reach : first - along * reach) + (at_right ? across : -across) * reach;
  gl_Position = vec4(2.0 * place / float(tile_size) - 1.0, 0.0, 1.0);
}
)";

constexpr const char* fragment_source = R"(#version 330 core
uniform ivec2 tile_origin;
flat in ivec4 ends;
flat in float radius;
flat in vec3 colour;
out vec4 sample_colour;

void main() {
  ivec2 here = (ivec2(gl_FragCoord.xy) + tile_origin) * 256 + 128;
  vec2 offset = vec2(here - ends.xy);
  vec2 axis = vec2(ends.zw - ends.xy);
  float square = dot(axis, axis);
  float share = square > 0.0 ? clamp(dot(offset, axis) / square, 0.0, 1.0) : 0.0;
  vec2 away = offset - share * axis;
  if (dot(away, away) > radius * radius) discard;
  sample_colour = vec4(colour, 1.0);
}
)";

/// One bar as GL reads it: two texels of four 32-bit integers.
struct PackedBar {
  std::int32_t x0, y0, x1, y1;  ///< ends, units
  std::int32_t radius;          ///< units
  std::int32_t colour;          ///< r + 256 g + 65536 b
  std::int32_t unused[2];
};
static_assert(sizeof(PackedBar) == 32);

/// Turns positions of the scene into units, counted from the upper left corner of the plot area. x is rounded from the
/// middle of the window outwards, so that a mirrored pile gives the mirrored picture.
class Projection {
 public:
  Projection(const Scene& scene, const ColourScale& scale)
      : scene_(scene),
        scale_(scale),
        middle_(0.5 * (scene.extent.x0 + scene.extent.x1)),
        units_per_diameter_(scene.pixels_per_diameter * samples_per_axis * units_per_sample),
        middle_units_(scene.plot_width_px * samples_per_axis * (units_per_sample / 2)) {}

  PackedBar pack(const ContactBar& bar) const {
    const Stroke stroke = stroke_of(scale_, bar.strength, bar.width, scene_.pixels_per_diameter);
    const double radius = 0.5 * stroke.width_px * samples_per_axis * units_per_sample;
    return {across(bar.x0),
            down(bar.z0),
            across(bar.x1),
            down(bar.z1),
            static_cast<std::int32_t>(std::lround(radius)),
            stroke.colour.r + 256 * stroke.colour.g + 65536 * stroke.colour.b,
            {0, 0}};
  }

  /// First and last tile (of edge tile_px) that the bar may reach, in x and y. A bar beside the plot area counts to the
  /// tile next to it.
  std::array<int, 4> tiles_of(const ContactBar& bar, int tile_px, int tile_columns, int tile_rows) const {
    // Half of the largest width a bar may have for its strength, at least one sample, and a pixel for the rounding.
    const double reach = 0.5 * bar.width * scene_.pixels_per_diameter + 2;
    const double left = (std::min(bar.x0, bar.x1) - scene_.extent.x0) * scene_.pixels_per_diameter - reach;
    const double right = (std::max(bar.x0, bar.x1) - scene_.extent.x0) * scene_.pixels_per_diameter + reach;
    const double top = (std::min(bar.z0, bar.z1) - scene_.extent.z0) * scene_.pixels_per_diameter - reach;
    const double bottom = (std::max(bar.z0, bar.z1) - scene_.extent.z0) * scene_.pixels_per_diameter + reach;
    const auto tile = [tile_px](double pixel, int count) {
      return static_cast<int>(std::clamp(std::floor(pixel / tile_px), 0.0, static_cast<double>(count - 1)));
    };
    return {tile(left, tile_columns), tile(right, tile_columns), tile(top, tile_rows), tile(bottom, tile_rows)};
  }

 private:
  std::int32_t across(double x) const {
    return middle_units_ + static_cast<std::int32_t>(std::lround((x - middle_) * units_per_diameter_));
  }
  std::int32_t down(double z) const {
    return static_cast<std::int32_t>(std::lround((z - scene_.extent.z0) * units_per_diameter_));
  }

  const Scene& scene_;
  const ColourScale& scale_;
  double middle_;
  double units_per_diameter_;
  std::int32_t middle_units_;
};

/// Which bars reach which tile: the bars of tile t are entries[first[t]] .. entries[first[t + 1]], in drawing order.
struct TileLists {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> entries;
};

TileLists sort_into_tiles(const Scene& scene, const Projection& projection, int tile_px, int tile_columns,
                          int tile_rows) {
  const auto visit = [&](auto&& act) {
    for (std::size_t i = 0; i < scene.bars.size(); ++i) {
      const auto [left, right, top, bottom] = projection.tiles_of(scene.bars[i], tile_px, tile_columns, tile_rows);
      for (int row = top; row <= bottom; ++row) {
        for (int column = left; column <= right; ++column) {
          act(static_cast<std::size_t>(row) * static_cast<std::size_t>(tile_columns) + static_cast<std::size_t>(column),
              i);
        }
      }
    }
  };
  TileLists lists;
  lists.first.resize(static_cast<std::size_t>(tile_columns) * static_cast<std::size_t>(tile_rows) + 1);
  visit([&](std::size_t tile, std::size_t) { ++lists.first[tile + 1]; });
  for (std::size_t t = 1; t < lists.first.size(); ++t) lists.first[t] += lists.first[t - 1];
  lists.entries.resize(lists.first.back());
  std::vector<std::size_t> next(lists.first.begin(), lists.first.end() - 1);
  visit([&](std::size_t tile, std::size_t bar) { lists.entries[next[tile]++] = static_cast<std::uint32_t>(bar); });
  return lists;
}

/// Mean of samples_per_axis² samples for each pixel of a tile; `samples` has rows of `stride` RGBA samples.
void average_into(const std::vector<std::uint8_t>& samples, int stride, int left, int top, int width, int height,
                  Image& image) {
  constexpr unsigned count = samples_per_axis * samples_per_axis;
  for (int y = 0; y < height; ++y) {
    std::uint8_t* pixel = &image.rgba[image.offset(left, top + y)];
    for (int x = 0; x < width; ++x, pixel += 4) {
      std::array<unsigned, 3> sum{};
      for (int row = 0; row < samples_per_axis; ++row) {
        const std::uint8_t* sample =
            &samples[4 * (static_cast<std::size_t>(y * samples_per_axis + row) * static_cast<std::size_t>(stride) +
                          static_cast<std::size_t>(x * samples_per_axis))];
        for (int column = 0; column < samples_per_axis; ++column, sample += 4) {
          for (std::size_t c = 0; c < 3; ++c) sum[c] += sample[c];
        }
      }
      for (std::size_t c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>((sum[c] + count / 2) / count);
    }
  }
}

/// Draws bars into the framebuffer bound at construction.
class BarProgram {
 public:
  BarProgram(const GlContext& context, int tile_samples)
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
    gl_.Uniform1i(program_.uniform("bars"), 0);
    gl_.Uniform1i(program_.uniform("tile_size"), tile_samples);
    origin_ = program_.uniform("tile_origin");
    check_gl(context_, "setting up its program");
  }

  void set_origin(int x, int y) { gl_.Uniform2i(origin_, x, y); }

  void draw(std::span<const PackedBar> bars) {
    gl_.BufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(bars.size_bytes()), bars.data(), GL_STREAM_DRAW);
    gl_.TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32I, buffer_.id());
    gl_.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(6 * bars.size()));
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

}  // namespace

void paint_plot_area(const Scene& scene, const ColourScale& scale, GlContext& context, int tile_px, int left, int top,
                     Image& image) {
  if (scene.bars.empty()) return;
  tile_px = std::min(tile_px, std::max(scene.plot_width_px, scene.plot_height_px));
  const int tile_samples = tile_px * samples_per_axis;
  if (tile_px < 1 || tile_samples > context.max_size()) {
    throw EnvironmentError(fmt::format(
        "a tile of {} samples is more than {} can draw ({}), and the rest would stay blank; use smaller tiles",
        tile_samples, context.renderer(), context.max_size()));
  }
  const int tile_columns = (scene.plot_width_px + tile_px - 1) / tile_px;
  const int tile_rows = (scene.plot_height_px + tile_px - 1) / tile_px;
  const Projection projection(scene, scale);
  const TileLists lists = sort_into_tiles(scene, projection, tile_px, tile_columns, tile_rows);

  context.make_current();
  const GlFunctions& gl = context.gl();
  const GlFramebuffer framebuffer(context, tile_samples, tile_samples);
  BarProgram program(context, tile_samples);
  gl.Viewport(0, 0, tile_samples, tile_samples);
  gl.Disable(GL_DITHER);
  gl.Disable(GL_BLEND);
  gl.PixelStorei(GL_PACK_ALIGNMENT, 4);
  const Rgb page = scale.page();
  gl.ClearColor(static_cast<float>(page.r) / 255.0F, static_cast<float>(page.g) / 255.0F,
                static_cast<float>(page.b) / 255.0F, 1.0F);

  std::vector<PackedBar> batch;
  std::vector<std::uint8_t> samples;
  for (int row = 0; row < tile_rows; ++row) {
    for (int column = 0; column < tile_columns; ++column) {
      const auto tile =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(tile_columns) + static_cast<std::size_t>(column);
      const auto begin = lists.first[tile], end = lists.first[tile + 1];
      if (begin == end) continue;  // nothing but page
      gl.Clear(GL_COLOR_BUFFER_BIT);
      program.set_origin(column * tile_samples, row * tile_samples);
      for (std::size_t entry = begin; entry < end;) {
        const std::size_t stop = std::min(end, entry + batch_size);
        batch.clear();
        for (; entry < stop; ++entry) batch.push_back(projection.pack(scene.bars[lists.entries[entry]]));
        program.draw(batch);
      }
      // Rows of the framebuffer count upwards and are read upwards: its row 0 is the uppermost one of the picture.
      const int width = std::min(tile_px, scene.plot_width_px - column * tile_px);
      const int height = std::min(tile_px, scene.plot_height_px - row * tile_px);
      const int stride = width * samples_per_axis;
      samples.resize(4 * static_cast<std::size_t>(stride) * static_cast<std::size_t>(height * samples_per_axis));
      gl.ReadPixels(0, 0, stride, height * samples_per_axis, GL_RGBA, GL_UNSIGNED_BYTE, samples.data());
      check_gl(context, "drawing the plot area");
      average_into(samples, stride, left + column * tile_px, top + row * tile_px, width, height, image);
    }
  }
}

}  // namespace granuscope
