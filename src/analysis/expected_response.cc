#include "analysis/expected_response.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

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

namespace {

/// The speed of deep peaks, that which follows from the thrust ratio (`granuscope sample --statistics` of 500 x 700
/// beads; errors below 0.001), by mu.
double deep_speed(double mu) {
  constexpr std::pair<double, double> known[] = {{0, tan30},     {0.1, 0.5748}, {0.2, 0.5674},
                                                 {0.3, 0.5559},  {0.4, 0.5418}, {0.5, 0.5272},
                                                 {0.65, 0.5193}, {0.8, 0.5302}, {1, 0.5531}};
  const auto above = std::lower_bound(std::next(std::begin(known)), std::prev(std::end(known)), std::pair(mu, 0.0));
  const auto below = std::prev(above);
  return std::lerp(below->second, above->second, (mu - below->first) / (above->first - below->first));
}

/// Deep down W^2 grows faster than z, by a tenth to a fifth in the exponent.
double deep_width(double mu, double z) {
  constexpr double usual = 100, faster = 0.2;
  return expected_width(mu, z) * std::pow(std::max(1.0, z / usual), faster / 2);
}

/// Whether the two peaks are apart in this layer of a ring.
bool are_apart(double mu, int layer, int ring) {
  constexpr double apart = 6, around = 12;  // widths: from one peak to the other, and the least of a ring
  constexpr double largest_mu = 1;          // of those whose speed is known well enough
  if (ring >= columns_needed(mu, layer)) return true;
  const double z = Lattice::depth(layer);
  const double width = deep_width(mu, z);
  return mu <= largest_mu && ring >= around * width &&
         2 * std::abs(std::remainder(deep_speed(mu) * z, ring / 2.0)) >= apart * width;
}

/// The fewest columns, from `columns` on, of a ring that suits each of these.
template <class Suits>
int fewest_columns_that_suit(const std::vector<double>& mu, const std::vector<int>& layers, int columns, Suits suits) {
  const auto suits_all = [&](int ring) {
    return std::all_of(mu.begin(), mu.end(), [&](double one) {
      return std::all_of(layers.begin(), layers.end(), [&](int layer) { return suits(one, layer, ring); });
    });
  };
  while (!suits_all(columns)) ++columns;
  return columns;
}

}  // namespace

int columns_apart(const std::vector<double>& mu, const std::vector<int>& layers, int columns) {
  return fewest_columns_that_suit(mu, layers, columns, are_apart);
}

int columns_of_waves(const std::vector<double>& mu, const std::vector<int>& layers, int columns) {
  return fewest_columns_that_suit(mu, layers, columns, [](double one, int layer, int ring) {
    return ring >= widths_of_ring * deep_width(one, Lattice::depth(layer));
  });
}

// Other models hand nothing on faster than c0, and are no wider than positive legs or the one peak of the q-model.
double columns_needed(const SamplerSpec& sampler, int layer) {
  if (sampler.model.has_contacts()) return columns_needed(sampler.mu, layer);
  constexpr double widest = 0.3;
  const double z = rows_of(sampler.model).depth(layer);
  return 2 * tan30 * z + 8 * std::sqrt(widest * z + 1);
}

}  // namespace granuscope
