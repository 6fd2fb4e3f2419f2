#include "render/pile_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "render/labels.h"
#include "render/lattice_levels.h"
#include "render/layout.h"
#include "render/level_table.h"
#include "render/window.h"
#include "support/error.h"
#include "support/interruption.h"

namespace granuscope {
namespace {

/// What there is to know of a scene before there is a pile.
struct Kind {
  const char* name;
  Quantity quantity;
  Glyph glyph;
  Sign sign;
  const char* colour_map;
};

constexpr std::array<Kind, 4> kinds = {{{"forces", Quantity::force, Glyph::force_bar, Sign::one, "grey"},
                                        {"weight", Quantity::weight, Glyph::bead, Sign::one, "grey"},
                                        {"friction", Quantity::mobilisation, Glyph::even_bar, Sign::one, "viridis"},
                                        {"response", Quantity::response, Glyph::bead, Sign::both, "diverging"}}};

const Kind& kind_of(const std::string& scene) {
  const auto* const found =
      std::find_if(kinds.begin(), kinds.end(), [&](const Kind& kind) { return scene == kind.name; });
  if (found == kinds.end()) {
    throw InputError(fmt::format("there is no scene '{}' to render of a pile; choose one of {}", scene,
                                 fmt::join(pile_scenes(), ", ")));
  }
  return *found;
}

void require_pair(const PileView& pile, const PileView* minus, const Kind& kind) {
  if (kind.quantity != Quantity::response) {
    if (minus == nullptr) return;
    throw InputError(
        fmt::format("the scene '{}' shows one pile, so a second one would not be seen; the difference of two is the "
                    "scene 'response'",
                    kind.name));
  }
  if (minus == nullptr) {
    throw InputError(
        "the scene 'response' shows how two piles differ, and only one is given; name the pile without the overload, "
        "of the same seed and sample, by --minus");
  }
  const auto refuse = [](const std::string& what) {
    throw InputError(fmt::format(
        "the two piles {}, so their difference would show chance and not a response; draw both with the same "
        "command except for the load",
        what));
  };
  const Lattice &a = pile.lattice, &b = minus->lattice;
  if (a.columns() != b.columns() || a.layers() != b.layers()) {
    refuse(fmt::format("have {} x {} and {} x {} beads", a.columns(), a.layers(), b.columns(), b.layers()));
  }
  if (pile.mu != minus->mu) refuse(fmt::format("have the friction coefficients {} and {}", pile.mu, minus->mu));
  if (pile.law != minus->law) refuse(fmt::format("follow the laws {} and {}", pile.law, minus->law));
  if (pile.seed != minus->seed || pile.sample != minus->sample) {
    refuse(fmt::format("are sample {} of seed {} and sample {} of seed {}", pile.sample, pile.seed, minus->sample,
                       minus->seed));
  }
}

void require_friction(const Kind& kind, double mu) {
  if (kind.quantity != Quantity::mobilisation || mu > 0) return;
  throw InputError(
      "without friction there is none to be mobilised, so the scene 'friction' would show nothing; draw a pile of mu > "
      "0, or another scene");
}

void require_finite_loads(const PileView& pile) {
  for (std::size_t bead = 0; bead < pile.load.size(); ++bead) {
    if (std::isfinite(pile.load[bead])) continue;
    throw InputError(fmt::format(
        "the load on bead {} is not a finite number, so the pile cannot be rendered; make the file again", bead));
  }
}

/// The bead whose load differs while all the others have the same.
std::optional<Overload> find_overload(const PileView& pile, const Extent& extent, bool added) {
  const auto& load = pile.load;
  if (load.size() < 3 || extent.z0 > 0) return std::nullopt;
  const double ordinary = load[0] == load[1] ? load[0] : load[2];
  const auto differs = [ordinary](double value) { return value != ordinary; };
  if (std::count_if(load.begin(), load.end(), differs) != 1) return std::nullopt;
  const auto bead = std::find_if(load.begin(), load.end(), differs) - load.begin();
  const double x = pile.lattice.x(0, static_cast<int>(bead));
  if (x < extent.x0 || x > extent.x1) return std::nullopt;
  return Overload{x, load[static_cast<std::size_t>(bead)] - (added ? ordinary : 0), added};
}

/// One side of one layer: how many places there are in the window, and their values.
using VisitRow = std::function<void(std::span<const double>)>;

/// Visits the values that the window shows, each once.
void walk_window(const LatticeValues& values, const Extent& extent, const VisitRow& visit) {
  std::vector<double> row;
  const auto [first, last] = values.layers(extent);
  for (int layer = first; layer <= last; ++layer) {
    throw_if_interrupted();
    for (int side = 0; side < values.sides(); ++side) {
      const Places places = values.places(layer, side, extent);
      row.resize(static_cast<std::size_t>(std::min(places.count(), values.lattice().columns())));
      if (row.empty()) continue;
      values.values(layer, side, places.first, row);
      for (std::size_t k = 0; k < row.size(); ++k) {
        if (std::isfinite(row[k])) continue;
        throw InputError(fmt::format(
            "a force of bead {} in layer {} is not a finite number, so the pile cannot be rendered; make the "
            "file again",
            values.bead_at(places.first + static_cast<int>(k)), layer));
      }
      visit(row);
    }
  }
}

/// Ends of the scale as asked for, or so that they cover most of what is seen, and the load of an ordinary bead.
std::array<double, 2> scale_ends(const Kind& kind, const SceneSpec& spec, const PileView& pile,
                                 const MagnitudeHistogram& seen) {
  if (spec.range) return checked_range(*spec.range, kind.sign);
  if (kind.quantity == Quantity::mobilisation) return {0, 1};
  double top = seen.quantile(scale_quantile);
  if (kind.quantity == Quantity::force)
    top = std::max(top, *std::max_element(pile.load.begin(), pile.load.end()) / sqrt3);
  const double high = std::isfinite(top) && top > 0 ? round_up(top) : 1;
  return {kind.sign == Sign::both ? -high : 0, high};
}

}  // namespace

std::vector<std::string> pile_scenes() {
  std::vector<std::string> names;
  names.reserve(kinds.size());
  for (const Kind& kind : kinds) names.emplace_back(kind.name);
  return names;
}

bool needs_two_piles(const std::string& scene) { return kind_of(scene).quantity == Quantity::response; }

bool needs_horizontal_forces(const std::string& scene) {
  const Quantity quantity = kind_of(scene).quantity;
  return quantity == Quantity::force || quantity == Quantity::mobilisation;
}

std::string key_title_of(const std::string& scene) { return label(kind_of(scene).name); }

void check_drawable(const Lattice& lattice, double mu, const SceneSpec& spec) {
  const Kind& kind = kind_of(spec.scene);
  const ColourScale colours(Palette::builtin(), spec.colour_map.empty() ? kind.colour_map : spec.colour_map, kind.sign);
  plot_size(spec, extent_of(lattice, spec), label(kind.name));
  if (spec.range) checked_range(*spec.range, kind.sign);
  require_friction(kind, mu);
}

Scene build_scene(const PileView& pile, const PileView* minus, const SceneSpec& spec) {
  return build_scene(std::make_shared<LayersInMemory>(pile),
                     minus == nullptr ? nullptr : std::make_shared<LayersInMemory>(*minus), spec);
}

Scene build_scene(const std::shared_ptr<PileLayers>& pile_layers, const std::shared_ptr<PileLayers>& minus_layers,
                  const SceneSpec& spec) {
  const PileView& pile = pile_layers->about();
  const PileView* const minus = minus_layers ? &minus_layers->about() : nullptr;
  const Kind& kind = kind_of(spec.scene);
  Scene scene;
  scene.name = kind.name;
  scene.glyph = kind.glyph;
  scene.key_title = label(kind.name);
  scene.colour_map = spec.colour_map.empty() ? kind.colour_map : spec.colour_map;
  const ColourScale colours(Palette::builtin(), scene.colour_map, kind.sign);
  scene.extent = extent_of(pile.lattice, spec);
  const PlotSize size = plot_size(spec, scene.extent, scene.key_title);
  scene.plot_width_px = size.width_px;
  scene.plot_height_px = size.height_px;
  scene.pixels_per_diameter = size.pixels_per_diameter;
  require_pair(pile, minus, kind);
  require_friction(kind, pile.mu);
  require_finite_loads(pile);
  scene.overload = find_overload(pile, scene.extent, minus != nullptr);

  const LatticeValues values(pile_layers, minus_layers, kind.quantity);
  MagnitudeHistogram seen;
  scene.value_min = std::numeric_limits<double>::infinity();
  scene.value_max = -std::numeric_limits<double>::infinity();
  walk_window(values, scene.extent, [&](std::span<const double> row) {
    const auto [least, most] = std::minmax_element(row.begin(), row.end());
    scene.value_min = std::min(scene.value_min, *least);
    scene.value_max = std::max(scene.value_max, *most);
    for (const double value : row) seen.add(std::abs(value));
  });
  if (scene.value_min > scene.value_max) scene.value_min = scene.value_max = 0;
  const std::array<double, 2> ends = scale_ends(kind, spec, pile, seen);
  scene.values = {ends[0], ends[1], kind.sign, 255};

  const double samples_per_diameter = scene.pixels_per_diameter * samples_per_axis(scene.pixels_per_diameter);
  const LevelTable table = make_level_table(colours, scene.values, kind.glyph, samples_per_diameter);
  const bool skip = spec.skip_invisible;
  const bool detail = skip && scene.pixels_per_diameter < detail_pixels_per_diameter;

  SceneCounts& counts = scene.counts;
  std::uint64_t shown = 0;
  walk_window(values, scene.extent, [&](std::span<const double> row) {
    shown += row.size();
    if (!skip) return;
    for (const double value : row) counts.too_faint += table.visible[scene.values.level(value)] ? 0 : 1;
  });
  const auto all = static_cast<std::uint64_t>(values.sides()) * pile.lattice.beads();
  counts.outside = skip ? all - shown : 0;
  (detail ? counts.aggregated : counts.drawn) = all - counts.outside - counts.too_faint;

  const auto levels = std::make_shared<const LatticeLevels>(values, scene.values, scene.extent, skip);
  if (detail) scene.detail = levels;
  scene.elements = [levels, table, skip, values = scene.values, glyph = kind.glyph](const Extent& region,
                                                                                    const Scene::Visit& visit) {
    std::vector<std::uint8_t> row;
    const auto [first, last] = levels->layers(region);
    levels->values().hold(first, last);
    for (int layer = first; layer <= last; ++layer) {
      const double z = Lattice::depth(layer);
      const double share = layer + 1 < levels->values().lattice().layers() ? 1 : 0.5;
      for (int side = 0; side < levels->values().sides(); ++side) {
        const Places places = levels->places(layer, side, region);
        row.resize(static_cast<std::size_t>(places.count()));
        levels->levels(layer, side, places.first, row);
        for (std::size_t k = 0; k < row.size(); ++k) {
          if (skip && !table.visible[row[k]]) continue;
          Element element;
          element.level = row[k];
          element.width = width_of(glyph, values.strength(row[k]));
          element.x0 = element.x1 = places.first + static_cast<int>(k) + 0.5 * (layer % 2);
          element.z0 = element.z1 = z;
          if (glyph != Glyph::bead) {
            element.x1 += (side == 0 ? -0.5 : 0.5) * share;
            element.z1 += share * (sqrt3 / 2);
          }
          visit(element);
        }
      }
    }
  };
  return scene;
}

}  // namespace granuscope
