#include "model/audit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "model/equilibrium.h"
#include "model/lattice.h"
#include "support/error.h"

namespace granuscope {
namespace {

// Back to Cartesian components, from N and T only, so that the balances below never see the sampler's V and H.
double vertical_right(const BeadGeometry& to, ResolvedForce f) {
  return (to.twice_cosine * f.N - to.twice_sine * f.T) / 2;
}
double vertical_left(const BeadGeometry& to, ResolvedForce f) {
  return (to.twice_cosine * f.N + to.twice_sine * f.T) / 2;
}
double horizontal_right(const BeadGeometry& to, ResolvedForce f) {
  return (to.twice_sine * f.N + to.twice_cosine * f.T) / 2;
}
double horizontal_left(const BeadGeometry& to, ResolvedForce f) {
  return (-to.twice_sine * f.N + to.twice_cosine * f.T) / 2;
}

}  // namespace

double balance_residual(const PileView& pile, int layer, int bead) {
  const BeadGeometry& to = pile.lattice.geometry();
  const std::size_t at = pile.index(layer, bead);
  const ResolvedForce R = resolve_right(to, pile.V_R[at], pile.H_R[at]);
  const ResolvedForce L = resolve_left(to, pile.V_L[at], pile.H_L[at]);
  ResolvedForce UL, UR;
  if (layer == 0) {
    // The load enters through both upper contacts; how they divide its horizontal part changes no balance.
    const Incoming load = top_load(pile.load[static_cast<std::size_t>(bead)], pile.load_line);
    UL = resolve_right(to, load.V_UL, load.H / 2);
    UR = resolve_left(to, load.V_UR, load.H / 2);
  } else {
    const std::size_t a = pile.index(layer - 1, pile.lattice.upper_left(layer, bead));
    const std::size_t b = pile.index(layer - 1, pile.lattice.upper_right(layer, bead));
    UL = resolve_right(to, pile.V_R[a], pile.H_R[a]);
    UR = resolve_left(to, pile.V_L[b], pile.H_L[b]);
  }
  const double vertical =
      vertical_right(to, UL) + vertical_left(to, UR) + pile.bead_weight - vertical_right(to, R) - vertical_left(to, L);
  const double horizontal =
      horizontal_right(to, UL) + horizontal_left(to, UR) - horizontal_right(to, R) - horizontal_left(to, L);
  const double torque = UL.T + UR.T + L.T + R.T;
  if (!std::isfinite(vertical + horizontal + torque)) return std::numeric_limits<double>::quiet_NaN();
  return std::max({std::abs(vertical), std::abs(horizontal), std::abs(torque)});
}

std::vector<LayerResidual> audit_layers(const Pile& pile) {
  const Lattice& lattice = pile.lattice;
  const BeadGeometry& to = lattice.geometry();
  const FrictionCone cone(pile.mu, to);
  const PileView view = view_of(pile);
  std::vector<LayerResidual> layers;
  layers.reserve(static_cast<std::size_t>(lattice.layers()));
  for (int n = 0; n < lattice.layers(); ++n) {
    double largest = 0, balance = 0, violation = 0;
    for (int i = 0; i < lattice.columns(); ++i) {
      const double residual = balance_residual(view, n, i);
      if (std::isnan(residual)) {
        throw InputError(
            "the force network has a force that is not finite at layer {}, bead {}: it cannot "
            "be audited; sample it again",
            n, i);
      }
      balance = std::max(balance, residual);
      const std::size_t at = lattice.index(n, i);
      for (const ResolvedForce& f :
           {resolve_right(to, pile.V_R[at], pile.H_R[at]), resolve_left(to, pile.V_L[at], pile.H_L[at])}) {
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

namespace {

/// The larger residual. One that is not a number counts as infinite: std::max would pass over it.
double worse(double worst, double residual) {
  return std::isfinite(residual) ? std::max(worst, residual) : std::numeric_limits<double>::infinity();
}

/// Sum and largest entry of a row. Eight running values instead of one let the compiler use vectors: the check runs on
/// every sampled pile.
struct IdentityFacts {
  double sum, largest;
};
IdentityFacts facts(const std::vector<double>& row) {
  constexpr std::size_t lanes = 8;
  std::array<double, lanes> sums{}, maxima{};
  std::size_t i = 0;
  for (; i + lanes <= row.size(); i += lanes) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      sums[lane] += row[i + lane];
      maxima[lane] = maxima[lane] > row[i + lane] ? maxima[lane] : row[i + lane];
    }
  }
  IdentityFacts result{0, 0};
  for (; i < row.size(); ++i) result = {result.sum + row[i], std::max(result.largest, row[i])};
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    result = {result.sum + sums[lane], std::max(result.largest, maxima[lane])};
  }
  return result;
}

/// out[i] = a[i] + b[i] along one row of a pile.
void add_rows(const double* a, const double* b, std::vector<double>& out) {
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = a[i] + b[i];
}

}  // namespace

IdentityResiduals identity_residuals(const Pile& pile) {
  const Lattice& lattice = pile.lattice;
  const auto columns = static_cast<std::size_t>(lattice.columns());
  double total_load = 0;
  for (double load : pile.load) total_load += load;
  IdentityResiduals worst;
  // Weights of layers n-2, n-1 and n; H of layer n-1 (what leaves a bead equals what enters it), and the same begun at
  // the left parent of bead 0, with its first entry again behind the last, because the lattice is a ring.
  std::vector<double> above(columns), middle(columns), weight(columns), H(columns), ring(columns + 1),
      residual(columns);
  double largest_above = 0, largest_middle = 0, largest_H = 0;
  for (int n = 0; n < lattice.layers(); ++n) {
    const std::size_t row = lattice.index(n, 0);
    add_rows(&pile.V_R[row], &pile.V_L[row], weight);
    const IdentityFacts weights = facts(weight);
    const double total = total_load + pile.bead_weight * static_cast<double>(columns) * (n + 1);
    worst.weight_sum = worse(worst.weight_sum, std::abs(weights.sum - total) / total);
    if (n >= 2) {
      // Bead i of layer n lies straight below bead i of layer n-2, between its two parents in layer n-1, the left of
      // which is ring[i].
      const std::ptrdiff_t first = lattice.upper_left(n, 0);
      std::rotate_copy(H.begin(), H.begin() + first, H.end(), ring.begin());
      ring.back() = ring.front();
      for (std::size_t i = 0; i < columns; ++i) {
        residual[i] = std::abs(
            weight[i] - (above[i] + 2 * pile.bead_weight + lattice.geometry().cotangent * (ring[i] - ring[i + 1])));
      }
      const IdentityFacts residuals = facts(residual);
      const double largest = std::max({largest_above, largest_H, weights.largest});
      if (!std::isfinite(residuals.sum)) worst.wave_equation = std::numeric_limits<double>::infinity();
      if (largest > 0) worst.wave_equation = worse(worst.wave_equation, residuals.largest / largest);
    }
    add_rows(&pile.H_R[row], &pile.H_L[row], H);
    // Near mu = sqrt(3) the two parts of H are far larger than H and than any weight; their rounding is what remains.
    for (std::size_t i = 0; i < columns; ++i) residual[i] = std::abs(pile.H_R[row + i]);
    largest_H = facts(residual).largest;
    std::swap(above, middle);
    std::swap(middle, weight);
    largest_above = largest_middle;
    largest_middle = weights.largest;
  }
  return worst;
}

void assert_identities(const Pile& pile) {
  assert_identities(identity_residuals(pile), pile.law, pile.mu, pile.seed, pile.sample);
}

void assert_identities(const IdentityResiduals& residuals, const std::string& law, double mu, std::uint64_t seed,
                       std::uint64_t sample) {
  if (!(residuals.weight_sum <= identity_tolerance && residuals.wave_equation <= identity_tolerance)) {
    throw std::logic_error(fmt::format(
        "a sampled pile breaks an exact identity (sum of weights off by {:.3g}, local wave equation by {:.3g}; at most "
        "{:.0e} is rounding): law {}, mu {}, seed {}, sample {}",
        residuals.weight_sum, residuals.wave_equation, identity_tolerance, law, mu, seed, sample));
  }
}

}  // namespace granuscope
