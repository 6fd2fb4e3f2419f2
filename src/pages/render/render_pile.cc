#include "render/render_pile.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "render/font.h"
#include "render/gl_context.h"
#include "render/layout.h"
#include "render/painter.h"
#include "render/picture_file.h"
#include "storage/pile_file.h"
#include "support/error.h"
#include "support/plain_text.h"

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

std::shared_ptr<PileLayers> in_memory(const Pile& pile) { return std::make_shared<LayersInMemory>(view_of(pile)); }

SceneStatistics draw_layers(const std::shared_ptr<PileLayers>& pile, const std::shared_ptr<PileLayers>& minus,
                            const SceneSpec& spec, const std::filesystem::path& image, const ImageMetadata& metadata) {
  Lap lap;
  double counted = 0;
  const auto reading = [&] {  // since the last call
    const double before = counted;
    counted = pile->seconds_reading() + (minus ? minus->seconds_reading() : 0);
    return counted - before;
  };
  const Scene scene = build_scene(pile, minus, spec);
  const double to_build = reading(), building = lap();
  SceneStatistics statistics = render_scene(scene, spec, image, metadata);
  const double to_paint = reading();
  statistics.seconds.read = to_build + to_paint;
  statistics.seconds.build = building - to_build;
  (statistics.seconds.draw > 0 ? statistics.seconds.draw : statistics.seconds.encode) -= to_paint;
  return statistics;
}

}  // namespace

void require_known_format(const std::filesystem::path& image) {
  const std::string ending = suffix_of(image);
  if (ending == ".png" || ending == ".svg" || ending == ".pdf") return;
  throw InputError(
      "'{}' ends neither in .png nor in .svg or .pdf, and no other format can be written; name a file ending so",
      image.string());
}

