#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "model/pile.h"

namespace granuscope {
/// Worst residuals of a pile, each relative to the largest contact force of the same layer.
struct AuditResult {
  double max_balance_residual = 0;  ///< of vertical, horizontal and torque balance, over all beads
  double max_cone_violation = 0;    ///< how far |T| exceeds mu N, or N falls below 0; 0 if never
  int balance_layer = 0;            ///< where the worst balance residual is
  int cone_layer = 0;               ///< where the worst violation is
};

/// Worst residuals of one layer, relative to its largest contact force.
struct LayerResidual {
  double balance = 0, cone = 0;
};

/// A contact force in components normal (compression > 0) and tangential to the contact.
struct ResolvedForce {
  double N, T;
};

/// Contact towards the lower right.
inline ResolvedForce resolve_right(const BeadGeometry& to, double V, double H) {
  return {(to.twice_sine * H + to.twice_cosine * V) / 2, (to.twice_cosine * H - to.twice_sine * V) / 2};
}
/// Contact towards the lower left.
inline ResolvedForce resolve_left(const BeadGeometry& to, double V, double H) {
  return {(-to.twice_sine * H + to.twice_cosine * V) / 2, (to.twice_cosine * H + to.twice_sine * V) / 2};
}

/// The largest residual of vertical, horizontal and torque balance of one bead, recomputed from N and T; not a number
/// if a force is none. The view has the layer above the bead, too.
double balance_residual(const PileView& pile, int layer, int bead);

/// Recomputes every balance and every cone in normal and tangential components (N, T), which is not the form the
/// samplers work in. Throws InputError if a force is not finite.
AuditResult audit(const Pile& pile);

/// The same, layer by layer from the top.
std::vector<LayerResidual> audit_layers(const Pile& pile);

/// Worst residuals of the identities every pile obeys exactly, relative to the largest force involved.
struct IdentityResiduals {
  /// Each layer's sum of w against that of the loads and of the weights g of the beads down to it, relative to these.
  double weight_sum = 0;
  double wave_equation = 0;  ///< w_{n+1}(x) = w_{n-1}(x) + 2 g + cot [H_n(x - 1/2) - H_n(x + 1/2)], bead by bead
};

/// Largest rounding error of an identity that a correct pile shows. 500 columns x 1000 layers stay below 1e-13.
inline constexpr double identity_tolerance = 1e-11;

IdentityResiduals identity_residuals(const Pile& pile);

/// Throws std::logic_error if an identity fails: the sampler is broken, not the input.
void assert_identities(const Pile& pile);
void assert_identities(const IdentityResiduals& residuals, const std::string& law, double mu, std::uint64_t seed,
                       std::uint64_t sample);

}  // namespace granuscope
