#pragma once
#include "render/gl_context.h"
#include "render/image.h"
#include "render/scene.h"

namespace granuscope {

/// How to paint; nothing here changes a pixel.
struct PaintOptions {
  /// Largest edge of a tile in pixels. 512 makes framebuffers of 2048 samples: 16 MB, whatever the size of the image.
  int tile_px = 512;
};

/// Paints the scene with its axes, legend and labels. The image is spec.width_px wide, and as high as the window and
/// its labels need; its metadata tells the scene, what was left out, and the renderer. Throws InputError if
/// the size cannot be (see layout.h), EnvironmentError if GL or the font fails.
Image paint(const Scene& scene, const SceneSpec& spec, GlContext& context, const PaintOptions& options = {});

}  // namespace granuscope
