#pragma once
#include <cstdint>
#include <string>

#include "model/pile.h"

namespace granuscope {

/// Worst residuals of the identities every pile obeys exactly, relative to the largest force involved.
struct IdentityResiduals {
  /// Each layer's sum of w against that of the loads and of the weights g of the beads down to it, relative to these.
  double weight_sum = 0;
  double wave_equation = 0;  ///< w_{n+1}(x) = w_{n-1}(x) + 2 g + sqrt(3) [H_n(x - 1/2) - H_n(x + 1/2)], bead by bead
};

/// Largest rounding error of an identity that a correct pile shows. 500 columns x 1000 layers stay below 1e-13.
inline constexpr double identity_tolerance = 1e-11;

IdentityResiduals identity_residuals(const Pile& pile);

/// Throws std::logic_error if an identity fails: the sampler is broken, not the input.
void assert_identities(const Pile& pile);
void assert_identities(const IdentityResiduals& residuals, const std::string& law, double mu, std::uint64_t seed,
                       std::uint64_t sample);

}  // namespace granuscope
