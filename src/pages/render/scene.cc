#include "render/scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/lattice.h"
#include "render/layout.h"
#include "render/sample_grid.h"
#include "storage/pile_file.h"
#include "support/error.h"
#include "support/progress.h"

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
  const auto* const found = std::ranges::find_if(kinds, [&](const Kind& kind) { return scene == kind.name; });
  if (found == kinds.end()) {
    throw InputError("there is no scene '{}' to render of a pile; choose one of {}", scene,
                     fmt::join(pile_scenes(), ", "));
  }
  return *found;
}

void require_pair(const PileView& pile, const PileView* minus, const Kind& kind) {
  if (kind.quantity != Quantity::response) {
    if (minus == nullptr) return;
    throw InputError(
        "the scene '{}' shows one pile, so a second one would not be seen; the difference of two is the scene "
        "'response'",
        kind.name);
  }
  if (minus == nullptr) {
    throw InputError(
        "the scene 'response' shows how two piles differ, and only one is given; name the pile without the overload, "
        "of the same seed and sample, by --minus");
  }
  const auto refuse = [](const std::string& what) {
    throw InputError(
        "the two piles {}, so their difference would show chance and not a response; draw both with the same command "
        "except for the load",
        what);
  };
  const Lattice &a = pile.lattice, &b = minus->lattice;
  if (a.columns() != b.columns() || a.layers() != b.layers()) {
    refuse(fmt::format("have {} x {} and {} x {} beads", a.columns(), a.layers(), b.columns(), b.layers()));
  }
  if (a.geometry().angle != b.geometry().angle) refuse("have contacts at different angles");
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
    throw InputError("the load on bead {} is not a finite number, so the pile cannot be rendered; make the file again",
                     bead);
  }
}

/// The bead whose load differs while all the others have the same.
std::optional<Overload> find_overload(const PileView& pile, const Extent& extent, bool added) {
  const auto& load = pile.load;
  if (load.size() < 3 || extent.z0 > 0) return std::nullopt;
  const double ordinary = load[0] == load[1] ? load[0] : load[2];
  const auto differs = [ordinary](double value) { return value != ordinary; };
  if (std::ranges::count_if(load, differs) != 1) return std::nullopt;
  const auto bead = std::ranges::find_if(load, differs) - load.begin();
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
        throw InputError(
            "a force of bead {} in layer {} is not a finite number, so the pile cannot be rendered; make the file "
            "again",
            values.bead_at(places.first + static_cast<int>(k)), layer);
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
    top = std::max(top, *std::ranges::max_element(pile.load) / pile.lattice.geometry().twice_cosine);
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
  plot_size(spec, extent_of(lattice, spec), {label(kind.name)});
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
  const PlotSize size = plot_size(spec, scene.extent, {scene.key_title});
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
  // Its samples lie on rows of 30 degrees.
  const bool detail =
      skip && scene.pixels_per_diameter < detail_pixels_per_diameter && pile.lattice.geometry().angle == usual_angle;

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
      const Lattice& lattice = levels->values().lattice();
      const double z = lattice.z(layer), pitch = lattice.pitch();
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
          element.x0 = element.x1 = pitch * (places.first + static_cast<int>(k) + 0.5 * (layer % 2));
          element.z0 = element.z1 = z;
          if (glyph != Glyph::bead) {
            element.x1 += (side == 0 ? -0.5 : 0.5) * share * pitch;
            element.z1 += share * lattice.spacing();
          }
          visit(element);
        }
      }
    }
  };
  return scene;
}

namespace {

/// What each bead's value is made of, in one place of the arrays.
double force(const PileView& pile, int side, std::size_t i) {
  const double V = side == 1 ? pile.V_R[i] : pile.V_L[i], H = side == 1 ? pile.H_R[i] : pile.H_L[i];
  return std::sqrt(V * V + H * H);
}

/// Of the normal and tangential parts (model/audit.h), mirrored on the left.
double mobilisation(const PileView& pile, int side, std::size_t i) {
  const double V = side == 1 ? pile.V_R[i] : pile.V_L[i], H = side == 1 ? pile.H_R[i] : -pile.H_L[i];
  const BeadGeometry& to = pile.lattice.geometry();
  const double normal = 0.5 * (to.twice_sine * H + to.twice_cosine * V);
  const double tangential = 0.5 * std::abs(to.twice_cosine * H - to.twice_sine * V);
  return normal > 0 ? tangential / (pile.mu * normal) : 0;
}

double weight(const PileView& pile, std::size_t i) { return pile.V_R[i] + pile.V_L[i]; }

int turned(int value, int columns) { return (value % columns + columns) % columns; }

}  // namespace

