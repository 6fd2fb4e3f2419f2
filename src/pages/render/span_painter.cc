#include "render/painter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "render/sample_grid.h"
#include "support/progress.h"

namespace granuscope {
namespace {

/// Samples that are in memory at a time, about: what a processor's cache holds.
constexpr std::int64_t samples_wanted = std::int64_t{2} << 20;

/// Rows of pixels painted at a time.
int rows_of_band(const Scene& scene, int samples) {
  const std::int64_t row = std::max<std::int64_t>(1, std::int64_t{scene.plot_width_px} * samples * samples);
  return static_cast<int>(std::clamp<std::int64_t>(samples_wanted / row, 8, 512));
}

/// The rows of samples of one band.
class SampleBand {
 public:
  SampleBand(int width, int rows) : width_(width), rows_(rows), levels_(size() + at_once) {}

  /// From sample row `first` on.
  void begin(int first) {
    first_ = first;
    std::fill(levels_.begin(), levels_.end(), std::uint8_t{0});
  }
  int first() const { return first_; }
  int last() const { return first_ + rows_ - 1; }
  int width() const { return width_; }
  const std::uint8_t* row(int number) const { return levels_.data() + place(number); }

  /// The higher level is seen, from sample `from` to sample `to` of a row.
  void lay(int row, std::int64_t from, std::int64_t to, std::uint8_t level) {
    from = std::max<std::int64_t>(from, 0);
    to = std::min<std::int64_t>(to, width_ - 1);
    if (from > to) return;
    std::uint8_t* out = levels_.data() + place(row) + from;
    auto left = static_cast<std::size_t>(to - from + 1);
    for (; left > at_once; left -= at_once, out += at_once) raise(out, level, at_once);
    raise(out, level, left);
  }

 private:
  std::size_t size() const { return static_cast<std::size_t>(width_) * static_cast<std::size_t>(rows_); }
  std::size_t place(int row) const { return static_cast<std::size_t>(row - first_) * static_cast<std::size_t>(width_); }

  static constexpr std::size_t at_once = 16;
  using Samples = std::array<std::uint8_t, at_once>;

  /// The first `count` samples of those at once; level 0 leaves the others as they are. Through copies, which cannot
  /// overlap, so that the compiler takes all at once.
  static void raise(std::uint8_t* out, std::uint8_t level, std::size_t count) {
    static constexpr auto these = [] {
      std::array<std::uint8_t, 2 * at_once> ones_and_zeros{};
      std::fill_n(ones_and_zeros.begin(), at_once, std::uint8_t{0xFF});
      return ones_and_zeros;
    }();
    Samples seen, mask;  // NOLINT(cppcoreguidelines-pro-type-member-init): filled next
    std::memcpy(seen.data(), out, at_once);
    std::memcpy(mask.data(), these.data() + at_once - count, at_once);
    for (std::size_t k = 0; k < at_once; ++k) seen[k] = std::max(seen[k], static_cast<std::uint8_t>(mask[k] & level));
    std::memcpy(out, seen.data(), at_once);
  }

  int width_, rows_, first_ = 0;
  std::vector<std::uint8_t> levels_;
};

/// Centre of a sample, units.
std::int64_t centre(std::int64_t sample) { return sample * units_per_sample + units_per_sample / 2; }
/// First sample whose centre is not left of this place.
std::int64_t sample_from(double units) {
  return static_cast<std::int64_t>(std::ceil((units - 0.5 * units_per_sample) / units_per_sample));
}

void lay_box(const PackedElement& box, SampleBand& band) {
  const std::int64_t from = sample_from(box.x0), to = sample_from(box.x1) - 1;
  const auto top = std::max<std::int64_t>(sample_from(box.y0), band.first());
  const auto bottom = std::min<std::int64_t>(sample_from(box.y1) - 1, band.last());
  for (std::int64_t y = top; y <= bottom; ++y) {
    band.lay(static_cast<int>(y), from, to, static_cast<std::uint8_t>(box.level));
  }
}

/// A bar with round ends, row by row.
class BarSpans {
 public:
  explicit BarSpans(const PackedElement& bar) : bar_(bar), radius_(bar.radius) {
    const double dx = double{1} * bar.x1 - bar.x0, dy = double{1} * bar.y1 - bar.y0;
    length_ = std::sqrt(dx * dx + dy * dy);
    if (length_ > 0) {
      along_x_ = dx / length_;
      along_y_ = dy / length_;
    }
    per_x_ = along_x_ != 0 ? 1 / along_x_ : 0;
    per_y_ = along_y_ != 0 ? 1 / along_y_ : 0;
    // What single precision may lose of a distance, many times over.
    doubt_ = 2e-6 * (radius_ + length_) + 1e-3;
    // Places are reckoned a little outside, and what lies near the edge is then tried.
    reach_ = radius_ + doubt_;
    steep_ = std::abs(along_y_) < shallow;
  }

  void lay(SampleBand& band) const {
    const double y0 = bar_.y0, y1 = bar_.y1;
    const auto top = std::max<std::int64_t>(sample_from(std::min(y0, y1) - reach_), band.first());
    const auto bottom = std::min<std::int64_t>(sample_from(std::max(y0, y1) + reach_), band.last());
    for (std::int64_t y = top; y <= bottom; ++y) lay_row(y, band);
  }

 private:
  /// Edges whose normal has a smaller part along the row are tried sample by sample.
  static constexpr double shallow = 0.1;

