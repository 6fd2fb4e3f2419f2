#include "sampling/null_directions.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace granuscope {
namespace {

constexpr std::size_t nowhere = static_cast<std::size_t>(-1);
/// Coefficients are of order 1; what elimination leaves of a zero is far smaller.
constexpr double elimination_zero = 1e-9;

/// Some beads, and closed contacts that enter the balances of no others. The unknowns are the slacks of the contacts,
/// in their order.
struct Region {
  std::vector<std::size_t> beads, contacts;
};

/// The balances of a region solved for one unknown each (Gauss-Jordan): unknown + sum of the free ones = 0.
class SolvedBalances {
 public:
  SolvedBalances(const ContactBalances& balances, const Region& region, std::vector<std::size_t>& place_of_bead)
      : unknowns_(2 * region.contacts.size()), rows_(3 * region.beads.size()), matrix_(rows_ * unknowns_) {
    for (std::size_t b = 0; b < region.beads.size(); ++b) place_of_bead[region.beads[b]] = b;
    for (std::size_t c = 0; c < region.contacts.size(); ++c) {
      for (const BalanceTerm& term : balances.terms(region.contacts[c])) {
        double* row = row_at(3 * place_of_bead[term.equation / 3] + term.equation % 3);
        row[2 * c] = term.of_low;
        row[2 * c + 1] = term.of_high;
      }
    }
    for (const std::size_t bead : region.beads) place_of_bead[bead] = nowhere;
    solve();
  }

  const std::vector<std::size_t>& free() const { return free_; }
  /// All unknowns where free unknown number `f` is 1 and the others are 0.
  std::vector<double> direction(std::size_t f) const {
    std::vector<double> all(unknowns_);
    all[free_[f]] = 1;
    for (const auto& [row, unknown] : pivots_) all[unknown] = -matrix_[row * unknowns_ + free_[f]];
    return all;
  }

 private:
  double* row_at(std::size_t row) { return matrix_.data() + row * unknowns_; }

  /// Of a row, the last unknown that is not much smaller than the largest: those of the deepest contacts, which later
  /// rows have not met yet. nowhere: the row is 0.
  std::size_t pivot_of(const double* row) const {
    constexpr double not_much_smaller = 0.1;
    double largest = elimination_zero;
    for (std::size_t u = 0; u < unknowns_; ++u) largest = std::max(largest, std::abs(row[u]));
    if (!(largest > elimination_zero)) return nowhere;
    for (std::size_t u = unknowns_; u-- > 0;) {
      if (std::abs(row[u]) >= not_much_smaller * largest) return u;
    }
    return nowhere;
  }

  void solve() {
    std::vector<bool> solved_for(unknowns_);
    for (std::size_t r = 0; r < rows_; ++r) {
      double* row = row_at(r);
      const std::size_t pivot = pivot_of(row);
      if (pivot == nowhere) continue;
      const double scale = 1 / row[pivot];
      for (std::size_t u = 0; u < unknowns_; ++u) row[u] *= scale;
      for (std::size_t other = 0; other < rows_; ++other) {
        double* reduced = row_at(other);
        const double factor = reduced[pivot];
        if (other == r || factor == 0) continue;
        for (std::size_t u = 0; u < unknowns_; ++u) reduced[u] -= factor * row[u];
        reduced[pivot] = 0;
      }
      solved_for[pivot] = true;
      pivots_.emplace_back(r, pivot);
    }
    for (std::size_t u = 0; u < unknowns_; ++u) {
      if (!solved_for[u]) free_.push_back(u);
    }
  }

  std::size_t unknowns_, rows_;
  std::vector<double> matrix_;                               ///< [rows, unknowns]
  std::vector<std::pair<std::size_t, std::size_t>> pivots_;  ///< row, and the unknown that it is solved for
  std::vector<std::size_t> free_;
};

/// Collects directions, region by region.
class Collection {
 public:
  Collection(const ContactBalances& balances, const OpenedContacts& opened)
      : balances_(balances),
        opened_(opened),
        directions_of_(balances.contacts()),
        place_of_bead_(balances.lattice().beads(), nowhere),
        place_of_contact_(balances.contacts(), nowhere) {}

  bool opened(std::size_t contact) const { return opened_[contact] != 0; }
  std::vector<NullDirection>& directions() { return directions_; }

  void add(const Region& region) {
    const SolvedBalances solved(balances_, region, place_of_bead_);
    if (solved.free().empty()) return;
    for (std::size_t c = 0; c < region.contacts.size(); ++c) place_of_contact_[region.contacts[c]] = c;
    const std::vector<bool> found = found_already(region, solved.free());
    for (const std::size_t contact : region.contacts) place_of_contact_[contact] = nowhere;
    for (std::size_t f = 0; f < found.size(); ++f) {
      if (!found[f]) keep(region, solved.direction(f));
    }
  }

