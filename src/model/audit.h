#pragma once
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

/// Recomputes every balance and every cone in normal and tangential components (N, T), which is not the form the
/// samplers work in. Throws InputError if a force is not finite.
AuditResult audit(const Pile& pile);

/// The same, layer by layer from the top.
std::vector<LayerResidual> audit_layers(const Pile& pile);

}  // namespace granuscope
