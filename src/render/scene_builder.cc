#include "render/scene_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "render/colour_scale.h"
#include "render/layout.h"
#include "support/error.h"

namespace granuscope {
namespace {

enum class Side { left, right };

/// The window as the pile's geometry: the drawn part of the plane and the layers that can reach into it.
Extent extent_of(const Lattice& lattice, const SceneSpec& spec) {
  const double half = 0.5 * lattice.columns();
  double x0 = -half, x1 = half, n0 = 0, n1 = lattice.layers() - 1;
  if (spec.window) {
    const auto& window = *spec.window;
    const std::string given = fmt::format("the window {},{},{},{}", window[0], window[1], window[2], window[3]);
    if (!std::all_of(window.begin(), window.end(), [](double value) { return std::isfinite(value); })) {
      throw InputError(given + " is not made of numbers; give X0,X1 in bead diameters and N0,N1 as layers");
    }
    x0 = window[0];
    x1 = window[1];
    n0 = window[2];
    n1 = window[3];
    if (x0 >= x1 || n0 > n1) {
      throw InputError(given + " is empty, so there is nothing to draw; it needs X0 < X1 and N0 <= N1");
    }
    if (x1 - x0 < 1) {
      throw InputError(given + " is narrower than a bead, too narrow for an axis; X1 - X0 must be at least 1");
    }
    if (n0 != std::floor(n0) || n1 != std::floor(n1)) {
      throw InputError(given + " cuts through a layer; N0 and N1 are whole numbers, counted from 0 at the top");
    }
    if (n0 < 0 || n1 >= lattice.layers()) {
      throw InputError(fmt::format("{} asks for layers that the pile does not have; it has the layers 0 to {}", given,
                                   lattice.layers() - 1));
    }
    if (x0 < -half || x1 > half) {
      throw InputError(
          fmt::format("{} reaches around the ring of {} columns and would show beads twice; keep X0 and X1 "
                      "between {} and {}",
                      given, lattice.columns(), -half, half));
    }
  }
  // Whole beads: from the top of the first layer to the bottom of the last one.
  return {x0, x1, Lattice::depth(static_cast<int>(n0)) - 0.5, Lattice::depth(static_cast<int>(n1)) + 0.5};
}

void require_finite(const Pile& pile) {
  const auto square = [](double value) { return value * value; };
  for (int layer = 0; layer < pile.lattice.layers(); ++layer) {
    for (int bead = 0; bead < pile.lattice.columns(); ++bead) {
      const std::size_t i = pile.lattice.index(layer, bead);
      // Squares, because the magnitude of a force is formed from them; one test for the four.
      if (std::isfinite(square(pile.V_R[i]) + square(pile.V_L[i]) + square(pile.H_R[i]) + square(pile.H_L[i])))
        continue;
      throw InputError(fmt::format(
          "a force of bead {} in layer {} is not a finite number, so the pile cannot be drawn; make the file again",
          bead, layer));
    }
  }
  for (std::size_t bead = 0; bead < pile.load.size(); ++bead) {
    if (std::isfinite(pile.load[bead])) continue;
    throw InputError(fmt::format(
        "the load on bead {} is not a finite number, so the pile cannot be drawn; make the file again", bead));
  }
}

/// The bead whose load differs while all the others have the same.
std::optional<Overload> find_overload(const Pile& pile, const Extent& extent) {
  const auto& load = pile.load;
  if (load.size() < 3 || extent.z0 > 0) return std::nullopt;
  const double ordinary = load[0] == load[1] ? load[0] : load[2];
  const auto differs = [ordinary](double value) { return value != ordinary; };
  if (std::count_if(load.begin(), load.end(), differs) != 1) return std::nullopt;
  const auto bead = std::find_if(load.begin(), load.end(), differs) - load.begin();
  const double x = pile.lattice.x(0, static_cast<int>(bead));
  if (x < extent.x0 || x > extent.x1) return std::nullopt;
  return Overload{x, load[static_cast<std::size_t>(bead)]};
}

/// One contact and where the window shows it: at x + shifts[0], ... An empty list means outside.
struct Contact {
  double x0 = 0, z0 = 0, x1 = 0, z1 = 0;
  double force = 0;
  std::array<double, 3> shifts{};
  int images = 0;
};

/// Calls visit(contact) for every contact that leaves one of these layers.
template <typename Visit>
void walk_contacts(const Pile& pile, const Extent& extent, int first_layer, int last_layer, Visit&& visit) {
  const Lattice& lattice = pile.lattice;
  // The widest bar's half: a contact just beside the window may still reach into it.
  constexpr double reach = 0.5 * widest_bar;
  for (int layer = first_layer; layer <= last_layer; ++layer) {
    // Contacts that leave the lowest layer end at the contact point, half way to a bead that is not there.
    const double share = layer + 1 < lattice.layers() ? 1 : 0.5;
    Contact contact;
    contact.z0 = Lattice::depth(layer);
    contact.z1 = contact.z0 + share * (sqrt3 / 2);
    const bool in_layer = contact.z1 + reach > extent.z0 && contact.z0 - reach < extent.z1;
    for (int bead = 0; bead < lattice.columns(); ++bead) {
      const std::size_t i = lattice.index(layer, bead);
      contact.x0 = lattice.x(layer, bead);
      for (const Side side : {Side::left, Side::right}) {
        const double V = side == Side::right ? pile.V_R[i] : pile.V_L[i];
        const double H = side == Side::right ? pile.H_R[i] : pile.H_L[i];
        contact.force = std::sqrt(V * V + H * H);
        contact.x1 = contact.x0 + (side == Side::right ? 0.5 : -0.5) * share;
        contact.images = 0;
        const double left = std::min(contact.x0, contact.x1) - reach, right = std::max(contact.x0, contact.x1) + reach;
        for (const int turn : {0, -1, 1}) {  // around the ring
          const double shift = turn * lattice.columns();
          if (!in_layer || right + shift <= extent.x0 || left + shift >= extent.x1) continue;
          contact.shifts[static_cast<std::size_t>(contact.images++)] = shift;
        }
        visit(contact);
      }
    }
  }
}

/// Ends of a force scale that divide into few round steps, times a power of ten.
constexpr std::array<double, 14> round_tops = {1, 1.2, 1.5, 1.6, 1.8, 2, 2.5, 3, 3.5, 4, 5, 6, 8, 10};

double round_up(double force) {
  const double power = std::pow(10.0, std::floor(std::log10(force)));
  for (const double top : round_tops) {
    if (top * power >= force * (1 - 1e-9)) return top * power;
  }
  return 10 * power;
}

/// Force of strength 1 for these contacts of the window; consumes their order.
double scale_top(const Pile& pile, std::vector<double>& forces) {
  double top = *std::max_element(pile.load.begin(), pile.load.end()) / sqrt3;
  if (!forces.empty()) {
    const auto place = static_cast<std::size_t>(scale_quantile * static_cast<double>(forces.size() - 1));
    std::nth_element(forces.begin(), forces.begin() + static_cast<std::ptrdiff_t>(place), forces.end());
    top = std::max(top, forces[place]);
  }
  return std::isfinite(top) && top > 0 ? round_up(top) : 1;
}

/// Weak before strong. Equal strengths have equal colours, so that their order does not matter; it is kept anyway.
/// A radix sort over the bits of the strengths, which order as the numbers do because none is negative.
void sort_by_strength(std::vector<ContactBar>& bars) {
  using Entry = std::pair<std::uint32_t, std::uint32_t>;  // strength, place
  std::vector<Entry> entries(bars.size()), other(bars.size());
  for (std::size_t i = 0; i < bars.size(); ++i) {
    entries[i] = {std::bit_cast<std::uint32_t>(bars[i].strength), static_cast<std::uint32_t>(i)};
  }
  constexpr unsigned digit_bits = 11;
  for (unsigned shift = 0; shift < 32; shift += digit_bits) {
    std::vector<std::size_t> start((1U << digit_bits) + 1);
    const auto digit = [shift](const Entry& entry) { return entry.first >> shift & ((1U << digit_bits) - 1); };
    for (const Entry& entry : entries) ++start[digit(entry) + 1];
    for (std::size_t d = 1; d < start.size(); ++d) start[d] += start[d - 1];
    for (const Entry& entry : entries) other[start[digit(entry)]++] = entry;
    entries.swap(other);
  }
  std::vector<ContactBar> sorted;
  sorted.reserve(bars.size());
  for (const Entry& entry : entries) sorted.push_back(bars[entry.second]);
  bars.swap(sorted);
}

}  // namespace

Scene build_scene(const Pile& pile, const SceneSpec& spec) {
  if (spec.scene != "forces") {
    throw InputError(fmt::format("there is no scene '{}' to draw; known is: forces", spec.scene));
  }
  const ColourScale scale(Palette::builtin(), spec.colour_map);
  Scene scene;
  scene.name = spec.scene;
  scene.extent = extent_of(pile.lattice, spec);
  const PlotSize size = plot_size(spec, scene.extent);
  scene.plot_width_px = size.width_px;
  scene.plot_height_px = size.height_px;
  scene.pixels_per_diameter = size.pixels_per_diameter;
  require_finite(pile);
  scene.overload = find_overload(pile, scene.extent);

  // Only these layers can reach into the window; the others are counted without a look at them.
  const int last = pile.lattice.layers() - 1;
  const auto layer_at = [](double z) { return static_cast<int>(std::floor((z - 0.5) / (sqrt3 / 2))); };
  const int near_first = std::clamp(layer_at(scene.extent.z0) - 1, 0, last);
  const int near_last = std::clamp(layer_at(scene.extent.z1) + 1, 0, last);
  const int first = spec.skip_invisible ? near_first : 0;
  const int end = spec.skip_invisible ? near_last : last;

  std::vector<double> forces;
  walk_contacts(pile, scene.extent, near_first, near_last, [&](const Contact& contact) {
    if (contact.images == 0) return;
    forces.push_back(contact.force);
    scene.force_max = std::max(scene.force_max, contact.force);
  });
  scene.scale_top = scale_top(pile, forces);

  SceneCounts& counts = scene.counts;
  counts.outside = 2 * static_cast<std::uint64_t>(pile.lattice.columns()) *
                   static_cast<std::uint64_t>(pile.lattice.layers() - (end - first + 1));
  walk_contacts(pile, scene.extent, first, end, [&](Contact& contact) {
    if (contact.images == 0) {
      if (spec.skip_invisible) {
        ++counts.outside;
        return;
      }
      contact.shifts[0] = 0;
      contact.images = 1;
    }
    const double strength = std::min(contact.force / scene.scale_top, 1.0);
    const double width = widest_bar * strength;
    if (spec.skip_invisible && stroke_of(scale, strength, width, scene.pixels_per_diameter).colour == scale.page()) {
      ++counts.too_faint;
      return;
    }
    ++counts.drawn;
    for (int k = 0; k < contact.images; ++k) {
      const double shift = contact.shifts[static_cast<std::size_t>(k)];
      scene.bars.push_back({contact.x0 + shift, contact.z0, contact.x1 + shift, contact.z1, static_cast<float>(width),
                            static_cast<float>(strength)});
    }
  });
  sort_by_strength(scene.bars);
  return scene;
}

}  // namespace granuscope
