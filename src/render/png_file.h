#pragma once
#include <filesystem>
#include <optional>

#include "render/image.h"

namespace granuscope {

/// Writes the image as PNG, whole or not at all: pHYs from `dpi`, sRGB, one iTXt for each entry of image.metadata and
/// then of `metadata`, and no time stamp, so that the same image gives the same bytes. An opaque image is stored
/// without alpha, one of greys as grey. Throws EnvironmentError if the file cannot be written, InputError if the image
/// is empty or a keyword is not 1 to 79 printable ASCII characters.
void write_png(const std::filesystem::path& path, const Image& image, double dpi, const ImageMetadata& metadata = {});

/// Reads any PNG as 8-bit RGBA, with its texts. Throws InputError if there is no file or it is not a whole PNG.
Image read_png(const std::filesystem::path& path);

}  // namespace granuscope