SceneStatistics render_scene(const Scene& scene, const SceneSpec& spec, const std::filesystem::path& image_path,
                             const ImageMetadata& metadata) {
  require_known_format(image_path);
  SceneStatistics statistics;
  statistics.backend = "none";
  statistics.backend_reason = "nothing in the picture is larger than a pixel, so it needs no OpenGL";
  statistics.renderer = "level of detail";
  require_known_backend(spec.backend);
  Lap lap;
  if (suffix_of(image_path) != ".png") {
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
  const Picture picture(scene, spec);
  std::unique_ptr<GlContext> context;
  if (picture.has_use_for_gl() && (spec.backend == "none" || (spec.backend == "auto" && picture.is_small()))) {
    statistics.renderer = "spans";
    statistics.backend_reason = spec.backend == "none"
                                    ? "the processor was asked for by name"
                                    : "a picture so small is painted before OpenGL would have started";
  } else if (picture.has_use_for_gl()) {
    context = find_gl_context(spec.backend, statistics.backend_reason);
    if (context != nullptr) {
      statistics.backend = context->name();
      statistics.backend_reason = context->reason();
    }
    statistics.renderer = context == nullptr ? "spans" : context->renderer() + ", OpenGL " + context->version();
  }
  ImageMetadata all = describe(scene);
  all.emplace_back("Renderer", fmt::format("{} ({}), {}", statistics.renderer, statistics.backend, typesetter()));
  all.insert(all.end(), metadata.begin(), metadata.end());
  PngWriter png(image_path, {picture.width(), picture.height(), picture.channels(), spec.dpi}, all);
  // Rows are encoded while others are still to be painted.
  picture.paint(context.get(), {}, [&](const Image& rows, int) {
    statistics.seconds.draw += lap();
    png.add(rows);
    statistics.seconds.encode += lap();
  });
  png.commit();
  statistics.seconds.encode += lap();
  statistics.counts = scene.counts;
  statistics.counts.pixels = static_cast<std::uint64_t>(picture.width()) * static_cast<std::uint64_t>(picture.height());
  return statistics;
}

SceneStatistics render_pile(const Pile& pile, const Pile* minus, const SceneSpec& spec,
                            const std::filesystem::path& image, const ImageMetadata& metadata) {
  return draw_layers(in_memory(pile), minus == nullptr ? nullptr : in_memory(*minus), spec, image, metadata);
}

SceneCounts count_elements(const Pile& pile, const Pile* minus, const SceneSpec& spec) {
  return build_scene(in_memory(pile), minus == nullptr ? nullptr : in_memory(*minus), spec).counts;
}

SceneStatistics render_pile_file(const PictureFiles& files, const SceneSpec& spec, const ImageMetadata& metadata) {
  require_known_format(files.image);
  Lap lap;
  const std::shared_ptr<PileLayers> layers =
      open_pile_layers(files.pile, [&](const Lattice& lattice) { return range_needed(lattice, spec); });
  const PileView& pile = layers->about();
  std::shared_ptr<PileLayers> other;
  if (!files.minus.empty()) {
    other = open_pile_layers(files.minus, [&](const Lattice& lattice) {
      const bool alike = lattice.columns() == pile.lattice.columns() && lattice.layers() == pile.lattice.layers();
      return alike ? pile.range : PileRange{0, 1, 0, lattice.columns()};  // no pair, as will be said
    });
  }
  const double opening = lap();
  ImageMetadata all = metadata;
  all.emplace_back("Description", fmt::format("pile of {} columns x {}, mu {}, law {}, seed {}, sample {}",
                                              pile.lattice.columns(), how_many(pile.lattice.layers(), "layer"),
                                              exact(pile.mu), pile.law, pile.seed, pile.sample));
  SceneStatistics statistics = draw_layers(layers, other, spec, files.image, all);
  statistics.seconds.read += opening;
  return statistics;
}

namespace {

/// Width that is seen of a wide pile, in bead diameters: forces are then told apart on a screen.
constexpr double usual_width = 80;

}  // namespace

Film::Film(const Pile& pile, const Pile* minus, const FilmSpec& spec, ImageMetadata metadata)
    : pile_(pile), minus_(minus), spec_(spec), metadata_(std::move(metadata)) {
  if (spec.step < 1) throw InputError("a film needs a step of at least one layer from frame to frame");
  SceneSpec& scene_spec = spec_.scene;
  scene_spec.backend = "none";  // a frame is painted before OpenGL would have started
  const double half = std::min(pile.lattice.half_width(), 0.5 * usual_width);
  if (!scene_spec.window) scene_spec.window = {{-half, half, 0, pile.lattice.layers() - 1.0}};
  const Scene whole = scene_of(scene_spec);
  scene_spec.range = std::array{whole.values.low, whole.values.high};
  value_min_ = whole.value_min;
  value_max_ = whole.value_max;
  scene_spec.deepest_z = whole.extent.z1;
  scene_spec.height_px = 0;
  first_layer_ = static_cast<int>((*scene_spec.window)[2]);
  last_layer_ = static_cast<int>((*scene_spec.window)[3]);

  // What stands around the plot area does not depend on its height.
  SceneSpec one_layer = scene_spec;
  (*one_layer.window)[3] = first_layer_;
  const Scene low = scene_of(one_layer);
  const int around = Picture(low, one_layer).height() - low.plot_height_px;
  const double seen = (spec.height_px - around - 1) / low.pixels_per_diameter;  // bead diameters
  layers_seen_ = 1 + static_cast<int>(std::floor((seen - 1) / pile.lattice.spacing()));
  if (seen < 1) {
    throw InputError(
        "a frame {} pixels high has no room for a layer of beads {:.1f} pixels wide beside its {} pixels of axes and "
        "colour scale; give a larger --height, a wider --window or a smaller --dpi",
        spec.height_px, low.pixels_per_diameter, around);
  }
  if (layers_seen_ > last_layer_ - first_layer_) {
    throw InputError(
        "the first frame would show all layers from {} to {}, so that nothing is left to slide over; give a narrower "
        "--window, or render a picture instead of a film",
        first_layer_, last_layer_);
  }
  // A number at the lower end of the axis may reach lower beside several layers.
  while (layers_seen_ > 1 && Picture(scene_of(spec_of(0)), spec_of(0)).height() > spec.height_px) --layers_seen_;
  scene_spec.height_px = spec.height_px;
  frames_ = static_cast<std::size_t>((last_layer_ - first_layer_ + 1 - layers_seen_) / spec.step) + 1;
}

std::filesystem::path Film::name_of(std::size_t frame) { return fmt::format("frame-{:05}.png", frame); }

Scene Film::scene_of(const SceneSpec& spec) const {
  if (minus_ == nullptr) return build_scene(view_of(pile_), nullptr, spec);
  const PileView minus = view_of(*minus_);
  return build_scene(view_of(pile_), &minus, spec);
}

SceneSpec Film::spec_of(std::size_t frame) const {
  SceneSpec spec = spec_.scene;
  (*spec.window)[2] = first_layer_ + static_cast<double>(frame) * spec_.step;
  (*spec.window)[3] = (*spec.window)[2] + layers_seen_ - 1;
  return spec;
}

void Film::render(std::size_t frame, const std::filesystem::path& folder) const {
  const SceneSpec spec = spec_of(frame);
  Scene scene = scene_of(spec);
  scene.value_min = value_min_;  // of all frames, so that the numbers of the colour scale stay
  scene.value_max = value_max_;
  render_scene(scene, spec, folder / name_of(frame), metadata_);
}

}  // namespace granuscope
