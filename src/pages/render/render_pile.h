#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

#include "model/pile.h"
#include "render/scene.h"

namespace granuscope {
/// What `render --statistics` tells of one picture.
struct SceneStatistics {
  SceneCounts counts;
  struct Seconds {
    double read = 0;  ///< opening the piles, and reading their forces, which happens between the other steps
    double build = 0;
    double draw = 0;  ///< with starting GL
    double encode = 0;
  } seconds;
  std::string backend;         ///< of GL, as chosen; "none" if the picture needs none
  std::string backend_reason;  ///< why it was chosen
  std::string renderer;        ///< GL_RENDERER and GL_VERSION, or what stood in
};

/// Which files to render.
struct PictureFiles {
  std::filesystem::path pile;
  std::filesystem::path minus;  ///< of a response: the pile without the overload; empty otherwise
  std::filesystem::path image;  ///< PNG, SVG or PDF, by its ending
};

/// Renders a pile, or two that a scene compares (`minus` may be null), to a file, which appears whole or not at all;
/// `metadata` (provenance) goes into it. Throws InputError and EnvironmentError as build_scene(), make_gl_context(),
/// Picture::paint() and PngWriter do; then no file is left.
SceneStatistics render_pile(const Pile& pile, const Pile* minus, const SceneSpec& spec,
                            const std::filesystem::path& image, const ImageMetadata& metadata = {});
/// What rendering it would count, but for the pixels.
SceneCounts count_elements(const Pile& pile, const Pile* minus, const SceneSpec& spec);
/// render_pile from files, of which only what the window needs is read; the pile's key goes into the metadata.
SceneStatistics render_pile_file(const PictureFiles& files, const SceneSpec& spec, const ImageMetadata& metadata = {});

/// Renders any scene.
SceneStatistics render_scene(const Scene& scene, const SceneSpec& spec, const std::filesystem::path& image,
                             const ImageMetadata& metadata = {});

/// Throws InputError unless the name of an image ends like a format that can be written.
void require_known_format(const std::filesystem::path& image);

/// What a film shows of a pile, and how large.
struct FilmSpec {
  SceneSpec scene;      ///< its window: what is seen in the course of the film; none: all
                        ///< layers of the middle 80 columns
  int height_px = 720;  ///< of every frame, as scene.width_px is their width
  int step = 1;         ///< layers that the window slides down from one frame to the next
};

/// A window that slides down a deep pile, a frame for each place. All frames have one colour scale, one size, and their
/// axes in one place. Frames are independent of each other: any thread may render any of them, and the processor paints
/// them all. The piles must outlive the film.
class Film {
 public:
  /// Throws InputError as build_scene() does, and for a step below 1, a frame too low for one layer, or a pile that the
  /// first frame shows to its bottom.
  /// `minus`: of the scene response, the pile without the overload; null otherwise.
  Film(const Pile& pile, const Pile* minus, const FilmSpec& spec, ImageMetadata metadata);

  std::size_t frames() const { return frames_; }
  /// Layers that each frame shows.
  int layers_seen() const { return layers_seen_; }
  /// "frame-00007.png".
  static std::filesystem::path name_of(std::size_t frame);
  /// Writes one frame into the folder, whole or not at all. Throws EnvironmentError as render_scene() does.
  void render(std::size_t frame, const std::filesystem::path& folder) const;

 private:
  SceneSpec spec_of(std::size_t frame) const;
  Scene scene_of(const SceneSpec& spec) const;

  const Pile& pile_;
  const Pile* minus_;
  FilmSpec spec_;
  ImageMetadata metadata_;
  double value_min_ = 0, value_max_ = 0;
  int first_layer_ = 0, last_layer_ = 0, layers_seen_ = 0;
  std::size_t frames_ = 0;
};

}  // namespace granuscope
