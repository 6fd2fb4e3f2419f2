#include "render/sample_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace granuscope {
namespace {

/// Far outside (elements that are painted although they lie beside the window) one place is as good as another.
std::int32_t units(double value) {
  constexpr double far = 1 << 29;
  return static_cast<std::int32_t>(std::lround(std::clamp(value, -far, far)));
}

}  // namespace

Projection::Projection(const Scene& scene, int samples)
    : scene_(scene),
      middle_(0.5 * (scene.extent.x0 + scene.extent.x1)),
      units_per_diameter_(scene.pixels_per_diameter * samples * units_per_sample),
      middle_units_(scene.plot_width_px * samples * (units_per_sample / 2)) {}

PackedElement Projection::pack(const Element& element) const {
  PackedElement packed{
      across(element.x0), down(element.z0), across(element.x1), down(element.z1), -1, element.level, {0, 0}};
  if (element.outline == Outline::bar) {
    // At least a sample wide; see make_level_table().
    const double width = std::max(element.width * units_per_diameter_, static_cast<double>(units_per_sample));
    packed.radius = static_cast<std::int32_t>(std::lround(0.5 * width));
  }
  return packed;
}

std::int32_t Projection::across(double x) const { return middle_units_ + units((x - middle_) * units_per_diameter_); }
std::int32_t Projection::down(double z) const { return units((z - scene_.extent.z0) * units_per_diameter_); }

namespace {

/// The sums of the three channels share one word.
constexpr unsigned field_bits = 21;
constexpr std::uint64_t field_mask = (std::uint64_t{1} << field_bits) - 1;

}  // namespace

SampleAverager::SampleAverager(const LevelTable& table, Background background, std::vector<std::size_t> first_sample)
    : first_sample_(std::move(first_sample)), background_(background) {
  const bool opaque = background == Background::page;
  for (std::size_t level = 0; level < packed_.size(); ++level) {
    Rgb colour = opaque ? table.colour[level] : table.full_colour[level];
    ink_[level] = opaque ? 255 : table.ink[level];
    grey_ = grey_ && colour.r == colour.g && colour.g == colour.b;
    if (!opaque) {  // a colour counts by its ink
      const auto thinned = [&](std::uint8_t channel) {
        return static_cast<std::uint8_t>((channel * ink_[level] + 127) / 255);
      };
      colour = {thinned(colour.r), thinned(colour.g), thinned(colour.b)};
    }
    packed_[level] =
        std::uint64_t{colour.r} | std::uint64_t{colour.g} << field_bits | std::uint64_t{colour.b} << (2 * field_bits);
  }
  const std::size_t width = first_sample_.size() - 1;
  packed_sums_.resize(width);
  sums_.resize(width);
  if (!opaque) ink_sums_.resize(width);
  std::size_t widest = 1;
  for (std::size_t x = 0; x < width; ++x) widest = std::max(widest, first_sample_[x + 1] - first_sample_[x]);
  rows_before_spill_ = std::max<std::size_t>(1, field_mask / (255 * widest));
}

void SampleAverager::add_row(const std::uint8_t* samples) {
  for (std::size_t x = 0; x < packed_sums_.size(); ++x) {
    std::uint64_t sum = packed_sums_[x];
    for (std::size_t i = first_sample_[x]; i < first_sample_[x + 1]; ++i) sum += packed_[samples[i]];
    packed_sums_[x] = sum;
  }
  for (std::size_t x = 0; x < ink_sums_.size(); ++x) {
    for (std::size_t i = first_sample_[x]; i < first_sample_[x + 1]; ++i) ink_sums_[x] += ink_[samples[i]];
  }
  ++rows_;
  if (++rows_packed_ == rows_before_spill_) spill();
}

void SampleAverager::spill() {
  for (std::size_t x = 0; x < packed_sums_.size(); ++x) {
    for (std::size_t c = 0; c < 3; ++c) {
      sums_[x][c] += static_cast<std::uint32_t>(packed_sums_[x] >> (c * field_bits) & field_mask);
    }
    packed_sums_[x] = 0;
  }
  rows_packed_ = 0;
}