 private:
  /// Of the free unknowns, those that the directions found so far inside the region let vary as they like; a direction
  /// is told by its free unknowns alone.
  std::vector<bool> found_already(const Region& region, const std::vector<std::size_t>& free) const {
    std::vector<bool> found(free.size()), met(directions_.size());
    std::vector<std::pair<std::size_t, std::vector<double>>> reduced;  // a free unknown, and the row that has 1 there
    for (const std::size_t contact : region.contacts) {
      for (const std::size_t d : directions_of_[contact]) {
        if (met[d]) continue;
        met[d] = true;
        std::vector<double> row = free_part(directions_[d], free, 2 * region.contacts.size());
        for (const auto& [pivot, other] : reduced) {
          const double factor = row.empty() ? 0 : row[pivot];
          if (factor == 0) continue;
          for (std::size_t f = 0; f < row.size(); ++f) row[f] -= factor * other[f];
        }
        const auto largest =
            std::max_element(row.begin(), row.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
        constexpr double independent = 1e-7;
        if (largest == row.end() || !(std::abs(*largest) > independent)) continue;
        const auto pivot = static_cast<std::size_t>(largest - row.begin());
        const double scale = 1 / *largest;
        for (double& one : row) one *= scale;
        found[pivot] = true;
        reduced.emplace_back(pivot, std::move(row));
      }
    }
    return found;
  }

  /// Empty if the direction leaves the region.
  std::vector<double> free_part(const NullDirection& direction, const std::vector<std::size_t>& free,
                                std::size_t unknowns) const {
    std::vector<double> all(unknowns), part;
    for (const SlackChange& change : direction) {
      const std::size_t place = place_of_contact_[change.contact];
      if (place == nowhere) return {};
      all[2 * place] = change.low;
      all[2 * place + 1] = change.high;
    }
    part.reserve(free.size());
    for (const std::size_t unknown : free) part.push_back(all[unknown]);
    return part;
  }

  void keep(const Region& region, const std::vector<double>& values) {
    NullDirection direction;
    for (std::size_t c = 0; c < region.contacts.size(); ++c) {
      const double low = values[2 * c], high = values[2 * c + 1];
      if (std::abs(low) < elimination_zero && std::abs(high) < elimination_zero) continue;
      directions_of_[region.contacts[c]].push_back(directions_.size());
      direction.push_back({region.contacts[c], low, high});
    }
    directions_.push_back(std::move(direction));
  }

  const ContactBalances& balances_;
  const OpenedContacts& opened_;
  std::vector<NullDirection> directions_;
  std::vector<std::vector<std::size_t>> directions_of_;  ///< those in which each contact changes
  std::vector<std::size_t> place_of_bead_, place_of_contact_;
};

/// The beads that are reached from bead (layer, column) by fewer than `size` steps to the lower left and fewer than
/// `size` to the lower right, as far as they exist, with the contacts among them and those with the floor. `layer` may
/// lie above the top.
Region rhombus(const Collection& collection, const Lattice& lattice, int layer, int column, int size) {
  Region region;
  const int columns = lattice.columns();
  const auto exists = [&](int left, int right) {
    const int at = layer + left + right;
    return left < size && right < size && at >= 0 && at < lattice.layers();
  };
  for (int down = 0; down <= 2 * (size - 1); ++down) {  // layer by layer: the order in which balances are solved
    for (int left = std::max(0, down - size + 1); left <= std::min(down, size - 1); ++left) {
      const int right = down - left;
      if (!exists(left, right)) continue;
      // Twice x, from which the shift of odd layers is taken off.
      const int twice = 2 * column + std::abs(layer % 2) + right - left, shift = (layer + down) % 2;
      const int i = (((twice - shift) / 2) % columns + columns) % columns;
      const std::size_t bead = lattice.index(layer + down, i);
      const bool on_floor = layer + down == lattice.layers() - 1;
      region.beads.push_back(bead);
      for (const bool to_right : {true, false}) {
        const std::size_t contact = to_right ? bead : lattice.beads() + bead;
        if (collection.opened(contact)) continue;
        if (on_floor || exists(left + (to_right ? 0 : 1), right + (to_right ? 1 : 0))) {
          region.contacts.push_back(contact);
        }
      }
    }
  }
  return region;
}

/// All contacts that leave the layers first .. first + layers - 1, with the beads at their ends.
Region ring(const Collection& collection, const Lattice& lattice, int first, int layers) {
  Region region;
  for (int layer = first; layer <= std::min(first + layers, lattice.layers() - 1); ++layer) {
    for (int i = 0; i < lattice.columns(); ++i) {
      const std::size_t bead = lattice.index(layer, i);
      region.beads.push_back(bead);
      for (const std::size_t contact : {bead, lattice.beads() + bead}) {
        if (layer < first + layers && !collection.opened(contact)) region.contacts.push_back(contact);
      }
    }
  }
  return region;
}

}  // namespace

std::vector<NullDirection> find_null_directions(const ContactBalances& balances, const OpenedContacts& opened) {
  const Lattice& lattice = balances.lattice();
  Collection collection(balances, opened);
  const bool diluted = std::any_of(opened.begin(), opened.end(), [](std::uint8_t one) { return one != 0; });
  // Without opened contacts the smallest regions hold all there is.
  const int largest_rhombus = std::min(diluted ? 6 : 3, lattice.columns() - 1), highest_ring = diluted ? 3 : 1;
  for (int size = 3; size <= largest_rhombus; ++size) {
    for (int layer = -2 * (size - 1); layer < lattice.layers(); ++layer) {
      for (int i = 0; i < lattice.columns(); ++i) collection.add(rhombus(collection, lattice, layer, i, size));
    }
  }
  for (int layers = 1; layers <= highest_ring; ++layers) {
    for (int layer = 0; layer < lattice.layers(); ++layer) collection.add(ring(collection, lattice, layer, layers));
  }
  collection.add(ring(collection, lattice, 0, lattice.layers()));
  return std::move(collection.directions());
}

}  // namespace granuscope
