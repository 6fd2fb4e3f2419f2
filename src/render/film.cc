#include "render/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "model/pile_view.h"
#include "render/painter.h"
#include "render/pile_scene.h"
#include "render/render_pile.h"
#include "support/error.h"

namespace granuscope {
namespace {

/// Width that is seen of a wide pile, in bead diameters: forces are then told apart on a screen.
constexpr double usual_width = 80;

}  // namespace

Film::Film(const Pile& pile, const Pile* minus, const FilmSpec& spec, ImageMetadata metadata)
    : pile_(pile), minus_(minus), spec_(spec), metadata_(std::move(metadata)) {
  if (spec.step < 1) throw InputError("a film needs a step of at least one layer from frame to frame");
  SceneSpec& scene_spec = spec_.scene;
  scene_spec.backend = "none";  // a frame is painted before OpenGL would have started
  const double half = std::min(0.5 * pile.lattice.columns(), 0.5 * usual_width);
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
  layers_seen_ = 1 + static_cast<int>(std::floor((seen - 1) / (sqrt3 / 2)));
  if (seen < 1) {
    throw InputError(
        fmt::format("a frame {} pixels high has no room for a layer of beads {:.1f} pixels wide beside its {} pixels "
                    "of axes and colour scale; give a larger --height, a wider --window or a smaller --dpi",
                    spec.height_px, low.pixels_per_diameter, around));
  }
  if (layers_seen_ > last_layer_ - first_layer_) {
    throw InputError(
        fmt::format("the first frame would show all layers from {} to {}, so that nothing is left to slide over; give "
                    "a narrower --window, or render a picture instead of a film",
                    first_layer_, last_layer_));
  }
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
