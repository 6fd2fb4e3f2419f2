#include "analysis/expected_response.h"

#include <algorithm>
#include <cmath>

#include "model/lattice.h"

namespace granuscope {

double expected_width(double mu, double z) { return std::sqrt(1 + 2.2 * std::pow(mu, 2.5) * z); }

double expected_speed(double mu) { return mu > 1 ? tan30 + 0.8 * std::pow(mu - 1, 2) : tan30; }

// Up to tan30 the peaks stay clear of each other by four widths each; where friction makes them faster, by two each:
// the fit knows their images on the ring, but not which of two that coincide is which.
double columns_needed(double mu, int layer) {
  const double z = Lattice::depth(layer), width = expected_width(mu, z);
  return std::max(2 * tan30 * z + 8 * width, 2 * expected_speed(mu) * z + 4 * width);
}

// Other models hand nothing on faster than c0, and are no wider than positive legs or the one peak of the q-model.
double columns_needed(const SamplerSpec& sampler, int layer) {
  if (sampler.model.has_contacts()) return columns_needed(sampler.mu, layer);
  constexpr double widest = 0.3;
  const double z = rows_of(sampler.model).depth(layer);
  return 2 * tan30 * z + 8 * std::sqrt(widest * z + 1);
}

}  // namespace granuscope
