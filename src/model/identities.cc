#include "model/identities.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace granuscope {
namespace {

/// The larger residual. One that is not a number counts as infinite: std::max would pass over it.
double worse(double worst, double residual) {
  return std::isfinite(residual) ? std::max(worst, residual) : std::numeric_limits<double>::infinity();
}

}  // namespace

IdentityResiduals identity_residuals(const Pile& pile) {
  const Lattice& lattice = pile.lattice;
  double total_load = 0;
  for (double load : pile.load) total_load += load;
  IdentityResiduals worst;
  for (int n = 0; n < lattice.layers(); ++n) {
    double total = 0;
    for (int i = 0; i < lattice.columns(); ++i) total += pile.V_R[lattice.index(n, i)] + pile.V_L[lattice.index(n, i)];
    worst.weight_sum = worse(worst.weight_sum, std::abs(total - total_load) / total_load);
  }
  const auto weight = [&](int n, int i) { return pile.V_R[lattice.index(n, i)] + pile.V_L[lattice.index(n, i)]; };
  // H leaving a bead equals H entering it.
  const auto horizontal = [&](int n, int i) { return pile.H_R[lattice.index(n, i)] + pile.H_L[lattice.index(n, i)]; };
  for (int n = 1; n + 1 < lattice.layers(); ++n) {
    double residual = 0, largest = 0;
    for (int i = 0; i < lattice.columns(); ++i) {
      // Bead i of layer n+1 lies straight below bead i of layer n-1, between its two parents in layer n.
      const int left = lattice.upper_left(n + 1, i), right = lattice.upper_right(n + 1, i);
      const double expected = weight(n - 1, i) + sqrt3 * (horizontal(n, left) - horizontal(n, right));
      residual = worse(residual, std::abs(weight(n + 1, i) - expected));
      largest = std::max({largest, weight(n - 1, i), weight(n + 1, i)});
    }
    if (largest > 0) worst.wave_equation = worse(worst.wave_equation, residual / largest);
  }
  return worst;
}

void assert_identities(const Pile& pile) {
  const IdentityResiduals residuals = identity_residuals(pile);
  if (!(residuals.weight_sum <= identity_tolerance && residuals.wave_equation <= identity_tolerance)) {
    throw std::logic_error(fmt::format(
        "a sampled pile breaks an exact identity (sum of weights off by {:.3g}, local wave equation by {:.3g}; at most "
        "{:.0e} is rounding): law {}, mu {}, seed {}, sample {}",
        residuals.weight_sum, residuals.wave_equation, identity_tolerance, pile.law, pile.mu, pile.seed, pile.sample));
  }
}

}  // namespace granuscope
