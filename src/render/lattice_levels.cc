#include "render/lattice_levels.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "storage/pile_file.h"

namespace granuscope {
namespace {

/// What each bead's value is made of, in one place of the arrays.
double force(const PileView& pile, int side, std::size_t i) {
  const double V = side == 1 ? pile.V_R[i] : pile.V_L[i], H = side == 1 ? pile.H_R[i] : pile.H_L[i];
  return std::sqrt(V * V + H * H);
}

/// Normal and tangential parts: N_R = (H_R + sqrt3 V_R)/2, T_R = (sqrt3 H_R - V_R)/2, and mirrored on the left.
double mobilisation(const PileView& pile, int side, std::size_t i) {
  const double V = side == 1 ? pile.V_R[i] : pile.V_L[i], H = side == 1 ? pile.H_R[i] : -pile.H_L[i];
  const double normal = 0.5 * (H + sqrt3 * V), tangential = 0.5 * std::abs(sqrt3 * H - V);
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
  const double down = share * (sqrt3 / 2), sideways = share * 0.5;
  return {side == 0 ? -sideways - half_width_ : -half_width_, side == 0 ? half_width_ : sideways + half_width_,
          -half_width_, down + half_width_};
}

Places LatticeValues::places(int layer, int side, const Extent& region) const {
  const Extent around = reach(layer, side);
  const double z = Lattice::depth(layer);
  if (z + around.z1 <= region.z0 || z + around.z0 >= region.z1) return {};
  const double shift = 0.5 * (layer % 2);
  // place + shift + around.x1 > region.x0 and place + shift + around.x0 < region.x1; two turns of the ring suffice.
  const double far = 2.0 * lattice().columns();
  const double first = std::clamp(region.x0 - shift - around.x1, -far, far);
  const double last = std::clamp(region.x1 - shift - around.x0, -far, far);
  return {static_cast<int>(std::floor(first)) + 1, static_cast<int>(std::ceil(last)) - 1};
}

std::array<int, 2> LatticeValues::layers(const Extent& region) const {
  const double most = lattice().layers() - 1;
  const PileRange& range = pile_->about().range;
  const auto layer_at = [most](double z) { return std::clamp(std::floor((z - 0.5) / (sqrt3 / 2)), -2.0, most + 2); };
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

}  // namespace granuscope
