#pragma once
#include <optional>

#include "sampling/model_spec.h"

namespace granuscope {

/// What noise that is correlated in depth makes of the mean response, to second order in it: with Delta the standard
/// deviation of v relative to what it changes (1 + v),
///   c^2 = c0^2 (1 - kappa Delta^2),   D = D0 + spreading Delta^2.
struct NoiseShift {
  double kappa = 0, spreading = 0;  ///< dimensionless, bead diameters
};

/// The theory of a model's noise. Of noise that is independent from row to row nothing is left of it.
struct NoiseTheory {
  double c0 = 0, D0 = 0;  ///< of the medium without noise that has the same means
  double disorder = 0;    ///< Delta
  double cell = 0;        ///< width within which noise is alike, bead diameters
  NoiseShift wide;        ///< of peaks wider than cells, and of c_thrust: the limit k -> 0 of the paper's theory
  /// Of peaks that are narrower, stochastic OSL only: they are handed on without being thrown back, and only run faster
  /// or slower by the noise that they meet.
  std::optional<NoiseShift> narrow;

  /// Of peaks of that width.
  const NoiseShift& shift(double width) const { return narrow && width < cell ? *narrow : wide; }
  double c(double width) const;
  double D(double width) const { return D0 + shift(width).spreading * disorder * disorder; }
};

/// Of stochastic OSL in the continuum, g_x and g_z being the triangles that cells at random places give. To second
/// order a wave e^(ikx) meets c(k)^2 = c0^2 (1 + Delta^2 Q), 2 Q = int du g_z(u/c0) {[g_x' + ik g_x] e^(2iku) + g_x' -
/// ik g_x}, the first part thrown back twice, and D = -2 Im c(k)/k. So kappa = int du g_z (-g_x') and spreading = c0
/// int du u g_z
/// (-g_x') as k -> 0; kappa/2 + 1/4 and c0/2 int du g_z g_x for k far above 1/cell. And of the three-leg model whose
/// noise is free, on its lattice, from the force that comes back to where it was handed down otherwise, by the same
/// steps for k -> 0. Throws std::logic_error for another model.
NoiseTheory noise_theory(const ModelSpec& model);

}  // namespace granuscope
