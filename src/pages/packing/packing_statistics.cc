#include "packing/packing_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

namespace granuscope {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
/// Of the mean force: less is none.
constexpr double rounding = 1e-6;
constexpr double last_bin = 10;

/// The largest eigenvalue of [[xx, xy], [xy, yy]] minus the other, and the angle of its direction from x, degrees.
struct Anisotropy {
  double difference = 0, angle = 0;
};
Anisotropy anisotropy(double xx, double xy, double yy) {
  constexpr double degrees = 180 / 3.14159265358979323846;
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy) * degrees;
  return {std::hypot(xx - yy, 2 * xy), angle <= -90 + 1e-9 ? angle + 180 : angle};  // a direction is no vector
}

/// The least number that this share of all do not exceed; of one half the mean of both such.
double quantile(std::vector<double> numbers, double share) {
  if (numbers.empty()) return unknown;
  const double place = share * static_cast<double>(numbers.size());
  const auto at = numbers.begin() + static_cast<std::ptrdiff_t>(std::max(std::ceil(place - 1e-9) - 1, 0.0));
  std::nth_element(numbers.begin(), at, numbers.end());
  const bool between = place == std::floor(place) && at + 1 < numbers.end() && share == 0.5;
  return between ? (*at + *std::min_element(at + 1, numbers.end())) / 2 : *at;
}

/// Groups of particles that contacts stronger than the mean hold together.
std::vector<std::size_t> strong_clusters(const Packing& packing, double mean) {
  std::vector<std::size_t> parent(packing.particles.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t one) {
    while (parent[one] != one) one = parent[one] = parent[parent[one]];
    return one;
  };
  for (const PackingContact& one : packing.contacts) {
    if (one.N <= mean || one.first == PackingContact::wall || one.second == PackingContact::wall) continue;
    parent[root(one.first)] = root(one.second);
  }
  std::map<std::size_t, std::size_t> sizes;
  for (std::size_t k = 0; k < parent.size(); ++k) ++sizes[root(k)];
  std::vector<std::size_t> clusters;
  for (const auto& [at, size] : sizes) {
    if (size > 1) clusters.push_back(size);
  }
  return clusters;
}

}  // namespace

double mean_force(const Packing& packing) {
  double sum = 0;
  for (const PackingContact& one : packing.contacts) sum += one.N;
  return sum / static_cast<double>(packing.contacts.size());
}

std::vector<PackingNumber> packing_numbers(const Packing& packing, double mu) {
  const double mean = mean_force(packing), count = static_cast<double>(packing.contacts.size());
  double square = 0, cube = 0, largest = 0, sum_T = 0, most_share = 0, strong = 0;
  double walls = 0, placed = 0, tension = 0, sliding = 0, violating = 0;
  double fabric_xx = 0, fabric_xy = 0, fabric_yy = 0, stress_xx = 0, stress_xy = 0, stress_yx = 0, stress_yy = 0;
  for (const PackingContact& one : packing.contacts) {
    const double N = one.N / mean, T = std::abs(one.T);
    square += N * N / count;
    cube += N * N * N / count;
    largest = std::max(largest, N);
    sum_T += T;
    if (one.N > 0) most_share = std::max(most_share, T / one.N);
    if (one.N <= 0 && T > rounding * mean) most_share = unknown;  // nothing holds it; max() leaves it so
    strong += N > 1 ? 1 : 0;
    tension += one.N < 0 ? 1 : 0;
    sliding += T >= mu * one.N * (1 - sliding_share) && T > rounding * mean ? 1 : 0;
    violating += one.N < -rounding * mean || T > mu * one.N * (1 + rounding) + rounding * mean ? 1 : 0;
    walls += one.second == PackingContact::wall && one.first != PackingContact::wall ? 1 : 0;
    if (!one.placed) continue;
    ++placed;
    const double length = std::hypot(one.branch_x, one.branch_y), nx = one.branch_x / length,
                 ny = one.branch_y / length;
    fabric_xx += nx * nx;
    fabric_xy += nx * ny;
    fabric_yy += ny * ny;
    const double fx = one.N * nx - one.T * ny, fy = one.N * ny + one.T * nx;
    stress_xx += fx * one.branch_x;
    stress_xy += fx * one.branch_y;
    stress_yx += fy * one.branch_x;
    stress_yy += fy * one.branch_y;
  }
  const Anisotropy fabric = anisotropy(fabric_xx / placed, fabric_xy / placed, fabric_yy / placed);
  const Anisotropy stress = anisotropy(stress_xx, (stress_xy + stress_yx) / 2, stress_yy);

  const std::vector<OfParticle> sums = forces_on_particles(packing);
  double rattlers = 0, of_particles = 0;
  std::vector<double> residuals, torques;
  for (const OfParticle& sum : sums) {
    rattlers += sum.contacts < 2 ? 1 : 0;
    if (sum.contacts < 2) continue;
    of_particles += sum.contacts;
    if (const double rest = std::hypot(sum.x, sum.y) / sum.largest; std::isfinite(rest)) residuals.push_back(rest);
    if (std::isfinite(sum.torque)) torques.push_back(std::abs(sum.torque) / (sum.largest * packing.mean_diameter / 2));
  }
  const double bearing = static_cast<double>(sums.size()) - rattlers;
  const std::vector<std::size_t> clusters = strong_clusters(packing, mean);
  const bool friction = packing.tangential && std::isfinite(mu);

  std::vector<PackingNumber> numbers{
      {"particles", static_cast<double>(packing.particles.size()), "that the files name"},
      {"contacts", count, "of two particles, or of one with a wall"},
      {"wall_contacts", walls, ""},
      {"rattlers", rattlers, "particles with fewer than two contacts"},
      {"coordination", of_particles / bearing, "contacts of a particle that is no rattler, on average"},
      {"mean_diameter", packing.sized ? packing.mean_diameter : unknown,
       "lengths of the file; without radii the median branch"},
      {"N_mean", mean, "normal force, units of the file"},
      {"N2", square, "<N²>/<N>²"},
      {"N3", cube, "<N³>/<N>³"},
      {"N_max", largest, "largest normal force over the mean"},
      {"strong", strong / count, "share of contacts above the mean"},
      {"tension", tension, "contacts that pull"},
      {"T_over_N", packing.tangential ? sum_T / (mean * count) : unknown, "<|T|>/<N>"},
      {"T_over_N_max", packing.tangential ? most_share : unknown,
       "largest |T|/N: the least friction coefficient that holds it"},
      {"sliding", friction ? sliding / count : unknown, "share of contacts with |T| at μN or above, to a thousandth"},
      {"cone_violations", friction ? violating : unknown, "contacts with |T| > μN, or that pull"},
      {"fabric_anisotropy", fabric.difference, "difference of the eigenvalues of <n n>: 0 is isotropic"},
      {"fabric_angle", placed > 0 ? fabric.angle : unknown, "degrees from x, of most contacts"},
      {"stress_anisotropy", stress.difference / (stress_xx + stress_yy), "deviator over pressure: (σ₁ - σ₂)/(σ₁ + σ₂)"},
      {"stress_angle", stress_xx + stress_yy != 0 ? stress.angle : unknown, "degrees from x, of the major stress"},
      {"clusters", static_cast<double>(clusters.size()), "of particles that contacts above the mean hold together"},
      {"largest_cluster",
       clusters.empty() ? 0 : static_cast<double>(*std::max_element(clusters.begin(), clusters.end())), "particles"},
      {"balance_median", quantile(residuals, 0.5),
       "sum of contact forces on a particle over its largest one; no weight"},
      {"balance_90", quantile(residuals, 0.9), "nine of ten particles have no more"},
      {"balance_max", quantile(residuals, 1), "1 and more where a wall or what the file leaves out bears a part"},
      {"torque_median", quantile(torques, 0.5), "sum of torques over largest force times mean radius"},
      {"torque_max", quantile(torques, 1), ""},
  };
  return numbers;
}

