#pragma once
#include <cstddef>

#include "support/error.h"
#include "support/key.h"

namespace granuscope {
/// Size of a pile. Layers counts the layers computed, not only those that are used.
struct LatticeSpec {
  int columns = 500;  ///< beads per layer, periodic in x; at least 4
  int layers = 200;   ///< layer 0 is the top one
};

/// Around a ring of fewer beads a bead is its own neighbour.
inline constexpr int fewest_columns = 4;
inline constexpr int fewest_layers = 1;

/// Of an experiment: beyond them a slip of the keyboard is more likely than an intention.
inline constexpr int most_columns = 1'000'000, most_layers = 1'000'000;

/// [lattice], bound to the spec, with the ranges of experiments: a lattice by itself may be smaller and larger.
std::vector<Key> keys_of(LatticeSpec& spec);

/// Where the rows of a model lie. Lengths in bead diameters: neighbours in a row are 1 apart.
struct RowGeometry {
  double spacing = 1.7320508075688772935 / 2;  ///< of rows in depth; by default that of the beads
  bool staggered = true;                       ///< every other row lies half a bead further right

  /// z of a row, counted from the surface as that of the beads is.
  double depth(int row) const { return 0.5 + row * spacing; }
  bool shifted(int row) const { return staggered && row % 2 == 1; }
  bool operator==(const RowGeometry&) const = default;
};

/// What makes it no lattice.
Problem find_problem(const LatticeSpec& spec);

/// Layers at the bottom whose law differs from the bulk, because failures below them reach up.
inline constexpr int bottom_margin = 20;

/// tan 30°: direction of the contacts, and the propagation coefficient without friction (c0 of the paper).
inline constexpr double tan30 = 0.57735026918962576451;
inline constexpr double sqrt3 = 1.7320508075688772935;

/// The triangular lattice, periodic in x. Lengths in bead diameters, x to the right, z down.
/// Bead (n, i) has its centre at x = i + (n mod 2)/2; it rests on its lower-left and lower-right neighbours in layer
/// n+1.
class Lattice {
 public:
  /// Throws InputError if there is a find_problem(spec).
  explicit Lattice(LatticeSpec spec);

  int columns() const { return spec_.columns; }
  int layers() const { return spec_.layers; }
  std::size_t beads() const { return static_cast<std::size_t>(spec_.columns) * static_cast<std::size_t>(spec_.layers); }
  std::size_t index(int layer, int bead) const {
    return static_cast<std::size_t>(layer) * static_cast<std::size_t>(spec_.columns) + static_cast<std::size_t>(bead);
  }

  /// Bead of layer n+1 below and to the right of bead (n, i).
  int lower_right(int layer, int bead) const { return layer % 2 == 0 ? bead : next(bead); }
  int lower_left(int layer, int bead) const { return layer % 2 == 0 ? previous(bead) : bead; }
  /// Bead of layer n-1 above and to the left of bead (n, i).
  int upper_left(int layer, int bead) const { return layer % 2 == 0 ? previous(bead) : bead; }
  int upper_right(int layer, int bead) const { return layer % 2 == 0 ? bead : next(bead); }
  int next(int bead) const { return bead + 1 == spec_.columns ? 0 : bead + 1; }
  int previous(int bead) const { return bead == 0 ? spec_.columns - 1 : bead - 1; }

  /// The bead of the top layer that carries the overload; x of a response counts from it.
  int middle() const { return spec_.columns / 2; }
  /// x of bead (n, i) relative to the overloaded bead, in [-columns/2, columns/2).
  double x(int layer, int bead) const;
  /// Layers 0 .. usable_layers()-1 follow the bulk law (at least 0).
  int usable_layers() const { return spec_.layers > bottom_margin ? spec_.layers - bottom_margin : 0; }

  /// Depth of layer n: z_n = 1/2 + n sqrt(3)/2, in bead diameters. (The only form that fits the depths in the caption
  /// of the paper's Fig. 2: layers 110 and 170 of 200.)
  static double depth(int layer) { return 0.5 + layer * (sqrt3 / 2); }

 private:
  LatticeSpec spec_;
};

/// Coulomb's cone of half angle atan(mu) around a contact 30° from the vertical, in (V, H) of that contact:
///   t_minus V_R <= H_R <= t_plus V_R,   t_minus V_L <= -H_L <= t_plus V_L.
/// t_minus = tan(30° - atan mu), t_plus = tan(30° + atan mu).
class FrictionCone {
 public:
  /// Throws InputError unless 0 <= mu < sqrt(3) (at sqrt(3) the cone reaches the horizontal).
  explicit FrictionCone(double mu);
  double mu() const { return mu_; }
  double t_minus() const { return t_minus_; }
  double t_plus() const { return t_plus_; }
  /// k = sqrt(3) (t_minus + t_plus) - 1 > 0, the slope that enters the band of solvable H.
  double k() const { return k_; }
  double t_minus_over_k() const { return t_minus_over_k_; }
  double t_plus_over_k() const { return t_plus_over_k_; }

 private:
  double mu_, t_minus_, t_plus_, k_, t_minus_over_k_, t_plus_over_k_;
};

}  // namespace granuscope
