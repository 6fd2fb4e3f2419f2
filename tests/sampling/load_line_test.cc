// Loads that lean or act beside the centres of the top beads, under every law.
#include <catch2/catch.hpp>
#include <cmath>

#include "model/audit.h"
#include "sampling/sampler.h"
#include "support/error.h"

using namespace granuscope;

namespace {

struct Sums {
  double weight = 0, horizontal = 0, torque = 0;  ///< T_R + T_L
};

Sums sums_of(const Pile& pile, int layer) {
  Sums sums;
  for (int i = 0; i < pile.lattice.columns(); ++i) {
    const std::size_t at = pile.lattice.index(layer, i);
    const double H = pile.H_R[at] + pile.H_L[at];
    sums.weight += pile.V_R[at] + pile.V_L[at];
    sums.horizontal += H;
    sums.torque += (std::sqrt(3) * H - pile.V_R[at] + pile.V_L[at]) / 2;
  }
  return sums;
}

SamplerSpec loaded(double mu, double angle, double offset, Law law = Law::granusolve) {
  SamplerSpec spec;
  spec.law = law;
  spec.mu = mu;
  spec.load_angle = angle;
  spec.load_offset = offset;
  return spec;
}

Pile drawn(const SamplerSpec& spec, LatticeSpec size) {
  CAPTURE(name_of(spec.law), spec.mu, spec.load_angle, spec.load_offset);
  Pile pile{Lattice(size)};
  const std::vector<double> load(static_cast<std::size_t>(size.columns), 1.0);
  REQUIRE_FALSE(make_sampler(spec, pile.lattice)->draw(3, load, pile));
  return pile;
}

double thrust(const Pile& pile) {
  double sum = 0;
  for (std::size_t at = 0; at < pile.lattice.beads(); ++at) sum += pile.H_R[at] - pile.H_L[at];
  return std::sqrt(3) * sum / static_cast<double>(pile.lattice.beads());
}

}  // namespace

TEST_CASE("Weight, horizontal force and alternating torque are handed down whole, under every law") {
  struct Case {
    Law law;
    LatticeSpec size;
    double mu;
  };
  for (const auto& [law, size, mu] : {Case{Law::granusolve, {48, 40}, 0.3}, Case{Law::granusolve, {48, 40}, 0.8},
                                      Case{Law::eloy_clement, {4, 4}, 0.5}, Case{Law::rejection, {5, 5}, 0.5},
                                      Case{Law::polytope, {6, 6}, 0.5}, Case{Law::granusolve, {16, 12}, 0}}) {
    for (const double angle : {0.0, 4.0, -4.0}) {
      for (const double offset : {0.0, 0.03, -0.03}) {
        if (mu == 0 && offset != 0) continue;
        const Pile pile = drawn(loaded(mu, angle, offset, law), size);
        CAPTURE(name_of(law), mu, angle, offset);
        const AuditResult result = audit(pile);
        CHECK(result.max_balance_residual < 1e-12);
        CHECK(result.max_cone_violation < 1e-12);
        CHECK_NOTHROW(assert_identities(pile));
        const double slope = std::tan(angle * std::acos(-1) / 180);
        for (int layer = 0; layer < size.layers; ++layer) {
          const Sums sums = sums_of(pile, layer);
          CHECK(sums.weight == Approx(size.columns));
          CHECK(sums.horizontal == Approx(slope * size.columns).margin(1e-10));
          // The load's own contacts turn the other way.
          const double sign = layer % 2 == 0 ? -1 : 1;
          CHECK(sums.torque == Approx(sign * offset * size.columns).margin(1e-10));
        }
      }
    }
  }
}