std::vector<OfParticle> forces_on_particles(const Packing& packing) {
  std::vector<OfParticle> sums(packing.particles.size());
  for (const PackingContact& one : packing.contacts) {
    const double length = std::hypot(one.branch_x, one.branch_y), force = std::hypot(one.N, one.T);
    const double x = one.placed ? (one.N * one.branch_x - one.T * one.branch_y) / length : unknown;
    const double y = one.placed ? (one.N * one.branch_y + one.T * one.branch_x) / length : unknown;
    for (const bool of_first : {true, false}) {
      const std::size_t at = of_first ? one.first : one.second;
      if (at == PackingContact::wall) continue;
      OfParticle& sum = sums[at];
      const double radius = packing.particles[at].radius;
      ++sum.contacts;
      sum.x += of_first ? -x : x;
      sum.y += of_first ? -y : y;
      // The point of contact lies a radius along the branch, seen from either side; so both arms turn alike.
      sum.torque += radius > 0 && packing.tangential ? -radius * one.T : unknown;
      sum.largest = std::max(sum.largest, force);
    }
  }
  return sums;
}

std::vector<ForceBin> distribution(const Packing& packing, Distributed of, double mu) {
  constexpr double half_turn = 180;
  const double mean = mean_force(packing), cone = std::isfinite(mu) ? mu : 1;
  const bool of_forces = of != Distributed::direction;
  if ((of_forces && !(mean > 0)) || (of == Distributed::friction && (!packing.tangential || !(cone > 0)))) return {};
  const double width = of == Distributed::normal_force ? 0.1 : of == Distributed::friction ? 0.05 : 10;
  const double end = of_forces ? last_bin : half_turn;
  std::vector<double> counts(static_cast<std::size_t>(std::lround(end / width)));
  double all = 0;
  for (const PackingContact& one : packing.contacts) {
    if (of_forces ? one.N < 0 || (of == Distributed::friction && one.N == 0) : !one.placed) continue;
    ++all;
    double value = one.N / mean;
    if (of == Distributed::friction) value = std::abs(one.T) / (cone * one.N);
    if (!of_forces) {
      value = std::atan2(one.branch_y, one.branch_x) * half_turn / std::numbers::pi;
      value = std::fmod(value + half_turn, half_turn);
    }
    if (value < end) ++counts[std::min(static_cast<std::size_t>(value / width), counts.size() - 1)];
  }
  std::vector<ForceBin> bins;
  std::size_t used = counts.size();
  while (of_forces && used > 0 && counts[used - 1] == 0) --used;
  for (std::size_t k = 0; k < used; ++k) {
    const double from = static_cast<double>(k) * width, unit = all * width;
    bins.push_back({from, from + width, counts[k] / unit, std::sqrt(counts[k]) / unit});
  }
  return bins;
}

}  // namespace granuscope
