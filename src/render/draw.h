#pragma once
#include <filesystem>
#include <string>

#include "model/pile.h"
#include "render/image.h"
#include "render/scene.h"

namespace granuscope {

/// What `render --statistics` tells of one picture.
struct SceneStatistics {
  SceneCounts counts;
  struct Seconds {
    double read = 0;  ///< reading the pile; filled in by who reads it
    double build = 0;
    double draw = 0;  ///< with starting GL
    double encode = 0;
  } seconds;
  std::string backend;         ///< of GL, as chosen
  std::string backend_reason;  ///< why it was chosen
  std::string renderer;        ///< GL_RENDERER and GL_VERSION
};

/// Draws the pile to a PNG file, which appears whole or not at all; `metadata` (provenance) goes into it. Throws
/// InputError and EnvironmentError as build_scene(), make_gl_context(), paint() and write_png() do; then no file is
/// left.
SceneStatistics draw_pile(const Pile& pile, const SceneSpec& spec, const std::filesystem::path& image_path,
                          const ImageMetadata& metadata = {});

}  // namespace granuscope