TEST_CASE("Piles drawn side by side bear a leaning load as those drawn alone, bit by bit") {
  const SamplerSpec spec = loaded(0.4, 6, -0.07);
  const Lattice lattice({40, 64});
  const auto together = make_sampler(spec, lattice);
  const std::vector<double> load(40, 1.0);
  const std::vector<std::uint64_t> samples{0, 1, 2, 3, 4, 5, 6, 7};
  const std::vector<std::span<const double>> loads(samples.size(), load);
  std::vector<std::optional<SamplingFailure>> failures(samples.size());
  const auto alone = make_sampler(spec, lattice);
  Pile one(lattice);
  for (const PileGroup& group : together->draw_groups(samples, loads, failures)) {
    for (std::size_t k = 0; k < group.piles; ++k) {
      REQUIRE_FALSE(alone->draw(group.first_sample + k, load, one));
      const Pile other = pile_of(group, k);
      CHECK(other.V_R == one.V_R);
      CHECK(other.V_L == one.V_L);
      CHECK(other.H_R == one.H_R);
      CHECK(other.H_L == one.H_L);
      CHECK(other.load_line == one.load_line);
      CHECK(audit(other).max_balance_residual < 1e-12);
    }
  }
}

TEST_CASE("Torque lowers the thrust, a horizontal force raises it, whichever way they point") {
  const LatticeSpec size{256, 200};
  const auto at = [&](double angle, double offset) { return thrust(drawn(loaded(0.3, angle, offset), size)); };
  const double upright = at(0, 0);
  for (const double side : {1.0, -1.0}) {
    CHECK(at(10 * side, 0) > upright + 0.005);
    CHECK(at(0, 0.12 * side) < upright - 0.03);
  }
}

TEST_CASE("A load that friction cannot bear is refused") {
  const Lattice lattice({8, 8});
  const auto refused = [&](const SamplerSpec& spec) { CHECK_THROWS_AS(make_sampler(spec, lattice), InputError); };
  refused(loaded(0.3, 30, 0));
  refused(loaded(0.3, std::nan(""), 0));
  refused(loaded(0.3, 0, std::nan("")));
  refused(loaded(0, 0, 0.01));
  // Both contacts may bear 2/sqrt(3) mu of torque, but not with the vertical forces that go with it.
  refused(loaded(0.3, 0, 0.33));
  // A top bead would bear this one, on the side to which the load leans; the second layer has its torque turned.
  for (const double side : {1.0, -1.0}) refused(loaded(0.3, 29, 0.16 * side));
  CHECK_NOTHROW(make_sampler(loaded(0.3, -29.9, 0), lattice));
  CHECK(find_problem(loaded(0.3, 0, 0.33))->message.find("up to 0.3176 to either side") != std::string::npos);
}

TEST_CASE("Slope and torque together are accepted up to where a mean bead slides or is pulled, and can be drawn") {
  for (const double mu : {0.1, 0.3, 0.8}) {
    const double pi = std::acos(-1), t_plus = std::tan(pi / 6 + std::atan(mu)),
                 t_minus = std::tan(pi / 6 - std::atan(mu));
    for (const double angle : {0.0, 8.0, -20.0, 29.0}) {
      const double slope = std::abs(std::tan(angle * pi / 180));
      // Of the mean bead, V_R + V_L = 1 and V_R - V_L = sqrt(3) slope +- 2 offset: neither force pulls, and both fit
      // into their cones with H_R + H_L = slope.
      const double largest =
          std::min(1 - std::sqrt(3) * slope,
                   ((t_plus - t_minus) - slope * (std::sqrt(3) * (t_plus + t_minus) - 2)) / (t_plus + t_minus)) /
          2;
      for (const double side : {1.0, -1.0}) {
        CAPTURE(mu, angle, side, largest);
        CHECK(find_problem(loaded(mu, angle, 1.00001 * side * largest)));
        CHECK_FALSE(find_problem(loaded(mu, angle, 0.99999 * side * largest)));
        for (const Law law : {Law::granusolve, Law::polytope}) {
          const AuditResult result = audit(drawn(loaded(mu, angle, 0.98 * side * largest, law), {4, 4}));
          CHECK(result.max_balance_residual < 1e-12);
          CHECK(result.max_cone_violation < 1e-12);
        }
      }
    }
  }
}
