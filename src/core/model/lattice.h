#pragma once
#include <cstddef>

#include "support/error.h"
#include "support/key.h"

namespace granuscope {
/// tan 30°: direction of the paper's contacts, and the propagation coefficient without friction (c0 of the paper).
inline constexpr double tan30 = 0.57735026918962576451;
inline constexpr double sqrt3 = 1.7320508075688772935;

/// Degrees between a contact and the vertical at which neighbours in a layer touch, too; no force passes between them.
inline constexpr double usual_angle = 30;
/// Above the latter every other layer would touch. Below 30 degrees discs would overlap in a layer: beads are then cut
/// at their sides, which bear nothing, and keep the four contacts at the ends of their diameters.
inline constexpr double least_angle = 20, most_angle = 60;

/// What the angle of the contacts makes of the lattice: the one place where the formulas of forces and depths take it
/// from. Without an angle the literal numbers of 30 degrees.
struct BeadGeometry {
  BeadGeometry() = default;
  explicit BeadGeometry(double degrees);
  double angle = usual_angle;
  double tangent = tan30;  ///< half the distance of neighbours over that of layers: c0
  double cotangent = sqrt3;
  double twice_sine = 1;  ///< distance of neighbours in a layer, bead diameters
  double twice_cosine = sqrt3;
};

/// Size of a pile. Layers counts the layers computed, not only those that are used.
struct LatticeSpec {
  int columns = 500;  ///< beads per layer, periodic in x; at least 4
  int layers = 200;   ///< layer 0 is the top one
  double angle = usual_angle;
};

/// Around a ring of fewer beads a bead is its own neighbour.
inline constexpr int fewest_columns = 4;
inline constexpr int fewest_layers = 1;

/// Of an experiment: beyond them a slip of the keyboard is more likely than an intention.
inline constexpr int most_columns = 1'000'000, most_layers = 1'000'000;

/// [lattice], bound to the spec, with the ranges of experiments: a lattice by itself may be smaller and larger.
std::vector<Key> keys_of(LatticeSpec& spec);

/// Where the rows of a model lie. Lengths in bead diameters.
struct RowGeometry {
  double spacing = sqrt3 / 2;  ///< of rows in depth; by default that of the beads
  bool staggered = true;       ///< every other row lies half a column further right
  double pitch = 1;            ///< distance of neighbours in a row

  /// z of a row, counted from the surface as that of the beads is.
  double depth(int row) const { return 0.5 + row * spacing; }
  bool shifted(int row) const { return staggered && row % 2 == 1; }
  /// c0, along straight contacts: half a column in a row; where none of these are known that of 30 degrees.
  double ray() const { return pitch == 1 ? tan30 : 0.5 * pitch / spacing; }
  bool operator==(const RowGeometry&) const = default;
};

/// What makes it no lattice.
Problem find_problem(const LatticeSpec& spec);

/// Layers at the bottom whose law differs from the bulk, because failures below them reach up.
inline constexpr int bottom_margin = 20;

/// The triangular lattice, periodic in x. Lengths in bead diameters, x to the right, z down.
/// Bead (n, i) has its centre at x = i + (n mod 2)/2 (times twice_sine: 1 at 30 degrees); it rests on its lower-left
/// and lower-right neighbours in layer n+1.
class Lattice {
 public:
  /// Throws InputError if there is a find_problem(spec).
  explicit Lattice(LatticeSpec spec);

  int columns() const { return spec_.columns; }
  int layers() const { return spec_.layers; }
  const BeadGeometry& geometry() const { return geometry_; }
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
  /// x of bead (n, i) relative to the overloaded bead, in [-half_width, half_width).
  double x(int layer, int bead) const;
  /// Layers 0 .. usable_layers()-1 follow the bulk law (at least 0).
  int usable_layers() const { return spec_.layers > bottom_margin ? spec_.layers - bottom_margin : 0; }

  double z(int layer) const { return 0.5 + layer * spacing(); }
  double spacing() const { return geometry_.twice_cosine / 2; }  ///< from one layer to the next
  double pitch() const { return geometry_.twice_sine; }          ///< of neighbours in a layer
  double half_width() const { return 0.5 * spec_.columns * pitch(); }
  /// Depth of layer n at 30 degrees: z_n = 1/2 + n sqrt(3)/2, in bead diameters. (The only form that fits the depths in
  /// the caption of the paper's Fig. 2: layers 110 and 170 of 200.)
  static double depth(int layer) { return 0.5 + layer * (sqrt3 / 2); }

 private:
  LatticeSpec spec_;
  BeadGeometry geometry_;
};

/// Coulomb's cone of half angle atan(mu) around a contact, in (V, H) of that contact:
///   t_minus V_R <= H_R <= t_plus V_R,   t_minus V_L <= -H_L <= t_plus V_L.
/// t_minus = tan(angle - atan mu), t_plus = tan(angle + atan mu).
class FrictionCone {
 public:
  /// Throws InputError unless 0 <= mu < cot(angle) (there the cone reaches the horizontal; at 30 degrees sqrt(3)).
  explicit FrictionCone(double mu, const BeadGeometry& geometry = {});
  double mu() const { return mu_; }
  double tangent() const { return tangent_; }
  double cotangent() const { return cotangent_; }
  /// The friction coefficient at 30 degrees whose cone, H stretched to that angle, reaches as far as this one does at
  /// the farther end: for planning rings and layers from what is known there. (sqrt(3)/2) mu/sin(2 angle) if small.
  double mu_at_30() const;
  double t_minus() const { return t_minus_; }
  double t_plus() const { return t_plus_; }
  /// k = cot(angle) (t_minus + t_plus) - 1 > 0, the slope that enters the band of solvable H.
  double k() const { return k_; }
  double t_minus_over_k() const { return t_minus_over_k_; }
  double t_plus_over_k() const { return t_plus_over_k_; }

 private:
  double mu_, tangent_, cotangent_, t_minus_, t_plus_, k_, t_minus_over_k_, t_plus_over_k_;
};

}  // namespace granuscope