LatticeValues::LatticeValues(std::shared_ptr<PileLayers> pile, std::shared_ptr<PileLayers> minus, Quantity quantity)
    : pile_(std::move(pile)), minus_(std::move(minus)), quantity_(quantity) {
  half_width_ = 0.5 * (quantity == Quantity::force          ? widest_bar
                       : quantity == Quantity::mobilisation ? even_bar_width
                                                            : 1.0);
}

int LatticeValues::bead_at(int place) const { return turned(place + lattice().middle(), lattice().columns()); }

void LatticeValues::hold(int first, int last) const {
  if (first > last || last - first >= band_layers) return;  // those are gone through band by band
  pile_->hold(first, last);
  if (minus_) minus_->hold(first, last);
}

void LatticeValues::values(int layer, int side, int first_place, std::span<double> values) const {
  const int columns = lattice().columns();
  const PileView& pile = pile_->hold(layer, layer);
  const PileView* const minus = minus_ ? &minus_->hold(layer, layer) : nullptr;
  for (std::size_t done = 0; done < values.size();) {
    const int bead = bead_at(first_place + static_cast<int>(done));
    const std::size_t i = pile.index(layer, bead);
    // Neighbours up to where the arrays or the ring come around.
    const int offset = turned(bead - pile.range.first_bead, columns);
    const auto run = std::min(values.size() - done, static_cast<std::size_t>(pile.range.beads - offset));
    double* out = values.data() + done;
    switch (quantity_) {
      case Quantity::force:
        for (std::size_t k = 0; k < run; ++k) out[k] = force(pile, side, i + k);
        break;
      case Quantity::mobilisation:
        for (std::size_t k = 0; k < run; ++k) out[k] = mobilisation(pile, side, i + k);
        break;
      case Quantity::weight:
        for (std::size_t k = 0; k < run; ++k) out[k] = weight(pile, i + k);
        break;
      case Quantity::response:
        for (std::size_t k = 0; k < run; ++k) out[k] = weight(pile, i + k) - weight(*minus, i + k);
        break;
    }
    done += run;
  }
}

Extent LatticeValues::reach(int layer, int side) const {
  if (!shows_contacts(quantity_)) return {-half_width_, half_width_, -half_width_, half_width_};
  // Contacts that leave the lowest layer end at the contact point, half way to a bead that is not there.
  const double share = layer + 1 < lattice().layers() ? 1 : 0.5;
  const double down = share * lattice().spacing(), sideways = share * 0.5 * lattice().pitch();
  return {side == 0 ? -sideways - half_width_ : -half_width_, side == 0 ? half_width_ : sideways + half_width_,
          -half_width_, down + half_width_};
}

Places LatticeValues::places(int layer, int side, const Extent& region) const {
  const Extent around = reach(layer, side);
  const double z = lattice().z(layer);
  if (z + around.z1 <= region.z0 || z + around.z0 >= region.z1) return {};
  const double shift = 0.5 * (layer % 2);
  // place + shift + around.x1 > region.x0 and place + shift + around.x0 < region.x1; two turns of the ring suffice.
  const double far = 2.0 * lattice().columns();
  const double pitch = lattice().pitch();
  const double first = std::clamp(region.x0 / pitch - shift - around.x1 / pitch, -far, far);
  const double last = std::clamp(region.x1 / pitch - shift - around.x0 / pitch, -far, far);
  return {static_cast<int>(std::floor(first)) + 1, static_cast<int>(std::ceil(last)) - 1};
}

std::array<int, 2> LatticeValues::layers(const Extent& region) const {
  const double most = lattice().layers() - 1;
  const PileRange& range = pile_->about().range;
  const auto layer_at = [most, spacing = lattice().spacing()](double z) {
    return std::clamp(std::floor((z - 0.5) / spacing), -2.0, most + 2);
  };
  return {std::max(static_cast<int>(layer_at(region.z0)) - 1, range.first_layer),
          std::min(static_cast<int>(layer_at(region.z1)) + 1, range.first_layer + range.layers - 1)};
}

LatticeLevels::LatticeLevels(LatticeValues values, const ValueScale& scale, const Extent& extent, bool inside_only)
    : values_(std::move(values)), scale_(scale), extent_(extent), inside_only_(inside_only) {}

