#include "model/audit.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "model/friction_cone.h"
#include "model/incoming.h"
#include "support/error.h"

namespace granuscope {
namespace {

/// A contact force in components normal (compression > 0) and tangential to the contact.
struct ContactForce {
  double N, T;
};

/// Contact towards the lower right: its direction is 30 degrees to the right of the vertical.
ContactForce resolve_right(double V, double H) { return {(H + sqrt3 * V) / 2, (sqrt3 * H - V) / 2}; }
/// Contact towards the lower left.
ContactForce resolve_left(double V, double H) { return {(-H + sqrt3 * V) / 2, (sqrt3 * H + V) / 2}; }

// Back to Cartesian components, from N and T only, so that the balances below never see the sampler's V and H.
double vertical_right(ContactForce f) { return (sqrt3 * f.N - f.T) / 2; }
double vertical_left(ContactForce f) { return (sqrt3 * f.N + f.T) / 2; }
double horizontal_right(ContactForce f) { return (f.N + sqrt3 * f.T) / 2; }
double horizontal_left(ContactForce f) { return (-f.N + sqrt3 * f.T) / 2; }

}  // namespace

std::vector<LayerResidual> audit_layers(const Pile& pile) {
  const Lattice& lattice = pile.lattice;
  const FrictionCone cone(pile.mu);
  std::vector<LayerResidual> layers;
  layers.reserve(static_cast<std::size_t>(lattice.layers()));
  for (int n = 0; n < lattice.layers(); ++n) {
    double largest = 0, balance = 0, violation = 0;
    for (int i = 0; i < lattice.columns(); ++i) {
      const std::size_t at = lattice.index(n, i);
      const ContactForce R = resolve_right(pile.V_R[at], pile.H_R[at]);
      const ContactForce L = resolve_left(pile.V_L[at], pile.H_L[at]);
      ContactForce UL, UR;
      if (n == 0) {
        // The load enters through both upper contacts; how they divide its horizontal part changes no balance.
        const Incoming load = top_load(pile.load[static_cast<std::size_t>(i)], pile.load_line);
        UL = resolve_right(load.V_UL, load.H / 2);
        UR = resolve_left(load.V_UR, load.H / 2);
      } else {
        const std::size_t a = lattice.index(n - 1, lattice.upper_left(n, i));
        const std::size_t b = lattice.index(n - 1, lattice.upper_right(n, i));
        UL = resolve_right(pile.V_R[a], pile.H_R[a]);
        UR = resolve_left(pile.V_L[b], pile.H_L[b]);
      }
      const double vertical =
          vertical_right(UL) + vertical_left(UR) + pile.bead_weight - vertical_right(R) - vertical_left(L);
      const double horizontal = horizontal_right(UL) + horizontal_left(UR) - horizontal_right(R) - horizontal_left(L);
      const double torque = UL.T + UR.T + L.T + R.T;
      if (!std::isfinite(vertical + horizontal + torque)) {
        throw InputError(
            fmt::format("the force network has a force that is not finite at layer {}, bead {}: it cannot "
                        "be audited; sample it again",
                        n, i));
      }
      balance = std::max({balance, std::abs(vertical), std::abs(horizontal), std::abs(torque)});
      for (const ContactForce& f : {R, L}) {
        largest = std::max(largest, std::hypot(f.N, f.T));
        violation = std::max({violation, std::abs(f.T) - cone.mu() * f.N, -f.N});
      }
    }
    // Where forces vanish but do not balance, the absolute residual.
    const double unit = largest > 0 ? largest : 1;
    layers.push_back({balance / unit, violation / unit});
  }
  return layers;
}

AuditResult audit(const Pile& pile) {
  AuditResult worst;
  int layer = 0;
  for (const LayerResidual& one : audit_layers(pile)) {
    if (one.balance > worst.max_balance_residual) worst.max_balance_residual = one.balance, worst.balance_layer = layer;
    if (one.cone > worst.max_cone_violation) worst.max_cone_violation = one.cone, worst.cone_layer = layer;
    ++layer;
  }
  return worst;
}

}  // namespace granuscope
