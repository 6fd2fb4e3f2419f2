#pragma once
#include <functional>

#include "render/gl_context.h"
#include "render/image.h"
#include "render/scene.h"

namespace granuscope {

/// How to paint; nothing here changes a pixel.
struct PaintOptions {
  /// Largest edge of a tile in pixels; 0: as many as make a framebuffer of 4 MB, whatever the size of the image.
  int tile_px = 0;
};

/// Brings the OpenGL context when it is needed, and not before.
using GlSource = std::function<GlContext&()>;

/// Paints the scene with its axes, legend and labels. The image is spec.width_px wide, and as high as the window and
/// its labels need; its metadata tells the scene and what was left out. Throws InputError if the size cannot be
/// (see layout.h), EnvironmentError if GL or the font fails.
Image paint(const Scene& scene, const SceneSpec& spec, const GlSource& gl, const PaintOptions& options = {});
Image paint(const Scene& scene, const SceneSpec& spec, GlContext& context, const PaintOptions& options = {});

/// What is to be told of a scene: what it shows, and what was drawn and left out.
ImageMetadata describe(const Scene& scene);

}  // namespace granuscope