void LatticeLevels::levels(int layer, int side, int first_place, std::span<std::uint8_t> levels) const {
  std::array<double, 256> block{};
  for (std::size_t done = 0; done < levels.size();) {
    const std::size_t count = std::min(block.size(), levels.size() - done);
    values_.values(layer, side, first_place + static_cast<int>(done), std::span(block).first(count));
    for (std::size_t k = 0; k < count; ++k) levels[done + k] = scale_.level(block[k]);
    done += count;
  }
}

Places LatticeLevels::places(int layer, int side, const Extent& region) const {
  const Places wanted = values_.places(layer, side, region), inside = values_.places(layer, side, extent_);
  if (inside_only_) return {std::max(wanted.first, inside.first), std::min(wanted.last, inside.last)};
  // The whole ring once, and what the window shows of it a second time.
  const int first = -values_.lattice().middle(), last = first + values_.lattice().columns() - 1;
  Places painted{first, last};
  if (inside.count() > 0) painted = {std::min(first, inside.first), std::max(last, inside.last)};
  return {std::max(wanted.first, painted.first), std::min(wanted.last, painted.last)};
}

std::array<int, 2> LatticeLevels::layers(const Extent& region) const { return values_.layers(region); }

namespace {

constexpr double ray_points = 1.0;
constexpr double dash_points = 5.0, dash_gap_points = 3.0;

/// The strongest of a response stand in few cells, at its source.
constexpr double field_quantile = 0.995;

struct Edges {
  double top, bottom;
};

/// How far rows may reach up or down: where far fewer layers were recorded than elsewhere, page tells so better than
/// one row painted over all of them. 1.5 times half the usual distance.
double longest_reach(const Field& field) {
  std::vector<double> gaps;
  for (std::size_t k = 1; k < field.rows.size(); ++k) gaps.push_back(field.rows[k].z - field.rows[k - 1].z);
  if (gaps.empty()) return 0.5;
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  return 0.75 * *middle;
}

Edges edges_of(const Field& field, std::size_t row, double longest) {
  const auto& rows = field.rows;
  const double z = rows[row].z;
  const bool first = row == 0, last = row + 1 == rows.size();
  // A gap that is too long is nobody's: both rows beside it are as high as they usually are.
  const auto reach = [&](double gap) { return 0.5 * gap <= longest ? 0.5 * gap : longest / 1.5; };
  const double above = first ? 0 : reach(z - rows[row - 1].z), below = last ? 0 : reach(rows[row + 1].z - z);
  if (first && last) return {z - 0.5, z + 0.5};
  return {z - (first ? below : above), z + (last ? above : below)};
}

void require_rows(const Field& field) {
  if (field.rows.empty()) throw InputError("the field has no rows, so there is nothing to render; record some layers");
  for (std::size_t k = 0; k < field.rows.size(); ++k) {
    if (field.rows[k].values.empty() || (k > 0 && field.rows[k].z <= field.rows[k - 1].z)) {
      throw InputError("the rows of the field are empty or not in the order of their depths; sort them");
    }
  }
}

Extent field_extent(const Field& field, const SceneSpec& spec) {
  if (spec.window) {
    const auto& window = *spec.window;
    const bool finite = std::ranges::all_of(window, [](double value) { return std::isfinite(value); });
    if (!finite || window[1] - window[0] < 1 || window[2] > window[3] || window[2] < 0 || window[3] > 1e9) {
      throw InputError("the window of the field is empty; it needs X0 < X1, a bead diameter apart, and N0 <= N1");
    }
    return {window[0], window[1], Lattice::depth(static_cast<int>(window[2])) - 0.5,
            Lattice::depth(static_cast<int>(window[3])) + 0.5};
  }
  Extent extent{field.rows[0].x0, field.rows[0].x0, 0,
                edges_of(field, field.rows.size() - 1, longest_reach(field)).bottom};
  for (const FieldRow& row : field.rows) {
    extent.x0 = std::min(extent.x0, row.x0);
    extent.x1 = std::max(extent.x1, row.left_of(row.values.size()));
  }
  return extent;
}

/// Pieces of a line, as bars with round ends.
void add_line(const OverlayLine& line, double point, std::vector<Element>& elements) {
  const double width = ray_points * point, dash = dash_points * point, gap = dash_gap_points * point;
  double along = 0;  // of the line so far
  for (std::size_t k = 1; k < line.points.size(); ++k) {
    const auto &from = line.points[k - 1], &to = line.points[k];
    const double length = std::hypot(to[0] - from[0], to[1] - from[1]);
    const auto add = [&](double start, double end) {
      const auto at = [&](double share, std::size_t axis) { return from[axis] + share * (to[axis] - from[axis]); };
      const double a = start / length, b = end / length;
      elements.push_back({at(a, 0), at(a, 1), at(b, 0), at(b, 1), width,
                          line.dashed ? dashed_line_level : solid_line_level, Outline::bar});
    };
    if (!(length > 0) || !std::isfinite(length)) continue;
    if (!line.dashed) {
      add(0, length);
    } else {
      const double start = -std::fmod(along, dash + gap);
      const int dashes = static_cast<int>(std::ceil((length - start) / (dash + gap)));
      for (int k_dash = 0; k_dash < dashes; ++k_dash) {
        const double first = start + k_dash * (dash + gap);
        if (first + dash > 0 && first < length) add(std::max(first, 0.0), std::min(first + dash, length));
      }
    }
    along += length;
  }
}

}  // namespace

