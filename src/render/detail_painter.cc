#include "render/detail_painter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <vector>

#include "render/sample_averager.h"
#include "support/interruption.h"

namespace granuscope {
namespace {

constexpr int across = detail_samples_per_diameter;  ///< samples per diameter
constexpr int down = 7;                              ///< rows of samples per layer, about as far apart as columns
constexpr double row_height = sqrt3 / 2 / down;      ///< diameters

/// Place of the first row below a bead's centre, in rows. Of the phases tried, at this one discs and bars of all widths
/// cover the share of samples that is nearest to their area (50 of 50.8 samples for a disc).
constexpr double row_phase = 0.25;

/// Rows that one layer's elements may cover: from half a diameter above their beads to half below the next ones.
constexpr int rows_above = 5, rows_below = down + 5;
/// A stamp is as wide as a register.
constexpr std::size_t stamp_width = 16;

using StampRow = std::array<std::uint8_t, stamp_width>;

/// The samples that an element covers, relative to its bead's centre: its level there, 0 elsewhere.
struct Stamp {
  int first_row = 0, rows = 0;
  int first_column = 0;
  std::array<StampRow, rows_above + rows_below> levels{};
};

Stamp make_stamp(double x1, double z1, double radius, std::uint8_t level) {
  Stamp stamp;
  // From the leftmost sample that may be reached; a bar is at most a diameter and a half wide with its ends.
  stamp.first_column = static_cast<int>(std::floor((std::min(0.0, x1) - radius) * across));
  bool any = false;
  for (int row = -rows_above; row < rows_below; ++row) {
    StampRow line{};
    bool hit = false;
    for (std::size_t k = 0; k < stamp_width; ++k) {
      const double x = (stamp.first_column + static_cast<int>(k) + 0.5) / across, z = (row + row_phase) * row_height;
      const double square = x1 * x1 + z1 * z1;
      const double share = square > 0 ? std::clamp((x * x1 + z * z1) / square, 0.0, 1.0) : 0;
      const double dx = x - share * x1, dz = z - share * z1;
      if (dx * dx + dz * dz > radius * radius) continue;
      line[k] = level;
      hit = true;
    }
    if (!hit) continue;
    if (!any) stamp.first_row = row;
    any = true;
    stamp.rows = row - stamp.first_row + 1;
    stamp.levels[static_cast<std::size_t>(row - stamp.first_row)] = line;
  }
  return stamp;
}

/// A row of samples of the window's width, with room for stamps that begin or end beside it. Rows are kept in a ring:
/// when a layer is stamped, only those from rows_above it on are still open.
class SampleRows {
 public:
  explicit SampleRows(std::size_t width) : stride_(width + 2 * stamp_width), samples_(ring * stride_) {}

  void lay(const Stamp& stamp, int bead_row, std::ptrdiff_t column) {
    for (int row = 0; row < stamp.rows; ++row) {
      std::uint8_t* out = line(bead_row + stamp.first_row + row) + column + stamp.first_column;
      // Copies, which cannot overlap, so that the compiler takes all sixteen at once.
      StampRow seen, laid = stamp.levels[static_cast<std::size_t>(row)];
      std::memcpy(seen.data(), out, stamp_width);
      for (std::size_t k = 0; k < stamp_width; ++k) seen[k] = std::max(seen[k], laid[k]);
      std::memcpy(out, seen.data(), stamp_width);
    }
  }
  const std::uint8_t* row(int number) { return line(number); }
  void clear(int number) { std::fill_n(line(number) - stamp_width, stride_, std::uint8_t{0}); }

 private:
  static constexpr std::size_t ring = 32;  ///< a power of two, above rows_above + rows_below
  static_assert(ring >= rows_above + rows_below + down);
  std::uint8_t* line(int number) {
    const int place = number + (1 << 30);  // rows above the pile have negative numbers
    return samples_.data() + (static_cast<std::size_t>(place) % ring) * stride_ + stamp_width;
  }

