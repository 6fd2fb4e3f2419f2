#include "packing/packing_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

#include "packing/packing_statistics.h"
#include "render/layout.h"
#include "render/sample_grid.h"
#include "support/error.h"
#include "support/progress.h"

namespace granuscope {
namespace {

/// Particles; contacts lie over them.
constexpr std::uint8_t particle_level = 14;
/// Of the mark on a sliding contact, in mean diameters.
constexpr double mark_width = 0.16;

/// The parts of a contact that are drawn, each from one place to another.
struct Parts {
  using Part = std::array<double, 4>;
  std::array<Part, 2> both;
  std::size_t count;
  const Part* begin() const { return both.data(); }
  const Part* end() const { return both.data() + count; }
};

/// All of a contact, or across the edge of a periodic box its halves, one at either particle. One with a wall ends
/// there, half way to where a like particle would be.
Parts parts_of(const Packing& packing, const PackingContact& one) {
  const bool of_wall = one.second == PackingContact::wall && one.first != PackingContact::wall;
  const double half_x = one.branch_x / 2, half_y = one.branch_y / 2;
  if (one.second != PackingContact::wall) {
    const Particle& second = packing.particles[one.second];
    const double off = std::hypot(second.x - one.x - one.branch_x, second.y - one.y - one.branch_y);
    if (off > 0.01 * packing.mean_diameter) {
      return {{{{one.x, one.y, one.x + half_x, one.y + half_y},
                {second.x, second.y, second.x - half_x, second.y - half_y}}},
              2};
    }
  }
  if (of_wall) return {{{{one.x, one.y, one.x + half_x, one.y + half_y}, {}}}, 1};
  return {{{{one.x, one.y, one.x + one.branch_x, one.y + one.branch_y}, {}}}, 1};
}

/// Elements sorted into strips of equal height, so that a band of the picture meets only what may reach into it.
class Strips {
 public:
  Strips(std::vector<Element> elements, const Extent& extent)
      : elements_(std::move(elements)), top_(extent.z0), height_(std::max(extent.height(), 1e-9) / strips) {
    std::array<std::size_t, strips + 1> ends{};
    for (const Element& one : elements_) {
      for (std::size_t k = strip(upper(one)); k <= strip(lower(one)); ++k) ++ends[k + 1];
    }
    for (std::size_t k = 0; k < strips; ++k) ends[k + 1] += ends[k];
    begins_ = ends;
    places_.resize(ends[strips]);
    for (std::size_t at = 0; at < elements_.size(); ++at) {
      for (std::size_t k = strip(upper(elements_[at])); k <= strip(lower(elements_[at])); ++k) places_[ends[k]++] = at;
    }
  }

  void visit(const Extent& region, const Scene::Visit& visit) const {
    const std::size_t first = strip(region.z0), last = strip(region.z1);
    for (std::size_t k = first; k <= last; ++k) {
      for (std::size_t at = begins_[k]; at < begins_[k + 1]; ++at) {
        const Element& one = elements_[places_[at]];
        if (k > first && strip(upper(one)) < k) continue;  // met in a strip before
        const double reach = 0.5 * one.width;
        if (std::max(one.x0, one.x1) + reach < region.x0 || std::min(one.x0, one.x1) - reach > region.x1) continue;
        visit(one);
      }
    }
  }

 private:
  static constexpr std::size_t strips = 512;

  std::size_t strip(double z) const {
    return static_cast<std::size_t>(std::clamp((z - top_) / height_, 0.0, strips - 1.0));
  }
  static double upper(const Element& one) { return std::min(one.z0, one.z1) - 0.5 * one.width; }
  static double lower(const Element& one) { return std::max(one.z0, one.z1) + 0.5 * one.width; }

