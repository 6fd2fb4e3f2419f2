#pragma once
#include <png.h>

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "render/scene.h"
#include "support/files.h"

namespace granuscope::test {

/// The pixels of any PNG.
inline Image read_png(const std::filesystem::path& path) {
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&png, path.c_str()) == 0) throw std::runtime_error(path.string() + png.message);
  png.format = PNG_FORMAT_RGBA;
  Image image(static_cast<int>(png.width), static_cast<int>(png.height), {});
  if (png_image_finish_read(&png, nullptr, image.rgba.data(), 0, nullptr) == 0) {
    throw std::runtime_error(path.string() + png.message);
  }
  return image;
}

inline std::uint32_t big_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
  return value;
}

/// The data of all chunks of one type.
inline std::vector<std::string> png_chunks(const std::filesystem::path& path, const std::string& type) {
  const std::string bytes = read_file(path);
  std::vector<std::string> found;
  for (std::size_t at = 8; at < bytes.size(); at += big_endian(bytes, at) + 12) {
    if (bytes.compare(at + 4, 4, type) == 0) found.push_back(bytes.substr(at + 8, big_endian(bytes, at)));
  }
  return found;
}

/// The text of that keyword; "none" if there is none.
inline std::string png_text(const std::filesystem::path& path, const std::string& keyword) {
  const std::string head = keyword + std::string(5, '\0');
  for (const std::string& text : png_chunks(path, "iTXt")) {
    if (text.starts_with(head)) return text.substr(head.size());
  }
  return "none";
}

}  // namespace granuscope::test
