// What a bead draws, as an option of granusolve: against densities in closed form and against blind redrawing.
#include "sampling/sampler_spec.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "kit/sampling_statistics.h"
#include "kit/sanitized.h"
#include "model/audit.h"
#include "model/lattice.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

const double root3 = std::sqrt(3.0);

/// The angle from the vertical, or T/N, of a contact that carries V and H; and back.
double variable(DrawnVariable drawn, double V, double H) {
  if (drawn == DrawnVariable::force) return H;
  return drawn == DrawnVariable::angle ? std::atan2(H, V) : (root3 * H - V) / (H + root3 * V);
}
double force(DrawnVariable drawn, double V, double variable) {
  if (drawn == DrawnVariable::force) return variable;
  return drawn == DrawnVariable::angle ? V * std::tan(variable) : V * (1 + root3 * variable) / (root3 - variable);
}

struct OneBead {
  double V_R, V_L, H, low, high;
};

/// A bead under V_UL, V_UR, H: by angles of friction alone, not by the program's cone. No solution: low > high.
OneBead bead_under(double mu, double V_UL, double V_UR, double H) {
  const double flat = std::tan(std::numbers::pi / 6 - std::atan(mu)),
               steep = std::tan(std::numbers::pi / 6 + std::atan(mu));
  const double V_R = V_UR + root3 * H, V_L = V_UL - root3 * H;
  if (V_R < 0 || V_L < 0) return {V_R, V_L, H, 1, 0};
  return {V_R, V_L, H, std::max(flat * V_R, H + flat * V_L), std::min(steep * V_R, H + steep * V_L)};
}

double draw(DrawnVariable drawn, const OneBead& bead, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  const bool right = random() % 2 == 0;
  const double V = right ? bead.V_R : bead.V_L, shift = right ? 0 : bead.H;
  const double low = variable(drawn, V, bead.low - shift), high = variable(drawn, V, bead.high - shift);
  return shift + force(drawn, V, low + uniform(random) * (high - low));
}

/// Share of the splits up to H_R.
double distribution(DrawnVariable drawn, const OneBead& bead, double H_R) {
  const auto at = [&](double V, double shift) {
    const double low = variable(drawn, V, bead.low - shift), high = variable(drawn, V, bead.high - shift);
    return (variable(drawn, V, H_R - shift) - low) / (high - low);
  };
  return (at(bead.V_R, 0) + at(bead.V_L, bead.H)) / 2;
}

/// Splits of both layers of four columns: the beads of the lower one in their order, and the parents of one that has no
/// solution thrown again, each by its own law, until it and those before it have one.
std::array<double, 8> blind_pile(DrawnVariable drawn, double mu, const std::vector<double>& load,
                                 std::mt19937_64& random) {
  std::array<OneBead, 4> above;
  std::array<double, 8> split{};
  for (std::size_t i = 0; i < 4; ++i) {
    above[i] = bead_under(mu, load[i] / 2, load[i] / 2, 0);
    split[i] = draw(drawn, above[i], random);
  }
  // Bead i of layer 1 hangs from beads i and i + 1 of layer 0.
  const auto bead = [&](std::size_t i) {
    const std::size_t B = (i + 1) % 4;
    return bead_under(mu, above[i].V_R, above[B].V_L, split[i] + above[B].H - split[B]);
  };
  const auto solvable = [&](std::size_t i) { return bead(i).low <= bead(i).high; };
  const std::size_t first = random() % 4, step = random() % 2 == 0 ? 1 : 3;
  std::array<bool, 4> solved{};
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t i = (first + step * k) % 4;
    solved[i] = true;
    while (!solvable(i) || (solved[(i + 1) % 4] && !solvable((i + 1) % 4)) ||
           (solved[(i + 3) % 4] && !solvable((i + 3) % 4))) {
      split[i] = draw(drawn, above[i], random);
      split[(i + 1) % 4] = draw(drawn, above[(i + 1) % 4], random);
    }
  }
  for (std::size_t i = 0; i < 4; ++i) split[4 + i] = draw(drawn, bead(i), random);
  return split;
}

void add_moments_of_two(const double* H_R, std::vector<test::RunningMean>& measured) {
  for (std::size_t i = 0; i < 8; ++i) {
    measured[i].add(H_R[i]);
    measured[8 + i].add(H_R[i] * H_R[i]);
    measured[16 + i].add(H_R[i] * H_R[i / 4 * 4 + (i + 1) % 4]);
  }
}

/// Most standard errors by which the moments of piles of the sampler differ from those of blind piles.
double farthest(DrawnVariable of_sampler, DrawnVariable of_blind, double mu, const std::vector<double>& load,
                int piles) {
  SamplerSpec spec;
  spec.mu = mu;
  spec.seed = 12;
  spec.drawn = of_sampler;
  const Lattice lattice({.columns = 4, .layers = 2});
  const auto sampler = make_sampler(spec, lattice);
  std::mt19937_64 random(7);
  std::vector<test::RunningMean> drawn(24), blind(24);
  Pile pile(lattice);
  for (int k = 0; k < piles; ++k) {
    if (sampler->draw(8 * static_cast<std::uint64_t>(k), load, pile)) throw std::runtime_error("stuck");
    add_moments_of_two(pile.H_R.data(), drawn);
    add_moments_of_two(blind_pile(of_blind, mu, load, random).data(), blind);
  }
  const SamplerCounts& counts = sampler->counts();
  CAPTURE(mu, name_of(of_sampler), counts.pairs);
  CHECK(counts.pairs > 1000);
  CHECK(counts.arcs + counts.rings + counts.backtracks == 0);
  double most = 0;
  for (std::size_t k = 0; k < drawn.size(); ++k) {
    const auto one = drawn[k].estimate(), other = blind[k].estimate();
    most = std::max(most, std::abs(one.value - other.value) / std::hypot(one.error, other.error));
  }
  return most;
}

}  // namespace

