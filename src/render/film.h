#pragma once
#include <cstddef>
#include <filesystem>

#include "model/pile.h"
#include "render/image.h"
#include "render/scene.h"

namespace granuscope {

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