  std::vector<Element> elements_;
  double top_, height_;
  std::array<std::size_t, strips + 1> begins_{};
  std::vector<std::size_t> places_;
};

/// All that is placed, or the window asked for, which has to show some of it; z = -y.
Extent extent_of(const Packing& packing, const SceneSpec& spec) {
  constexpr double far = std::numeric_limits<double>::infinity();
  Extent extent{far, -far, far, -far};
  const auto take = [&](double x, double y, double reach) {
    extent = {std::min(extent.x0, x - reach), std::max(extent.x1, x + reach), std::min(extent.z0, -y - reach),
              std::max(extent.z1, -y + reach)};
  };
  for (const PackingContact& one : packing.contacts) {
    if (!one.placed) continue;
    const Parts parts = parts_of(packing, one);
    for (const auto& [x0, y0, x1, y1] : parts) {
      take(x0, y0, packing.mean_diameter / 2);
      if (parts.count == 1) take(x1, y1, packing.mean_diameter / 2);
    }
  }
  for (const Particle& one : packing.particles) {
    if (std::isfinite(one.x) && one.radius > 0) take(one.x, one.y, one.radius);
  }
  if (!(extent.x1 > extent.x0)) {
    throw InputError("no contact says where it is; give the file of the particles by --particles");
  }
  const double d = packing.mean_diameter;
  extent = {extent.x0 / d, extent.x1 / d, extent.z0 / d, extent.z1 / d};
  if (!spec.window) return extent;
  const auto& [x0, x1, y0, y1] = *spec.window;
  if (!(x1 - x0 >= 1) || !(y1 - y0 >= 1) || !std::isfinite(x1 - x0) || !std::isfinite(y1 - y0)) {
    throw InputError("the window is empty; it is X0,X1,Y0,Y1 in mean particle diameters, at least one apart each");
  }
  if (x1 < extent.x0 || x0 > extent.x1 || -y0 < extent.z0 || -y1 > extent.z1) {
    throw InputError(
        "the window lies beside the packing, which reaches from {:.4g} to {:.4g} in x and from {:.4g} to "
        "{:.4g} in y, in mean particle diameters ({:.4g} in the file)",
        extent.x0, extent.x1, -extent.z1, -extent.z0, d);
  }
  return {x0, x1, -y1, -y0};
}

}  // namespace

Scene build_packing_scene(const Packing& packing, double mu, const SceneSpec& spec) {
  const bool friction = spec.scene == "friction";
  if (!friction && spec.scene != "forces") {
    throw InputError("there is no scene '{}' of a packing; choose forces or friction", spec.scene);
  }
  if (friction && !(mu > 0))
    throw InputError("the scene 'friction' shows |T|/(μN); give a friction coefficient above 0 by --mu");
  Scene scene;
  scene.name = spec.scene;
  scene.glyph = friction ? Glyph::even_bar : Glyph::force_bar;
  scene.key_title = label(friction ? "friction" : "forces of a packing");
  scene.colour_map = !spec.colour_map.empty() ? spec.colour_map : friction ? "viridis" : "grey";
  const ColourScale colours(Palette::builtin(), scene.colour_map);
  scene.extent = extent_of(packing, spec);
  const PlotSize size = plot_size(spec, scene.extent, {scene.key_title});
  scene.plot_width_px = size.width_px;
  scene.plot_height_px = size.height_px;
  scene.pixels_per_diameter = size.pixels_per_diameter;

  const double beyond = spec.range ? std::max(1.0, (*spec.range)[1]) : 1;
  const double mean = packing.force_unit > 0 ? packing.force_unit : mean_force(packing);
  const auto value_of = [&](const PackingContact& one) {
    if (friction && one.N <= 0) return one.T != 0 ? beyond : 0;  // no friction holds what does not press
    if (friction) return std::abs(one.T) / (mu * one.N);
    return mean > 0 ? std::max(one.N / mean, 0.0) : 0;
  };
  MagnitudeHistogram seen;
  for (const PackingContact& one : packing.contacts) {
    if (!one.placed) continue;
    const double value = value_of(one);
    seen.add(value);
    scene.value_max = std::max(scene.value_max, value);
  }
  const double top = seen.quantile(scale_quantile);
  std::array<double, 2> ends{0, !friction && top > 0 ? round_up(top) : 1};
  if (spec.range) ends = checked_range(*spec.range, Sign::one);
  const auto slides = [&](const PackingContact& one) {
    return !friction && mu >= 0 && std::abs(one.T) >= mu * one.N * (1 - sliding_share) && one.T != 0;
  };
  const bool marked = std::ranges::any_of(packing.contacts, slides);
  scene.values = {ends[0], ends[1], Sign::one, marked ? levels_below_lines : 255, particle_level};

  const double d = packing.mean_diameter;
  const auto is_outside = [&](const Element& one) {
    const double reach = 0.5 * one.width;
    return std::max(one.x0, one.x1) + reach < scene.extent.x0 || std::min(one.x0, one.x1) - reach > scene.extent.x1 ||
           std::max(one.z0, one.z1) + reach < scene.extent.z0 || std::min(one.z0, one.z1) - reach > scene.extent.z1;
  };
  std::vector<Element> elements;
  elements.reserve(packing.particles.size() + packing.contacts.size());
  for (const Particle& one : packing.particles) {
    if (!std::isfinite(one.x) || !(one.radius > 0)) continue;
    const Element disc{one.x / d, -one.y / d, one.x / d, -one.y / d, 2 * one.radius / d, particle_level, Outline::bar};
    if (!is_outside(disc)) elements.push_back(disc);
  }
  for (const PackingContact& one : packing.contacts) {
    if (!one.placed) {
      ++scene.counts.outside;
      continue;
    }
    const std::uint8_t level = scene.values.level(value_of(one));
    bool inside = false;
    for (const auto& [x0, y0, x1, y1] : parts_of(packing, one)) {
      Element bar{x0 / d, -y0 / d, x1 / d, -y1 / d};
      bar.width = width_of(scene.glyph, scene.values.strength(level));
      if (is_outside(bar)) continue;
      inside = true;
      if (level == 0 && spec.skip_invisible) continue;
      bar.level = std::max<std::uint8_t>(level, particle_level + 1);
      elements.push_back(bar);
      if (!slides(one)) continue;
      const double x = (bar.x0 + bar.x1) / 2, z = (bar.z0 + bar.z1) / 2;
      elements.push_back({x, z, x, z, mark_width, solid_line_level, Outline::bar});
    }
    ++(!inside                             ? scene.counts.outside
       : level == 0 && spec.skip_invisible ? scene.counts.too_faint
                                           : scene.counts.drawn);
  }
  const auto strips = std::make_shared<const Strips>(std::move(elements), scene.extent);
  scene.elements = [strips](const Extent& region, const Scene::Visit& visit) { strips->visit(region, visit); };
  return scene;
}

PackingFilm::PackingFilm(const PackingSource& source, double mu, SceneSpec spec)
    : source_(source), mu_(mu), spec_(std::move(spec)), steps_(source.steps()) {
  if (steps_.size() < 2) {
    throw InputError(
        "the file has one step, and a film shows several; leave out --film, or join the files of all steps");
  }
  Extent all;
  double sum = 0, contacts = 0, top = 0;
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    throw_if_interrupted();
    const Packing packing = read(k);
    if (k == 0) diameter_ = packing.mean_diameter;
    const double mean = mean_force(packing), count = static_cast<double>(packing.contacts.size());
    const Extent here = extent_of(packing, spec_);
    all = k == 0 ? here
                 : Extent{std::min(all.x0, here.x0), std::max(all.x1, here.x1), std::min(all.z0, here.z0),
                          std::max(all.z1, here.z1)};
    const Scene scene = build_packing_scene(packing, mu, spec_);
    sum += mean * count;
    contacts += count;
    const double unit = spec_.scene == "friction" ? 1 : mean;
    top = std::max(top, scene.values.high * unit);
    value_max_ = std::max(value_max_, scene.value_max * unit);
  }
  force_unit_ = sum / contacts;
  spec_.window = {{all.x0, all.x1, -all.z1, -all.z0}};
  if (spec_.scene == "friction") return;
  value_max_ /= force_unit_;
  if (!spec_.range && force_unit_ > 0) spec_.range = {{0, round_up(top / force_unit_)}};
}

Packing PackingFilm::read(std::size_t frame) const {
  Packing packing = source_.read(steps_[frame]);
  if (diameter_ > 0) packing.mean_diameter = diameter_;
  packing.force_unit = force_unit_;
  return packing;
}

Scene PackingFilm::scene(std::size_t frame) const {
  Scene scene = build_packing_scene(read(frame), mu_, spec_);
  scene.value_max = value_max_;
  scene.key_title += fmt::format(", {} {:g}", label("step"), steps_[frame]);
  return scene;
}

}  // namespace granuscope
