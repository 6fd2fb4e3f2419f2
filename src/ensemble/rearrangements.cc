#include "ensemble/rearrangements.h"

namespace granuscope {

void measure_rearrangements(const Lattice& lattice, const std::vector<unsigned char>& redrawn,
                            std::vector<int>& beads) {
  beads.assign(redrawn.size(), 0);
  std::vector<std::size_t> waiting;
  std::vector<std::size_t> found;
  for (std::size_t start = 0; start < redrawn.size(); ++start) {
    if (redrawn[start] == 0 || beads[start] != 0) continue;
    const auto visit = [&](int layer, int bead) {
      const std::size_t at = lattice.index(layer, bead);
      if (redrawn[at] == 0 || beads[at] != 0) return;
      beads[at] = 1;
      found.push_back(at);
      waiting.push_back(at);
    };
    const auto columns = static_cast<std::size_t>(lattice.columns());
    found.clear();
    visit(static_cast<int>(start / columns), static_cast<int>(start % columns));
    while (!waiting.empty()) {
      const int layer = static_cast<int>(waiting.back() / columns), bead = static_cast<int>(waiting.back() % columns);
      waiting.pop_back();
      if (layer > 0) {
        visit(layer - 1, lattice.upper_left(layer, bead));
        visit(layer - 1, lattice.upper_right(layer, bead));
      }
      if (layer + 1 < lattice.layers()) {
        visit(layer + 1, lattice.lower_left(layer, bead));
        visit(layer + 1, lattice.lower_right(layer, bead));
      }
    }
    for (const std::size_t at : found) beads[at] = static_cast<int>(found.size());
  }
}

}  // namespace granuscope