Scene build_field_scene(const Field& field, const SceneSpec& spec) {
  require_rows(field);
  Scene scene;
  scene.name = "field";
  scene.glyph = Glyph::cell;
  scene.key_title = field.key_title;
  scene.colour_map = spec.colour_map.empty() ? "grey" : spec.colour_map;
  const ColourScale colours(Palette::builtin(), scene.colour_map);
  scene.extent = field_extent(field, spec);
  const PlotSize size = plot_size(spec, scene.extent, {scene.key_title});
  scene.plot_width_px = size.width_px;
  scene.plot_height_px = size.height_px;
  scene.pixels_per_diameter = size.pixels_per_diameter;

  MagnitudeHistogram seen;
  scene.value_min = std::numeric_limits<double>::infinity();
  scene.value_max = -std::numeric_limits<double>::infinity();
  std::vector<Element> elements;
  std::vector<double> values;
  const double longest = longest_reach(field);
  for (std::size_t row = 0; row < field.rows.size(); ++row) {
    const Edges edges = edges_of(field, row, longest);
    for (std::size_t k = 0; k < field.rows[row].values.size(); ++k) {
      const double value = field.rows[row].values[k], x = field.rows[row].left_of(k),
                   right = field.rows[row].left_of(k + 1);
      if (!std::isfinite(value))
        throw InputError("the field holds numbers that are not finite, as where no pile was completed");
      if (x >= scene.extent.x1 || right <= scene.extent.x0 || edges.top >= scene.extent.z1 ||
          edges.bottom <= scene.extent.z0) {
        ++scene.counts.outside;
        continue;
      }
      scene.value_min = std::min(scene.value_min, value);
      scene.value_max = std::max(scene.value_max, value);
      seen.add(std::abs(value));
      elements.push_back({x, edges.top, right, edges.bottom, 1, 0, Outline::box});
      values.push_back(value);
    }
  }
  if (values.empty()) throw InputError("the window shows no cell of the field; choose a larger one");
  const double top = seen.quantile(field_quantile);
  std::array<double, 2> ends{0, top > 0 ? round_up(top) : 1};
  if (spec.range) ends = checked_range(*spec.range, Sign::one);
  scene.values = {ends[0], ends[1], Sign::one, levels_below_lines};
  for (std::size_t k = 0; k < values.size(); ++k) elements[k].level = scene.values.level(values[k]);

  if (spec.skip_invisible) {
    const double samples_per_diameter = scene.pixels_per_diameter * samples_per_axis(scene.pixels_per_diameter);
    const LevelTable table = make_level_table(colours, scene.values, scene.glyph, samples_per_diameter);
    scene.counts.too_faint = std::erase_if(elements, [&](const Element& cell) { return !table.visible[cell.level]; });
  }
  scene.counts.drawn = elements.size();
  const double point = spec.dpi / 72 / scene.pixels_per_diameter;
  for (const OverlayLine& line : field.lines) add_line(line, point, elements);

  scene.elements = [elements = std::move(elements)](const Extent& region, const Scene::Visit& visit) {
    for (const Element& element : elements) {
      const double reach = element.outline == Outline::bar ? 0.5 * element.width : 0;
      if (std::max(element.x0, element.x1) + reach < region.x0 || std::min(element.x0, element.x1) - reach > region.x1)
        continue;
      if (std::max(element.z0, element.z1) + reach < region.z0 || std::min(element.z0, element.z1) - reach > region.z1)
        continue;
      visit(element);
    }
  };
  return scene;
}

}  // namespace granuscope
