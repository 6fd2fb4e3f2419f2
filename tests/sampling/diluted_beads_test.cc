// Sources: what can be calculated by hand of piles of two layers, for which solvability is a matter of difference
// constraints and the flat measure one of rejection; the law polytope with lambda = 0, which is the flat measure
// without opened contacts; the audit; and plain elimination.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>

#include "kit/sampling_statistics.h"
#include "model/audit.h"
#include "model/equilibrium.h"
#include "sampling/diluted_beads.h"
#include "support/error.h"

namespace granuscope {
namespace {

using test::RunningMean;

std::vector<double> even_load(const Lattice& lattice) {
  return std::vector<double>(static_cast<std::size_t>(lattice.columns()), 1.0);
}

OpenedContacts none_opened(const Lattice& lattice) { return OpenedContacts(2 * lattice.beads()); }

/// 1/(2 sqrt 3): the horizontal force that a bead of layer 1 with one lower contact must get from two top beads, each
/// of which hands down V = 1/2 to either side.
constexpr double needed = tan30 / 2;

/// Whether a pile of two layers under a load of 1 has a solution. Top bead i pushes outwards with h_i in [t-/2, t+/2]
/// on either side, so that bead j of layer 1 gets H = h_j - h_(j+1), bounded where it has both lower contacts and fixed
/// where it has one. Such constraints hold together unless they add up to less than 0 around a ring of them.
bool solvable_by_differences(double mu, const Lattice& lattice, const OpenedContacts& opened) {
  const FrictionCone cone(mu);
  const auto columns = static_cast<std::size_t>(lattice.columns());
  const std::size_t origin = columns;
  // most[a][b]: the largest h_a - h_b.
  std::vector<std::vector<double>> most(columns + 1, std::vector<double>(columns + 1, 1e9));
  const auto bound = [&](std::size_t a, std::size_t b, double low, double high) {
    most[a][b] = std::min(most[a][b], high);
    most[b][a] = std::min(most[b][a], -low);
  };
  for (std::size_t j = 0; j < columns; ++j) {
    bound(j, origin, cone.t_minus() / 2, cone.t_plus() / 2);
    const std::size_t bead = lattice.index(1, static_cast<int>(j)), next = (j + 1) % columns;
    const bool no_right = opened[bead] != 0, no_left = opened[lattice.beads() + bead] != 0;
    if (no_right && no_left) return false;
    if (no_right || no_left) {
      // The other contact bears V = 1 and H = +-needed.
      if (!(cone.t_minus() <= needed && needed <= cone.t_plus())) return false;
      bound(j, next, no_left ? needed : -needed, no_left ? needed : -needed);
    } else {
      const Interval band = solvable_band(cone, 0.5, 0.5);
      bound(j, next, band.low, band.high);
    }
  }
  for (std::size_t k = 0; k <= columns; ++k) {
    for (std::size_t a = 0; a <= columns; ++a) {
      for (std::size_t b = 0; b <= columns; ++b) most[a][b] = std::min(most[a][b], most[a][k] + most[k][b]);
    }
  }
  constexpr double rounding = 1e-12;
  for (std::size_t a = 0; a <= columns; ++a) {
    if (most[a][a] < -rounding) return false;
  }
  return true;
}

/// Nullity of the balances over the closed contacts, by plain elimination with complete pivoting.
std::size_t nullity(const ContactBalances& balances, const OpenedContacts& opened) {
  std::vector<std::vector<double>> columns;
  for (std::size_t contact = 0; contact < balances.contacts(); ++contact) {
    if (opened[contact] != 0) continue;
    std::vector<double> low(balances.equations()), high(balances.equations());
    for (const BalanceTerm& term : balances.terms(contact)) {
      low[term.equation] = term.of_low;
      high[term.equation] = term.of_high;
    }
    columns.push_back(low);
    columns.push_back(high);
  }
  return columns.size() - [&columns] {
    std::size_t rank = 0;
    while (true) {
      std::size_t best = rank, at = 0;
      double largest = 1e-9;
      for (std::size_t c = rank; c < columns.size(); ++c) {
        for (std::size_t r = 0; r < columns[c].size(); ++r) {
          if (std::abs(columns[c][r]) > largest) largest = std::abs(columns[c][r]), best = c, at = r;
        }
      }
      if (!(largest > 1e-9)) return rank;
      std::swap(columns[rank], columns[best]);
      for (std::size_t c = rank + 1; c < columns.size(); ++c) {
        const double factor = columns[c][at] / columns[rank][at];
        for (std::size_t r = 0; r < columns[c].size(); ++r) columns[c][r] -= factor * columns[rank][r];
      }
      ++rank;
    }
  }();
}

Pile pile_of(const ContactBalances& balances, const ContactSlacks& slacks, const std::vector<double>& load) {
  Pile pile(balances.lattice());
  balances.store(slacks, pile);
  pile.load = load;
  return pile;
}

/// Forces of a pile with their squares.
std::vector<double> moments(const Pile& pile) {
  std::vector<double> all;
  for (const auto* forces : {&pile.V_R, &pile.V_L, &pile.H_R, &pile.H_L}) {
    for (const double force : *forces) {
      all.push_back(force);
      all.push_back(force * force);
    }
  }
  return all;
}

SamplerSpec diluted(double mu, double share) {
  SamplerSpec spec;
  spec.mu = mu;
  spec.seed = 5;
  spec.model.name = ModelName::diluted_beads;
  spec.model.diluted_beads.share = share;
  return spec;
}

/// Means over groups of eight samples, which have one walk.
std::vector<RunningMean> measure(const SamplerSpec& spec, const Lattice& lattice, std::uint64_t groups) {
  const auto sampler = make_sampler(spec, lattice);
  const std::vector<double> load = even_load(lattice);
  Pile pile(lattice);
  std::vector<RunningMean> means;
  for (std::uint64_t group = 0; group < groups; ++group) {
    std::vector<double> sums;
    for (std::uint64_t k = 0; k < 8; ++k) {
      REQUIRE_FALSE(sampler->draw(8 * group + k, load, pile));
      const std::vector<double> one = moments(pile);
      sums.resize(one.size());
      for (std::size_t j = 0; j < one.size(); ++j) sums[j] += one[j] / 8;
    }
    means.resize(sums.size());
    for (std::size_t j = 0; j < sums.size(); ++j) means[j].add(sums[j]);
  }
  return means;
}

void compare(const std::vector<RunningMean>& one, const std::vector<RunningMean>& other, double resolution) {
  std::size_t comparisons = 0;
  for (const RunningMean& mean : one) comparisons += mean.variance() > 1e-20 ? 1 : 0;
  CHECK(comparisons >= 8);
  for (std::size_t j = 0; j < one.size(); ++j) {
    const auto a = one[j].estimate(), b = other[j].estimate();
    CAPTURE(j, a.value, a.error, b.value, b.error);
    if (!(one[j].variance() > 1e-20)) {  // fixed by the load
      CHECK(a.value == Approx(b.value).margin(1e-9));
      continue;
    }
    CHECK(std::abs(test::sigmas(a, b)) < test::sigma_bound(comparisons));
    CHECK(std::hypot(a.error, b.error) < resolution);
  }
}

TEST_CASE("an undiluted pile is solvable at every friction, with the slack of the frictionless pile") {
  for (const double mu : {0.01, 0.1, 0.5, 1.0, 1.6}) {
    const Lattice lattice({6, 5});
    const LargestSlack found =
        find_largest_slack(ContactBalances(mu, lattice), none_opened(lattice), even_load(lattice));
    CHECK(found.solvability == Solvability::inside);
    CHECK(found.slack == Approx(tan30).epsilon(1e-9));
  }
  CHECK_THROWS_AS(ContactBalances(0, Lattice({6, 5})), InputError);
}

TEST_CASE("a solution of the linear programme passes the audit, with the slack that it says") {
  int inside = 0, nowhere = 0;
  for (const double mu : {0.2, 0.6, 1.2}) {
    const Lattice lattice({7, 6});
    const ContactBalances balances(mu, lattice);
    for (std::uint64_t pile = 0; pile < 30; ++pile) {
      const OpenedContacts opened = open_at_random(lattice, 0.06, RandomKey(1, pile));
      std::vector<double> load = even_load(lattice);
      load[pile % 7] = 1.2;
      const LargestSlack found = find_largest_slack(balances, opened, load);
      nowhere += found.solvability == Solvability::nowhere ? 1 : 0;
      if (found.solvability != Solvability::inside) continue;
      ++inside;
      const Pile solved = pile_of(balances, found.slacks, load);
      CHECK(audit(solved).max_balance_residual < 1e-12);
      CHECK(audit(solved).max_cone_violation == 0);
      double least = 1;
      for (std::size_t k = 0; k < lattice.beads(); ++k) {
        const double N_R = (solved.H_R[k] + sqrt3 * solved.V_R[k]) / 2,
                     T_R = (sqrt3 * solved.H_R[k] - solved.V_R[k]) / 2;
        const double N_L = (sqrt3 * solved.V_L[k] - solved.H_L[k]) / 2,
                     T_L = (sqrt3 * solved.H_L[k] + solved.V_L[k]) / 2;
        if (opened[k] == 0) least = std::min(least, N_R - std::abs(T_R) / mu);
        if (opened[k] != 0) CHECK(std::abs(N_R) + std::abs(T_R) == 0);
        if (opened[lattice.beads() + k] == 0) least = std::min(least, N_L - std::abs(T_L) / mu);
        if (opened[lattice.beads() + k] != 0) CHECK(std::abs(N_L) + std::abs(T_L) == 0);
      }
      CHECK(least == Approx(found.slack).epsilon(1e-9));
    }
  }
  CHECK(inside > 20);
  CHECK(nowhere > 10);
}

TEST_CASE("piles without solution: by hand") {
  const Lattice lattice({4, 2});
  OpenedContacts opened = none_opened(lattice);
  opened[lattice.index(0, 1)] = 1;  // a top bead under a load through its centre needs both
  CHECK(find_largest_slack(ContactBalances(0.9, lattice), opened, even_load(lattice)).solvability ==
        Solvability::nowhere);
  // A bead of layer 1 without its lower-left contact hands down V = 1 and H = 1/(2 sqrt 3), which is inside the cone
  // if t- <= 1/(2 sqrt 3): mu >= (tan 30 - needed)/(1 + needed tan 30) = 0.247436.
  opened = none_opened(lattice);
  opened[lattice.beads() + lattice.index(1, 2)] = 1;
  const double limit = (tan30 - needed) / (1 + needed * tan30);
  CHECK(limit == Approx(0.247436).epsilon(1e-5));
  const auto slack = [&](double mu) {
    return find_largest_slack(ContactBalances(mu, lattice), opened, even_load(lattice)).slack;
  };
  CHECK(slack(limit - 1e-4) < -slack_tolerance);
  CHECK(std::abs(slack(limit)) < slack_tolerance);
  CHECK(slack(limit + 1e-4) > slack_tolerance);
}

TEST_CASE("all ways to open the lower contacts of two layers: solvable as difference constraints say") {
  const Lattice lattice({4, 2});
  for (const double mu : {0.1, 0.24, 0.3, 0.45, 0.7, 1.2}) {
    const ContactBalances balances(mu, lattice);
    int solvable = 0;
    for (unsigned set = 0; set < 256; ++set) {
      OpenedContacts opened = none_opened(lattice);
      for (std::size_t j = 0; j < 8; ++j) {
        const std::size_t bead = lattice.index(1, static_cast<int>(j % 4));
        opened[j < 4 ? bead : lattice.beads() + bead] = set >> j & 1U;
      }
      const bool expected = solvable_by_differences(mu, lattice, opened);
      CAPTURE(mu, set);
      CHECK((find_largest_slack(balances, opened, even_load(lattice)).solvability != Solvability::nowhere) == expected);
      solvable += expected ? 1 : 0;
    }
    CHECK(solvable >= 1);
    CHECK((mu < 0.247) == (solvable == 1));  // the undiluted pile alone
  }
}

TEST_CASE("contacts opened one after the other are those that a programme from scratch allows") {
  const Lattice lattice({6, 5});
  const ContactBalances balances(0.4, lattice);
  constexpr double least = 0.05;
  std::vector<double> load = even_load(lattice), opposite = load;
  load[2] = opposite[4] = 1.2;
  opposite[2] = load[4] = 0.8;
  std::size_t refused = 0;
  for (std::uint64_t pile = 0; pile < 6; ++pile) {
    const RandomKey key(9, pile);
    const OpenedStepwise found = open_while_solvable(balances, {load, opposite}, 0.24, least, key);
    OpenedContacts opened = none_opened(lattice);
    std::size_t count = 0;
    for (const RandomContact& one : contacts_in_random_order(lattice, key)) {
      if (count == 12) break;  // 0.24 of 48, rounded
      opened[one.contact] = 1;
      const bool fine = find_largest_slack(balances, opened, load).slack >= least &&
                        find_largest_slack(balances, opened, opposite).slack >= least;
      if (!fine) opened[one.contact] = 0;
      fine ? ++count : ++refused;
    }
    CHECK(found.opened == opened);
    CHECK(found.count == count);
    CHECK(found.complete == (count == 12));
  }
  CHECK(refused > 20);
}

TEST_CASE("null directions keep every balance and span all that do") {
  for (const double share : {0.0, 0.08, 0.16}) {
    const Lattice lattice({7, 6});
    const ContactBalances balances(0.5, lattice);
    const OpenedContacts opened = open_at_random(lattice, share, RandomKey(2, 0));
    const auto directions = find_null_directions(balances, opened);
    const std::size_t expected = nullity(balances, opened);
    if (share == 0) CHECK(expected == lattice.beads());
    std::vector<std::vector<double>> rows;
    for (const NullDirection& direction : directions) {
      std::vector<double> residual(balances.equations()), row(2 * balances.contacts());
      for (const SlackChange& change : direction) {
        CHECK(opened[change.contact] == 0);
        row[2 * change.contact] = change.low;
        row[2 * change.contact + 1] = change.high;
        for (const BalanceTerm& term : balances.terms(change.contact)) {
          residual[term.equation] += term.of_low * change.low + term.of_high * change.high;
        }
      }
      for (const double one : residual) CHECK(std::abs(one) < 1e-10);
      rows.push_back(row);
    }
    std::size_t rank = 0;  // by elimination, row after row
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto largest = std::max_element(rows[k].begin(), rows[k].end(),
                                            [](double a, double b) { return std::abs(a) < std::abs(b); });
      if (!(std::abs(*largest) > 1e-8)) continue;
      ++rank;
      const auto at = static_cast<std::size_t>(largest - rows[k].begin());
      for (std::size_t other = k + 1; other < rows.size(); ++other) {
        const double factor = rows[other][at] / rows[k][at];
        for (std::size_t c = 0; c < rows[k].size(); ++c) rows[other][c] -= factor * rows[k][c];
      }
    }
    CHECK(rank == expected);
  }
}

TEST_CASE("without opened contacts the walk draws the flat measure of the law polytope") {
  for (const auto& [columns, layers, mu] : {std::tuple{4, 3, 0.3}, std::tuple{5, 4, 0.7}}) {
    const Lattice lattice({columns, layers});
    SamplerSpec flat;
    flat.law = Law::polytope;
    flat.lambda = 0;
    flat.mu = mu;
    flat.seed = 7;
    compare(measure(diluted(mu, 0), lattice, 600), measure(flat, lattice, 600), 0.02);
  }
}

TEST_CASE("with an opened contact the walk draws the flat measure, as rejection has it", "[unsanitized]") {
  // Two layers, four columns: bead 2 of layer 1 rests on its lower-right contact alone, so that h_2 - h_3 is fixed.
  constexpr double mu = 0.6;
  const Lattice lattice({4, 2});
  const ContactBalances balances(mu, lattice);
  const FrictionCone cone(mu);
  OpenedContacts opened = none_opened(lattice);
  opened[lattice.beads() + lattice.index(1, 2)] = 1;
  const LargestSlack start = find_largest_slack(balances, opened, even_load(lattice));
  REQUIRE(start.solvability == Solvability::inside);
  const auto directions = find_null_directions(balances, opened);

  std::vector<RunningMean> walked, rejected;
  for (std::uint64_t walk = 0; walk < 1500; ++walk) {
    FlatWalk one(start.slacks, directions);
    const RandomKey key(3, walk);
    for (std::uint32_t sweep = 0; sweep < 60; ++sweep) {
      one.sweep([&](std::size_t d) { return key.chain_move(0, static_cast<int>(d), sweep).first; });
    }
    const std::vector<double> numbers = moments(pile_of(balances, one.slacks(), even_load(lattice)));
    walked.resize(numbers.size());
    for (std::size_t j = 0; j < numbers.size(); ++j) walked[j].add(numbers[j]);
  }

  std::mt19937_64 engine(17);
  const auto uniform = [&engine](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  while (rejected.empty() || rejected.front().count() < 4000) {
    std::array<double, 4> h{};
    for (double& one : h) one = uniform(cone.t_minus() / 2, cone.t_plus() / 2);
    h[2] = h[3] + needed;
    bool inside = h[2] <= cone.t_plus() / 2;
    Pile pile(lattice);
    for (std::size_t i = 0; i < 4; ++i) {
      pile.V_R[i] = pile.V_L[i] = 0.5;
      pile.H_R[i] = h[i];
      pile.H_L[i] = -h[i];
      const std::size_t bead = 4 + i;
      const double H = h[i] - h[(i + 1) % 4];
      pile.V_R[bead] = 0.5 + sqrt3 * H;
      pile.V_L[bead] = i == 2 ? 0 : 0.5 - sqrt3 * H;
      // Every split lies in here; of bead 2 it is fixed.
      pile.H_R[bead] = i == 2 ? H : uniform(-cone.t_plus(), cone.t_plus());
      pile.H_L[bead] = H - pile.H_R[bead];
      const auto in_cone = [&](double V, double outward) {
        return outward >= cone.t_minus() * V && outward <= cone.t_plus() * V;
      };
      inside =
          inside && in_cone(pile.V_R[bead], pile.H_R[bead]) && (i == 2 || in_cone(pile.V_L[bead], -pile.H_L[bead]));
    }
    if (!inside) continue;
    const std::vector<double> numbers = moments(pile);
    rejected.resize(numbers.size());
    for (std::size_t j = 0; j < numbers.size(); ++j) rejected[j].add(numbers[j]);
  }
  compare(walked, rejected, 0.02);
}

TEST_CASE("a diluted pile depends on its key and load alone, and its opposite has the same opened contacts") {
  const Lattice lattice({8, 6});
  const SamplerSpec spec = diluted(0.5, 0.1);
  std::vector<double> load = even_load(lattice), opposite = load;
  for (std::size_t i = 0; i < load.size(); ++i) {
    load[i] += i % 3 == 0 ? 0.1 : -0.1;
    opposite[i] = 2 - 2.0 * 0.2 / 8 - load[i];  // 3 up, 5 down: the mean is 1 - 0.2/8
  }
  const auto in_order = make_sampler(spec, lattice), alone = make_sampler(spec, lattice);
  Pile first(lattice), again(lattice), other(lattice);
  for (std::uint64_t sample = 0; sample < 12; ++sample) {
    REQUIRE_FALSE(in_order->draw(sample, load, first));
    CHECK(audit(first).max_balance_residual < 1e-12);
    CHECK(audit(first).max_cone_violation < 1e-12);
    CHECK(first.law == "diluted-beads");
    if (sample != 5 && sample != 9) continue;
    REQUIRE_FALSE(alone->draw(sample, opposite, other));
    REQUIRE_FALSE(alone->draw(sample, load, again));
    CHECK(again.H_R == first.H_R);
    CHECK(again.V_L == first.V_L);
    std::size_t opened = 0;
    for (std::size_t k = 0; k < lattice.beads(); ++k) {
      CHECK((first.V_R[k] == 0) == (other.V_R[k] == 0));
      CHECK((first.V_L[k] == 0) == (other.V_L[k] == 0));
      opened += (first.V_R[k] == 0 ? 1U : 0U) + (first.V_L[k] == 0 ? 1U : 0U);
    }
    CHECK(opened == 8);  // a tenth of the 80 below the top layer
  }
}

TEST_CASE("what cannot be diluted is refused, and a share that cannot be reached fails by name") {
  const Lattice lattice({8, 6});
  CHECK_THROWS_AS(make_sampler(diluted(0.3, 0.25), lattice), InputError);
  CHECK_THROWS_AS(make_sampler(diluted(0, 0.05), lattice), InputError);
  CHECK_THROWS_AS(make_sampler(diluted(0.3, 0.05), Lattice({64, 64})), InputError);
  Pile pile(lattice);
  const auto failure = make_sampler(diluted(0.1, 0.24), lattice)->draw(0, even_load(lattice), pile);
  REQUIRE(failure);
  CHECK(failure->layer == 0);
}

}  // namespace
}  // namespace granuscope
