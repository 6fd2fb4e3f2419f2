#include "model/identities.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace granuscope {
namespace {

/// The larger residual. One that is not a number counts as infinite: std::max would pass over it.
double worse(double worst, double residual) {
  return std::isfinite(residual) ? std::max(worst, residual) : std::numeric_limits<double>::infinity();
}

/// Sum and largest entry of a row. Eight running values instead of one let the compiler use vectors: the check runs on
/// every sampled pile.
struct RowFacts {
  double sum, largest;
};
RowFacts facts(const std::vector<double>& row) {
  constexpr std::size_t lanes = 8;
  std::array<double, lanes> sums{}, maxima{};
  std::size_t i = 0;
  for (; i + lanes <= row.size(); i += lanes) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      sums[lane] += row[i + lane];
      maxima[lane] = maxima[lane] > row[i + lane] ? maxima[lane] : row[i + lane];
    }
  }
  RowFacts result{0, 0};
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
    const RowFacts weights = facts(weight);
    const double total = total_load + pile.bead_weight * static_cast<double>(columns) * (n + 1);
    worst.weight_sum = worse(worst.weight_sum, std::abs(weights.sum - total) / total);
    if (n >= 2) {
      // Bead i of layer n lies straight below bead i of layer n-2, between its two parents in layer n-1, the left of
      // which is ring[i].
      const std::ptrdiff_t first = lattice.upper_left(n, 0);
      std::rotate_copy(H.begin(), H.begin() + first, H.end(), ring.begin());
      ring.back() = ring.front();
      for (std::size_t i = 0; i < columns; ++i) {
        residual[i] = std::abs(weight[i] - (above[i] + 2 * pile.bead_weight + sqrt3 * (ring[i] - ring[i + 1])));
      }
      const RowFacts residuals = facts(residual);
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
