#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "render/palette.h"

namespace granuscope {

/// Keyword and text of what an image carries beside its pixels (UTF-8; a keyword has 1 to 79 ASCII characters).
using ImageMetadata = std::vector<std::pair<std::string, std::string>>;

/// How the pixels of a file are stored: as few channels as lose nothing.
enum class Channels { grey, rgb, rgba };

/// Pixels in sRGB, 8 bits a channel, rows from the top, four bytes R G B A a pixel (A not premultiplied).
struct Image {
  Image() = default;
  /// An image of one colour.
  Image(int width_px, int height_px, Rgb colour, std::uint8_t alpha = 255) : width(width_px), height(height_px) {
    fill(colour, alpha);
  }

  /// Gives all pixels, as many as width and height tell, one colour.
  void fill(Rgb colour, std::uint8_t alpha) {
    rgba.resize(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::size_t i = 0; i < rgba.size(); i += 4) {
      rgba[i] = colour.r;
      rgba[i + 1] = colour.g;
      rgba[i + 2] = colour.b;
      rgba[i + 3] = alpha;
    }
  }

  std::size_t offset(int x, int y) const {
    return 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
  Rgb at(int x, int y) const { return {rgba[offset(x, y)], rgba[offset(x, y) + 1], rgba[offset(x, y) + 2]}; }

  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;
};

}  // namespace granuscope
