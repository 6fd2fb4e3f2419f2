#pragma once
#include <cmath>
#include <limits>
#include <vector>

#include "model/pile.h"
#include "render/scene.h"

namespace granuscope {

/// The frictionless pile under `load`, exact (docs: the equilibrium of one bead with H_R = V_R/sqrt(3)): forces go
/// straight along the contacts.
inline Pile frictionless_pile(int columns, int layers, double middle_load = 2) {
  Pile pile(Lattice({columns, layers}));
  pile.law = "granusolve";
  const Lattice& lattice = pile.lattice;
  pile.load[static_cast<std::size_t>(lattice.middle())] = middle_load;
  for (int n = 0; n < layers; ++n) {
    for (int i = 0; i < columns; ++i) {
      double V_UL = 0, V_UR = 0;
      if (n == 0) {
        V_UL = V_UR = 0.5 * pile.load[static_cast<std::size_t>(i)];
      } else {
        // The upper-left neighbour pushes with its lower-right contact.
        V_UL = pile.V_R[lattice.index(n - 1, lattice.upper_left(n, i))];
        V_UR = pile.V_L[lattice.index(n - 1, lattice.upper_right(n, i))];
      }
      // H = (V_UL - V_UR)/sqrt(3), so that V_R = V_UR + sqrt(3) H = V_UL: written so, it is exact in floating point.
      const std::size_t k = lattice.index(n, i);
      pile.V_R[k] = V_UL;
      pile.V_L[k] = V_UR;
      pile.H_R[k] = V_UL / sqrt3;
      pile.H_L[k] = -V_UR / sqrt3;
    }
  }
  return pile;
}

/// Forces with no balance at all, every one different, the pile's left half unlike its right one: for tests of drawing.
inline Pile irregular_pile(int columns, int layers) {
  Pile pile(Lattice({columns, layers}));
  for (std::size_t k = 0; k < pile.lattice.beads(); ++k) {
    const double phase = static_cast<double>(k);
    pile.V_R[k] = 0.5 + 0.45 * std::sin(1.7 * phase);
    pile.V_L[k] = 0.5 + 0.45 * std::sin(2.3 * phase + 1);
    pile.H_R[k] = 0.3 * pile.V_R[k];
    pile.H_L[k] = -0.4 * pile.V_L[k];
  }
  return pile;
}

/// The pile seen in a mirror standing at the middle bead: x becomes -x.
inline Pile mirrored(const Pile& pile) {
  Pile mirror(pile.lattice);
  const Lattice& lattice = pile.lattice;
  const int columns = lattice.columns();
  for (int n = 0; n < lattice.layers(); ++n) {
    for (int i = 0; i < columns; ++i) {
      const int j = ((2 * lattice.middle() - i - n % 2) % columns + columns) % columns;
      const std::size_t from = lattice.index(n, i), to = lattice.index(n, j);
      mirror.V_R[to] = pile.V_L[from];
      mirror.V_L[to] = pile.V_R[from];
      mirror.H_R[to] = -pile.H_L[from];
      mirror.H_L[to] = -pile.H_R[from];
      if (n == 0) mirror.load[static_cast<std::size_t>(j)] = pile.load[static_cast<std::size_t>(i)];
    }
  }
  return mirror;
}

/// The scene of one pile, which must outlive it.
inline Scene scene_of(const Pile& pile, const SceneSpec& spec) { return build_scene(view_of(pile), nullptr, spec); }

/// All that a scene draws.
inline std::vector<Element> elements_of(const Scene& scene) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<Element> elements;
  scene.elements({-infinity, infinity, -infinity, infinity},
                 [&](const Element& element) { elements.push_back(element); });
  return elements;
}

/// Of a picture that takes no time.
inline SceneSpec small_spec() {
  SceneSpec spec;
  spec.width_px = 400;
  spec.dpi = 100;
  return spec;
}

}  // namespace granuscope
