#include "render/draw.h"

#include <chrono>

#include "render/gl_context.h"
#include "render/painter.h"
#include "render/png_file.h"
#include "render/scene_builder.h"

namespace granuscope {

SceneStatistics draw_pile(const Pile& pile, const SceneSpec& spec, const std::filesystem::path& image_path,
                          const ImageMetadata& metadata) {
  using Clock = std::chrono::steady_clock;
  auto before = Clock::now();
  const auto lap = [&before] {
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - before).count();
    before = now;
    return seconds;
  };
  SceneStatistics statistics;
  const Scene scene = build_scene(pile, spec);
  statistics.seconds.build = lap();
  const auto context = make_gl_context(spec.backend);
  const Image image = paint(scene, spec, *context);
  statistics.seconds.draw = lap();
  write_png(image_path, image, spec.dpi, metadata);
  statistics.seconds.encode = lap();
  statistics.backend = context->name();
  statistics.backend_reason = context->reason();
  statistics.renderer = context->renderer() + ", OpenGL " + context->version();
  statistics.counts = scene.counts;
  statistics.counts.pixels = static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height);
  return statistics;
}

}  // namespace granuscope
