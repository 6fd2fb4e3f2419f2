#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "render/palette.h"
#include "render/scene.h"

namespace granuscope {
/// Positions in a picture are whole numbers of 1/256 sample, counted from the upper left corner of the plot area.
/// Whether a sample lies in an element is then decided from differences of whole numbers, the same for whatever part of
/// the picture is painted at a time.
inline constexpr int units_per_sample = 256;

/// One element on that grid, as GL reads it: two texels of four 32-bit integers.
struct PackedElement {
  std::int32_t x0, y0, x1, y1;  ///< ends, units
  std::int32_t radius;          ///< units; -1: a box
  std::int32_t level;
  std::int32_t unused[2];
};
static_assert(sizeof(PackedElement) == 32);

/// Turns positions of the scene into units. x is rounded from the middle of the window outwards, so that a mirrored
/// pile gives the mirrored picture. The scene must outlive it.
class Projection {
 public:
  /// `samples`: along each edge of a pixel.
  Projection(const Scene& scene, int samples);
  PackedElement pack(const Element& element) const;

 private:
  std::int32_t across(double x) const;
  std::int32_t down(double z) const;

  const Scene& scene_;
  double middle_;
  double units_per_diameter_;
  std::int32_t middle_units_;
};

/// The rows of a picture on their way from the painter to whoever takes them, so that only some are in memory. They are
/// opened blank from the top, painted on, finished with what lies over them, and passed on when the next are opened.
class PictureRows {
 public:
  /// An image of whole rows, the first of them at row `top` of the picture.
  using Rows = std::function<void(Image& rows, int top)>;

  /// `finish` paints over rows that are complete otherwise, `take` gets them; either may be empty.
  PictureRows(int width, int height, Rgb blank, std::uint8_t alpha, Rows finish, Rows take);

  /// The next rows, at most those that are left; valid until the next call.
  Image& open(int rows);
  /// Opens and passes on blank rows.
  void pass(int rows);
  /// Passes on the last rows.
  void close();
  int opened() const { return next_; }

 private:
  Image rows_;
  int width_, height_;
  Rgb blank_;
  std::uint8_t alpha_;
  Rows finish_, take_;
  int top_ = 0, next_ = 0;
};

/// Rows that are passed on together where nothing else says how many: some MB of the widest picture.
inline constexpr int rows_at_once = 64;

/// How each level of a scene meets the samples of the picture.
struct LevelTable {
  std::array<Rgb, 256> colour{};        ///< on the page
  std::array<Rgb, 256> full_colour{};   ///< as on paper, whatever the size of a sample
  std::array<std::uint8_t, 256> ink{};  ///< share of the sample that is covered, of 255: for a transparent background
  std::array<bool, 256> visible{};      ///< false where the colour rounds to the page's
};

/// A bar thinner than one sample would be hit or missed by chance; it is painted one sample wide instead, its colour
/// thinned out by the same factor. Where that colour rounds to the page's, at the 8 bits of the image, the bar cannot
/// be seen: width and colour map together decide.
LevelTable make_level_table(const ColourScale& scale, const ValueScale& values, Glyph glyph,
                            double samples_per_diameter);

/// Levels of the lines over a picture, above those of its values.
inline constexpr std::uint8_t solid_line_level = 255;
inline constexpr std::uint8_t dashed_line_level = 254;
inline constexpr int levels_below_lines = 253;

/// Turns samples, one level each, into pixels: each pixel is the mean of the colours of the samples inside it.
class SampleAverager {
 public:
  /// Pixel x of a row is made of the samples first_sample[x] .. first_sample[x + 1] - 1. `opaque`: samples of level 0
  /// are page, and ink thins to page; otherwise both become transparent.
  SampleAverager(const LevelTable& table, Background background, std::vector<std::size_t> first_sample);

  /// One row of samples, first_sample.back() of them.
  void add_row(const std::uint8_t* samples);
  /// Writes the pixels of the rows added since the last call to the image, starting at (left, y). Without any row the
  /// pixels stay as they are.
  void write_pixels(Image& image, int left, int y);

 private:
  void spill();

  std::vector<std::size_t> first_sample_;
  Background background_;
  bool grey_ = true;  ///< all colours are, so that one sum does for three
  std::array<std::uint64_t, 256> packed_{};
  std::array<std::uint8_t, 256> ink_{};
  std::vector<std::uint64_t> packed_sums_;
  std::vector<std::array<std::uint32_t, 3>> sums_;
  std::vector<std::uint32_t> ink_sums_;
  std::size_t rows_ = 0, rows_packed_ = 0, rows_before_spill_ = 1;
};

}  // namespace granuscope