TEST_CASE("An arctangent and a tangent without libm are those of libm, to rounding") {
  for (double angle = -1.56; angle < 1.56; angle += 0.013) {
    const double tangent = std::tan(angle);
    CHECK(portable_tangent(angle) == Approx(tangent).epsilon(4e-14).margin(1e-15));
    CHECK(portable_arctangent(tangent) == Approx(angle).epsilon(1e-15).margin(1e-15));
  }
}

TEST_CASE("A bead draws the angle or T/N of one of its contacts uniformly, and is kept by its density",
          "[unsanitized]") {
  const int beads = 200'000;
  for (const double mu : {0.1, 0.5, 1.7}) {
    const OneBead bead = bead_under(mu, 0.6, 0.4, 0.1);
    const Interval interval{bead.low, bead.high};
    for (const DrawnVariable drawn : {DrawnVariable::force, DrawnVariable::angle, DrawnVariable::ratio}) {
      std::vector<double> splits;
      for (int k = 0; k < beads; ++k)
        splits.push_back(split_at(drawn, {bead.V_R, bead.V_L}, bead.H, interval, (k + 0.5) / beads));
      std::ranges::sort(splits);
      double most = 0, area = 0, kept = 0;
      for (int k = 0; k < beads; ++k) {
        const double share = distribution(drawn, bead, splits[static_cast<std::size_t>(k)]);
        most = std::max(most, std::abs(share - (k + 0.5) / beads));
      }
      CAPTURE(mu, name_of(drawn));
      CHECK(most < 2.0 / beads);  // the numbers are evenly spaced
      // Its density over the bound integrates to the share of the distribution function, piece by piece.
      const int pieces = 1000;
      const double width = (bead.high - bead.low) / pieces;
      std::vector<double> here;
      for (int k = 0; k < pieces; ++k) {
        here.push_back(kept_share(drawn, {bead.V_R, bead.V_L}, bead.H, interval, bead.low + (k + 0.5) * width));
        area += here.back();
      }
      for (int k = 0; k < pieces; k += 100) {
        kept = here[static_cast<std::size_t>(k)] / area;
        CHECK(kept == Approx(distribution(drawn, bead, bead.low + (k + 1) * width) -
                             distribution(drawn, bead, bead.low + k * width))
                          .epsilon(0.01));
      }
      CHECK(std::ranges::max(here) <= 1);
    }
  }
}

TEST_CASE("Piles of two layers that draw another variable follow blind redrawing, and not the default law",
          "[unsanitized]") {
  const int piles = test::sanitized ? 20'000 : 200'000;
  const double bound = test::sigma_bound(4 * 24);
  for (const double mu : {0.3, 0.6}) {
    const std::vector<double> load{0.6, 1.4, 0.8, 1.2};
    for (const DrawnVariable drawn : {DrawnVariable::force, DrawnVariable::angle, DrawnVariable::ratio}) {
      CAPTURE(mu, name_of(drawn));
      CHECK(farthest(drawn, drawn, mu, load, piles) < bound);
      if (drawn != DrawnVariable::force) CHECK(farthest(DrawnVariable::force, drawn, mu, load, piles) > 2 * bound);
    }
  }
}

TEST_CASE("Piles that draw another variable pass the audit, and are the same in any company") {
  const Lattice lattice({.columns = 40, .layers = 60});
  for (const double mu : {0.3, 1.7}) {
    for (const DrawnVariable drawn : {DrawnVariable::angle, DrawnVariable::ratio}) {
      SamplerSpec spec;
      spec.mu = mu;
      spec.drawn = drawn;
      const auto sampler = make_sampler(spec, lattice);
      const std::vector<double> load(40, 1.0);
      Pile alone(lattice);
      REQUIRE(!sampler->draw(3, load, alone));
      const AuditResult result = audit(alone);
      CHECK(result.max_balance_residual < 1e-11);
      CHECK(result.max_cone_violation < 1e-11);
      const std::vector<std::uint64_t> samples{0, 1, 2, 3};
      const std::vector<std::span<const double>> loads(4, load);
      std::vector<std::optional<SamplingFailure>> failures(4);
      const auto groups = sampler->draw_groups(samples, loads, failures);
      REQUIRE(groups.size() == 4);
      const std::size_t row = groups[3].row(59);
      for (std::size_t i = 0; i < 40; ++i) {
        CHECK(groups[3].weight(row + i * groups[3].stride) ==
              alone.V_R[lattice.index(59, static_cast<int>(i))] + alone.V_L[lattice.index(59, static_cast<int>(i))]);
      }
    }
  }
}

TEST_CASE("Rightwards from a random start is a law of its own, whose piles complete") {
  const Lattice lattice({.columns = 60, .layers = 60});
  const std::vector<double> load(60, 1.0);
  Pile random(lattice), rightwards(lattice), fixed(lattice);
  SamplerSpec spec;
  spec.mu = 0.3;
  REQUIRE(!make_sampler(spec, lattice)->draw(0, load, random));
  spec.order = LayerOrder::rightwards;
  REQUIRE(!make_sampler(spec, lattice)->draw(0, load, rightwards));
  spec.order = LayerOrder::fixed;
  REQUIRE(!make_sampler(spec, lattice)->draw(0, load, fixed));
  CHECK(rightwards.H_R != random.H_R);
  CHECK(rightwards.H_R != fixed.H_R);
}

}  // namespace granuscope