  std::size_t stride_;
  std::vector<std::uint8_t> samples_;
};

/// Pixel of a position in diameters from an edge of the extent; -1 or `pixels` outside.
int pixel_of(double position, double pixels_per_diameter, int pixels) {
  return static_cast<int>(std::clamp(std::floor(position * pixels_per_diameter), -1.0, static_cast<double>(pixels)));
}

}  // namespace

void paint_detail(const Scene& scene, const LevelTable& table, Background background, int left, PictureRows& picture) {
  const LatticeLevels& levels = *scene.detail;
  const Lattice& lattice = levels.values().lattice();
  const Extent& extent = scene.extent;

  // Stamps by level: side 0 and 1 of a layer, and those of the lowest layer, which are half as long.
  const bool beads = scene.glyph == Glyph::bead;
  std::array<std::vector<Stamp>, 4> stamps;
  for (std::size_t kind = 0; kind < 4; ++kind) {
    if (kind % 2 >= static_cast<std::size_t>(levels.values().sides())) continue;
    const double share = beads ? 0 : kind < 2 ? 1 : 0.5;
    for (int level = 0; level < 256; ++level) {
      const double width = width_of(scene.glyph, scene.values.strength(static_cast<std::uint8_t>(level)));
      const double radius = 0.5 * std::max(width, 1.0 / across);
      stamps[kind].push_back(make_stamp((kind % 2 == 0 ? -0.5 : 0.5) * share, share * (sqrt3 / 2), radius,
                                        static_cast<std::uint8_t>(level)));
    }
  }

  // Column c of the samples has its centre at x = base + (c + 1/2) / across.
  const int base = static_cast<int>(std::floor(extent.x0)) - 1;
  const int columns = (static_cast<int>(std::ceil(extent.x1)) + 1 - base) * across;
  const auto width = static_cast<std::size_t>(columns);
  std::vector<std::size_t> first_sample(static_cast<std::size_t>(scene.plot_width_px) + 1, width);
  for (std::size_t column = width; column-- > 0;) {
    const double x = base + (static_cast<double>(column) + 0.5) / across;
    const int pixel = pixel_of(x - extent.x0, scene.pixels_per_diameter, scene.plot_width_px);
    if (pixel >= 0 && pixel < scene.plot_width_px) first_sample[static_cast<std::size_t>(pixel)] = column;
    if (pixel == scene.plot_width_px) first_sample[static_cast<std::size_t>(pixel)] = column;
  }
  SampleAverager averager(table, background, first_sample);

  SampleRows rows(width + 2 * stamp_width);
  int open_pixel = -1;  // row of pixels that the samples since the last one belong to
  Image* image = nullptr;
  int first_pixel = 0, opened = 0;
  const auto write_pixels = [&] {
    if (open_pixel < 0 || open_pixel >= scene.plot_height_px) return;
    while (open_pixel >= opened) {
      first_pixel = opened;
      image = &picture.open(std::min(rows_at_once, scene.plot_height_px - opened));
      opened += image->height;
    }
    averager.write_pixels(*image, left, open_pixel - first_pixel);
  };
  const auto finish_row = [&](int number) {
    const double z = 0.5 + (number + row_phase) * row_height;
    const int pixel = pixel_of(z - extent.z0, scene.pixels_per_diameter, scene.plot_height_px);
    if (pixel != open_pixel) write_pixels();
    open_pixel = pixel;
    if (pixel >= 0 && pixel < scene.plot_height_px) averager.add_row(rows.row(number));
    rows.clear(number);
  };

  std::vector<std::uint8_t> row;
  const auto [first, last] = levels.layers(extent);
  int next_row = first * down - rows_above;  // the first that is not finished
  for (int layer = first; layer <= last; ++layer) {
    throw_if_interrupted();
    for (int side = 0; side < levels.values().sides(); ++side) {
      const std::size_t last_layer = layer + 1 < lattice.layers() ? 0 : 2;
      const auto& kind = stamps[static_cast<std::size_t>(side) + last_layer];
      const Places places = levels.places(layer, side, extent);
      row.resize(static_cast<std::size_t>(places.count()));
      levels.levels(layer, side, places.first, row);
      std::ptrdiff_t column = (places.first - base) * across + across / 2 * (layer % 2);
      for (const std::uint8_t level : row) {
        if (table.visible[level]) rows.lay(kind[level], layer * down, column);
        column += across;
      }
    }
    const int open_from = layer < last ? (layer + 1) * down - rows_above : layer * down + rows_below;
    for (; next_row < open_from; ++next_row) finish_row(next_row);
  }
  write_pixels();
  picture.pass(scene.plot_height_px - opened);
}

}  // namespace granuscope
