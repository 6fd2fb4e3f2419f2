#pragma once
#include <filesystem>
#include <memory>

#include "render/scene.h"

namespace granuscope {

/// A PNG that is written row by row and appears whole or not at all: pHYs from `dpi`, sRGB, one iTXt for each entry of
/// `metadata`, and no time stamp, so that the same pixels give the same bytes. Throws EnvironmentError if the file
/// cannot be written, InputError if the image is empty or a keyword is not 1 to 79 printable ASCII characters.
class PngWriter {
 public:
  struct Form {
    int width = 0, height = 0;
    Channels channels = Channels::rgba;
    double dpi = 0;
  };
  PngWriter(const std::filesystem::path& path, const Form& form, const ImageMetadata& metadata);
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter();

  /// The next rows, of the form's width. Channels that are not stored are passed over.
  void add(const Image& rows);
  /// After the last row: makes the file appear.
  void commit();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace granuscope