  void lay_row(std::int64_t row, SampleBand& band) const {
    const auto y = static_cast<double>(centre(row));
    Span span;
    add_end(bar_.x0, y - bar_.y0, span);
    add_end(bar_.x1, y - bar_.y1, span);
    add_body(y - bar_.y0, span);
    if (span.left > span.right) return;
    std::int64_t from = sample_from(span.left), to = sample_from(span.right) - 1;
    // Outside the band's width nothing is laid, and so nothing need be tried.
    from = std::max<std::int64_t>(from, -1);
    to = std::min<std::int64_t>(to, band.width());
    const double near = 2 * doubt_ / shallow;
    if (span.tried || static_cast<double>(centre(from)) - span.left < near) {
      while (from <= to && !inside(from, row)) ++from;
    }
    if (span.tried || span.right - static_cast<double>(centre(to)) < near) {
      while (from <= to && !inside(to, row)) --to;
    }
    band.lay(static_cast<int>(row), from, to, static_cast<std::uint8_t>(bar_.level));
  }

  /// What a row has of a bar, units; empty at first.
  struct Span {
    double left = std::numeric_limits<double>::infinity(), right = -std::numeric_limits<double>::infinity();
    bool tried = false;  ///< both ends are to be tried
  };

  void add_end(double x, double below, Span& span) const {
    const double square = reach_ * reach_ - below * below;
    if (square < 0) return;
    const double half = std::sqrt(square);
    span.left = std::min(span.left, x - half);
    span.right = std::max(span.right, x + half);
    // Where the arc's edge is shallow, unless the body's covers it.
    span.tried = span.tried || half < shallow * reach_;
  }

  /// The part between the ends: at most reach_ across, and between 0 and length_ along.
  void add_body(double below, Span& span) const {
    if (length_ <= 0) return;
    double left = -std::numeric_limits<double>::infinity(), right = std::numeric_limits<double>::infinity();
    if (along_y_ != 0) {
      const double middle = below * along_x_ * per_y_, half = reach_ * std::abs(per_y_);
      left = middle - half;
      right = middle + half;
    } else if (std::abs(below) > reach_) {
      return;
    }
    if (along_x_ != 0) {
      const double start = -below * along_y_ * per_x_, end = start + length_ * per_x_;
      left = std::max(left, std::min(start, end));
      right = std::min(right, std::max(start, end));
    } else if (below * along_y_ < 0 || below * along_y_ > length_) {
      return;
    }
    if (left > right) return;
    span.left = std::min(span.left, bar_.x0 + left);
    span.right = std::max(span.right, bar_.x0 + right);
    span.tried = span.tried || steep_;
  }

  /// As the fragment shader of render/painter.cc decides it, in single precision.
  bool inside(std::int64_t column, std::int64_t row) const {
    const auto offset_x = static_cast<float>(static_cast<std::int32_t>(centre(column)) - bar_.x0);
    const auto offset_y = static_cast<float>(static_cast<std::int32_t>(centre(row)) - bar_.y0);
    const auto axis_x = static_cast<float>(bar_.x1 - bar_.x0), axis_y = static_cast<float>(bar_.y1 - bar_.y0);
    const float square = axis_x * axis_x + axis_y * axis_y;
    const float share = square > 0 ? std::clamp((offset_x * axis_x + offset_y * axis_y) / square, 0.0F, 1.0F) : 0.0F;
    const float away_x = offset_x - share * axis_x, away_y = offset_y - share * axis_y;
    const auto radius = static_cast<float>(bar_.radius);
    return away_x * away_x + away_y * away_y <= radius * radius;
  }

  const PackedElement& bar_;
  double radius_, length_ = 0, along_x_ = 0, along_y_ = 0, per_x_ = 0, per_y_ = 0;
  double doubt_ = 0, reach_ = 0;
  bool steep_ = false;
};

/// Where the elements of a band may lie, as region_of() of a row of tiles.
Extent region_of(const Scene& scene, int first_row, int rows) {
  const double margin = 1 / scene.pixels_per_diameter;  // for rounding, and for bars painted a sample wide
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double z0 = scene.extent.z0 + first_row / scene.pixels_per_diameter;
  const double z1 = scene.extent.z0 + (first_row + rows) / scene.pixels_per_diameter;
  return {-infinity, infinity, first_row == 0 ? -infinity : z0 - margin,
          first_row + rows >= scene.plot_height_px ? infinity : z1 + margin};
}

}  // namespace

void paint_spans(const Scene& scene, const LevelTable& table, Background background, int left, PictureRows& rows) {
  const int samples = samples_per_axis(scene.pixels_per_diameter);
  const int width = scene.plot_width_px * samples;
  std::vector<std::size_t> first_sample;
  for (int x = 0; x <= scene.plot_width_px; ++x)
    first_sample.push_back(static_cast<std::size_t>(x) * static_cast<std::size_t>(samples));
  SampleAverager averager(table, background, first_sample);

  const Projection projection(scene, samples);
  const int band_rows = std::min(rows_of_band(scene, samples), scene.plot_height_px);
  SampleBand band(width, band_rows * samples);
  for (int first = 0; first < scene.plot_height_px; first += band_rows) {
    throw_if_interrupted();
    const int height = std::min(band_rows, scene.plot_height_px - first);
    band.begin(first * samples);
    scene.elements(region_of(scene, first, height), [&](const Element& element) {
      const PackedElement packed = projection.pack(element);
      if (packed.radius < 0) {
        lay_box(packed, band);
      } else {
        BarSpans(packed).lay(band);
      }
    });
    Image& image = rows.open(height);
    for (int y = 0; y < height; ++y) {
      for (int k = 0; k < samples; ++k) averager.add_row(band.row((first + y) * samples + k));
      averager.write_pixels(image, left, y);
    }
  }
}

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
