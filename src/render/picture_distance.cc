#include "render/picture_distance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "support/error.h"

namespace granuscope {

PictureDistance distance(const Image& first, const Image& second) {
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

}  // namespace granuscope
