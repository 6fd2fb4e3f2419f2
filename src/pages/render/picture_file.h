#pragma once
#include <array>
#include <cstdint>
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

/// More elements than these make a file that viewers open slowly, if at all, and that says no more than pixels do.
inline constexpr std::uint64_t most_vector_elements = 20000;

/// Writes a scene as SVG or PDF, by the ending of the name, whole or not at all: the layout of the pixel picture, in
/// which a pixel is a unit; text as outlines, so that no font is needed. The same scene gives the same bytes. Returns
/// the size in units. Throws InputError if the scene has too many elements, EnvironmentError if the file cannot be
/// written.
std::array<int, 2> write_vector(const std::filesystem::path& path, const Scene& scene, const SceneSpec& spec,
                                const ImageMetadata& metadata);

}  // namespace granuscope
