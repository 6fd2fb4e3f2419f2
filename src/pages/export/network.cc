#include "export/network.h"

#include <cmath>
#include <limits>
#include <vector>

#include "model/audit.h"
#include "support/progress.h"

namespace granuscope {
namespace {

/// Beads of a piece, at least: writing it is then one call of the system for each array.
constexpr std::size_t enough = 8192;

NetworkContact contact_of(const PileView& pile, const NetworkBead& bead, bool right) {
  const Lattice& lattice = pile.lattice;
  const BeadGeometry& to = lattice.geometry();
  const std::size_t at = pile.index(bead.layer, bead.column);
  NetworkContact contact;
  contact.upper = bead.number;
  contact.x = bead.x;
  contact.z = bead.z;
  contact.branch_x = (right ? 0.5 : -0.5) * lattice.pitch();
  contact.branch_z = lattice.spacing();
  contact.V = right ? pile.V_R[at] : pile.V_L[at];
  contact.H = right ? pile.H_R[at] : pile.H_L[at];
  const ResolvedForce force = right ? resolve_right(to, contact.V, contact.H) : resolve_left(to, contact.V, contact.H);
  contact.N = force.N;
  contact.T = force.T;
  const double most = pile.mu * force.N;
  contact.share = most > 0 ? std::abs(force.T) / most : std::numeric_limits<double>::quiet_NaN();
  if (bead.layer + 1 == lattice.layers()) return contact;
  const int below = right ? lattice.lower_right(bead.layer, bead.column) : lattice.lower_left(bead.layer, bead.column);
  contact.lower = static_cast<std::int64_t>(lattice.index(bead.layer + 1, below));
  contact.across_seam = std::abs(lattice.x(bead.layer + 1, below) - bead.x) > lattice.pitch();
  return contact;
}

}  // namespace

void for_each_piece(PileLayers& pile,
                    const std::function<void(std::span<const NetworkBead>, std::span<const NetworkContact>)>& visit) {
  const Lattice lattice = pile.about().lattice;
  std::vector<NetworkBead> beads;
  std::vector<NetworkContact> contacts;
  for (int layer = 0; layer < lattice.layers(); ++layer) {
    throw_if_interrupted();
    const PileView& view = pile.hold(layer > 0 ? layer - 1 : 0, layer);
    for (int column = 0; column < lattice.columns(); ++column) {
      const std::size_t at = view.index(layer, column);
      const auto number = static_cast<std::int64_t>(lattice.index(layer, column));
      beads.push_back({number, layer, column, lattice.x(layer, column), lattice.z(layer), view.V_R[at] + view.V_L[at],
                       balance_residual(view, layer, column)});
      for (const bool right : {false, true}) contacts.push_back(contact_of(view, beads.back(), right));
    }
    if (beads.size() < enough && layer + 1 < lattice.layers()) continue;
    visit(beads, contacts);
    beads.clear();
    contacts.clear();
  }
}

}  // namespace granuscope
