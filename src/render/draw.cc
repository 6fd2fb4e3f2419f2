#include "render/draw.h"

#include <fmt/format.h>

#include <chrono>
#include <memory>

#include "render/font.h"
#include "render/gl_context.h"
#include "render/painter.h"
#include "render/pile_scene.h"
#include "render/png_file.h"
#include "render/vector_file.h"
#include "render/window.h"
#include "storage/pile_file.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// Seconds since the last call.
class Lap {
 public:
  double operator()() {
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - before_).count();
    before_ = now;
    return seconds;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point before_ = Clock::now();
};

SceneStatistics draw_views(const PileView& pile, const PileView* minus, const SceneSpec& spec,
                           const std::filesystem::path& image, const ImageMetadata& metadata) {
  Lap lap;
  const Scene scene = build_scene(pile, minus, spec);
  const double building = lap();
  SceneStatistics statistics = draw_scene(scene, spec, image, metadata);
  statistics.seconds.build = building;
  return statistics;
}

}  // namespace

void require_known_format(const std::filesystem::path& image) {
  const std::filesystem::path ending = image.extension();
  if (ending == ".png" || ending == ".svg" || ending == ".pdf") return;
  throw InputError(fmt::format(
      "'{}' ends neither in .png nor in .svg or .pdf, and no other format can be written; name a file ending so",
      image.string()));
}

SceneStatistics draw_scene(const Scene& scene, const SceneSpec& spec, const std::filesystem::path& image_path,
                           const ImageMetadata& metadata) {
  require_known_format(image_path);
  SceneStatistics statistics;
  statistics.backend = "none";
  statistics.backend_reason = "nothing in the picture is larger than a pixel, so it needs no OpenGL";
  statistics.renderer = "level of detail";
  Lap lap;
  if (image_path.extension() != ".png") {
    ImageMetadata all = describe(scene);
    all.insert(all.end(), metadata.begin(), metadata.end());
    const auto [width, height] = write_vector(image_path, scene, spec, all);
    statistics.backend_reason = "a vector picture has no pixels, so it needs no OpenGL";
    statistics.renderer = "vector";
    statistics.seconds.encode = lap();
    statistics.counts = scene.counts;
    statistics.counts.pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    return statistics;
  }
  std::unique_ptr<GlContext> context;
  Image image = paint(scene, spec, [&]() -> GlContext& {
    context = make_gl_context(spec.backend);
    statistics.backend = context->name();
    statistics.backend_reason = context->reason();
    statistics.renderer = context->renderer() + ", OpenGL " + context->version();
    return *context;
  });
  image.metadata.emplace_back("Renderer",
                              fmt::format("{} ({}), {}", statistics.renderer, statistics.backend, typesetter()));
  statistics.seconds.draw = lap();
  write_png(image_path, image, spec.dpi, metadata);
  statistics.seconds.encode = lap();
  statistics.counts = scene.counts;
  statistics.counts.pixels = static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height);
  return statistics;
}

SceneStatistics draw_pile(const Pile& pile, const Pile* minus, const SceneSpec& spec,
                          const std::filesystem::path& image, const ImageMetadata& metadata) {
  const PileView view = view_of(pile);
  if (minus == nullptr) return draw_views(view, nullptr, spec, image, metadata);
  const PileView other = view_of(*minus);
  return draw_views(view, &other, spec, image, metadata);
}

SceneStatistics draw_pile(const Pile& pile, const SceneSpec& spec, const std::filesystem::path& image,
                          const ImageMetadata& metadata) {
  return draw_pile(pile, nullptr, spec, image, metadata);
}

SceneStatistics draw_pile_file(const PictureFiles& files, const SceneSpec& spec, const ImageMetadata& metadata) {
  require_known_format(files.image);
  Lap lap;
  const PilePart part = read_pile_part(files.pile, [&](const Lattice& lattice) { return range_needed(lattice, spec); });
  const PileView pile = view_of(part);
  std::optional<PilePart> other_part;
  std::optional<PileView> other;
  if (!files.minus.empty()) {
    other_part = read_pile_part(files.minus, [&](const Lattice& lattice) {
      const bool alike = lattice.columns() == part.lattice.columns() && lattice.layers() == part.lattice.layers();
      return alike ? part.range : PileRange{0, 1, 0, lattice.columns()};  // no pair, as will be said
    });
    other = view_of(*other_part);
  }
  const double reading = lap();
  ImageMetadata all = metadata;
  all.emplace_back("Description", fmt::format("pile of {} columns x {} layers, mu {}, law {}, seed {}, sample {}",
                                              pile.lattice.columns(), pile.lattice.layers(), exact(pile.mu), pile.law,
                                              pile.seed, pile.sample));
  SceneStatistics statistics = draw_views(pile, other ? &*other : nullptr, spec, files.image, all);
  statistics.seconds.read = reading;
  return statistics;
}

}  // namespace granuscope
