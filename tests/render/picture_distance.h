#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/scene.h"
#include "support/error.h"

namespace granuscope {

/// How far two pictures of one size are apart, in steps of 1/255, over all pixels and the channels R, G, B.
struct PictureDistance {
  double root_mean_square = 0;
  double blocks = 0;  ///< the same between means over blocks of 8 x 8 pixels, where the places of samples even out
  double mean = 0;    ///< of the second minus the first: what is darker or lighter as a whole
  double largest = 0;
};

/// Throws InputError if the sizes differ.
inline PictureDistance distance(const Image& first, const Image& second) {
  if (first.width != second.width || first.height != second.height || first.rgba.empty()) {
    throw InputError(fmt::format("pictures of {} x {} and {} x {} pixels cannot be compared; make them of one size",
                                 first.width, first.height, second.width, second.height));
  }
  constexpr int edge = 8;
  PictureDistance apart;
  double squares = 0, sum = 0, block_squares = 0;
  std::size_t blocks = 0;
  for (int top = 0; top < first.height; top += edge) {
    for (int left = 0; left < first.width; left += edge) {
      double in_block = 0, values = 0;
      for (int y = top; y < std::min(top + edge, first.height); ++y) {
        for (int x = left; x < std::min(left + edge, first.width); ++x) {
          for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t i = first.offset(x, y) + c;
            const double difference = static_cast<double>(second.rgba[i]) - first.rgba[i];
            squares += difference * difference;
            in_block += difference;
            values += 1;
            apart.largest = std::max(apart.largest, std::abs(difference));
          }
        }
      }
      sum += in_block;
      block_squares += in_block / values * (in_block / values);
      ++blocks;
    }
  }
  const double all = 3.0 * first.width * first.height;
  apart.root_mean_square = std::sqrt(squares / all);
  apart.mean = sum / all;
  apart.blocks = std::sqrt(block_squares / static_cast<double>(blocks));
  return apart;
}

/// What the level of detail may differ from the full picture (largest: anything). Both look at the same shapes at about
/// 16 places a pixel; an edge between black and white that falls between two places moves a pixel by 1/16 of 255; and
/// the 50 samples that a whole bead covers are 1.5 % fewer than its area, which lightens a picture of grey beads by
/// less than 2.
inline constexpr PictureDistance detail_distance{12, 2.5, 2, 255};

/// What another driver, or another release of it or of the font library, may differ. All decide by the same whole
/// numbers whether a sample lies in an element; only where rounding in single precision decides (the ends of slanted
/// bars) may a sample differ, 1/16 of a pixel or less. A letter's edge may be rounded to another of 64 places of a
/// pixel or be drawn with another gamma: on the few pixels of text, a step of up to 64.
inline constexpr PictureDistance renderer_distance{4, 2, 0.5, 96};

}  // namespace granuscope
