#include "report/png_size.h"

#include <cstdint>

namespace granuscope {

namespace {

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t number = 0;
  for (const char byte : bytes.substr(0, 4)) number = number << 8U | static_cast<unsigned char>(byte);
  return number;
}

}  // namespace

std::optional<double> png_width_mm(std::string_view png) {
  constexpr std::string_view signature = "\x89PNG\r\n\x1a\n";
  constexpr std::size_t chunk_frame = 12;  // length, type, checksum
  if (!png.starts_with(signature)) return std::nullopt;
  std::uint32_t width = 0;
  for (std::size_t at = signature.size(); at + chunk_frame <= png.size();) {
    const std::size_t length = big_endian(png.substr(at));
    const std::string_view type = png.substr(at + 4, 4);
    if (length > png.size() - at - chunk_frame) return std::nullopt;
    const std::string_view content = png.substr(at + 8, length);
    if (type == "IHDR" && length >= 4) width = big_endian(content);
    if (type == "pHYs" && length == 9 && content[8] == 1) {  // unit: pixels per metre
      const std::uint32_t per_metre = big_endian(content);
      if (per_metre == 0 || width == 0) return std::nullopt;
      return 1000.0 * width / per_metre;
    }
    if (type == "IDAT") return std::nullopt;
    at += chunk_frame + length;
  }
  return std::nullopt;
}

}  // namespace granuscope