void SampleAverager::write_pixels(Image& image, int left, int y) {
  if (rows_ == 0) return;
  if (rows_packed_ > 0) spill();
  std::uint8_t* pixel = &image.rgba[image.offset(left, y)];
  // Division by a constant number as multiplication: exact while sum < 2^40 / divisor, and sums are below 2^21 or so.
  constexpr unsigned shift = 40;
  std::uint64_t divisor = 0, inverse = 0;
  for (std::size_t x = 0; x < sums_.size(); ++x, pixel += 4) {
    auto& sum = sums_[x];
    std::uint64_t count = rows_ * (first_sample_[x + 1] - first_sample_[x]);
    if (background_ == Background::transparent) {
      const std::uint64_t ink = ink_sums_[x];
      pixel[3] = static_cast<std::uint8_t>(count == 0 ? 0 : (ink + count / 2) / count);
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint64_t whole = ink == 0 ? 0 : (255 * std::uint64_t{sum[c]} + ink / 2) / ink;
        pixel[c] = pixel[3] == 0 ? 0 : static_cast<std::uint8_t>(std::min<std::uint64_t>(whole, 255));
      }
      ink_sums_[x] = 0;
    } else if (count > 0) {
      if (count != divisor) {
        divisor = count;
        inverse = ((std::uint64_t{1} << shift) + count - 1) / count;
      }
      const auto mean = [&](std::uint32_t total) {
        return static_cast<std::uint8_t>((total + divisor / 2) * inverse >> shift);
      };
      pixel[0] = mean(sum[0]);
      pixel[1] = grey_ ? pixel[0] : mean(sum[1]);
      pixel[2] = grey_ ? pixel[0] : mean(sum[2]);
    }
    sum = {};
  }
  rows_ = 0;
}

PictureRows::PictureRows(int width, int height, Rgb blank, std::uint8_t alpha, Rows finish, Rows take)
    : width_(width),
      height_(height),
      blank_(blank),
      alpha_(alpha),
      finish_(std::move(finish)),
      take_(std::move(take)) {}

Image& PictureRows::open(int rows) {
  close();
  rows_.width = width_;
  rows_.height = std::min(rows, height_ - next_);
  rows_.fill(blank_, alpha_);
  top_ = next_;
  next_ += rows_.height;
  return rows_;
}

void PictureRows::pass(int rows) {
  for (const int end = std::min(next_ + rows, height_); next_ < end;) open(std::min(rows_at_once, end - next_));
}

void PictureRows::close() {
  if (rows_.height == 0) return;
  if (finish_) finish_(rows_, top_);
  if (take_) take_(rows_, top_);
  rows_.height = 0;
}

double width_of(Glyph glyph, double strength) {
  switch (glyph) {
    case Glyph::force_bar:
      return widest_bar * std::abs(strength);
    case Glyph::even_bar:
      return even_bar_width;
    case Glyph::bead:
    case Glyph::cell:
      return 1;
  }
  return 0;
}

int samples_per_axis(double pixels_per_diameter) {
  constexpr double fewest = 4, most = 64;
  constexpr double per_diameter = 8;
  return static_cast<int>(std::clamp(std::ceil(per_diameter / pixels_per_diameter), fewest, most));
}

LevelTable make_level_table(const ColourScale& scale, const ValueScale& values, Glyph glyph,
                            double samples_per_diameter) {
  LevelTable table;
  for (std::size_t level = 0; level < 256; ++level) {
    const bool disc = static_cast<int>(level) == values.disc_level;
    if (disc || static_cast<int>(level) > values.most_levels) {
      const Rgb line = Palette::builtin().colour(disc ? "disc" : level == solid_line_level ? "ray" : "envelope");
      table.colour[level] = table.full_colour[level] = line;
      table.ink[level] = 255;
      table.visible[level] = true;
      continue;
    }
    const double strength = values.strength(static_cast<std::uint8_t>(level));
    const double ink = std::min(width_of(glyph, strength) * samples_per_diameter, 1.0);
    table.full_colour[level] = scale.at(strength);
    table.colour[level] = scale.at(strength, ink);
    table.visible[level] = table.colour[level] != scale.page();
    table.ink[level] = table.visible[level] ? static_cast<std::uint8_t>(std::lround(255 * ink)) : 0;
  }
  if (values.sign == Sign::both) {
    // Both signs of a step are seen or neither, so that none that is not seen hides one that is.
    for (std::size_t level = 2; level + 1 <= static_cast<std::size_t>(values.most_levels); level += 2) {
      table.visible[level] = table.visible[level + 1] = table.visible[level] || table.visible[level + 1];
    }
  }
  return table;
}

}  // namespace granuscope
