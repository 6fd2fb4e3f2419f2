#include "render/sample_averager.h"

#include <algorithm>
#include <utility>

namespace granuscope {
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

}  // namespace granuscope
