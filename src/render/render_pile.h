#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "model/pile.h"
#include "model/pile_view.h"
#include "render/image.h"
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

}  // namespace granuscope
