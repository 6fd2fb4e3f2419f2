#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/image.h"
#include "render/level_table.h"

namespace granuscope {

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
