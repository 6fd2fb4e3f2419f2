// Random numbers, and what drawing takes and stops at.
#include <malloc.h>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "kit/sampling_statistics.h"
#include "kit/sanitized.h"
#include "sampling/layer_kernels.h"
#include "sampling/pile_group.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"
#include "support/error.h"
#include "support/progress.h"

namespace granuscope {
namespace {

using test::share_of_samples;

// Source of the expected numbers: the known-answer vectors of Philox4x32-10 in the Random123 distribution
// (tests/kat_vectors) and a second implementation written from the paper (Salmon et al., SC 2011).

using Words = std::array<std::uint32_t, 4>;

Words philox_from_the_paper(Words c, std::uint32_t k0, std::uint32_t k1) {
  for (int round = 0; round < 10; ++round, k0 += 0x9E3779B9, k1 += 0xBB67AE85) {
    const std::uint64_t p0 = std::uint64_t{0xD2511F53} * c[0], p1 = std::uint64_t{0xCD9E8D57} * c[2];
    c = {static_cast<std::uint32_t>(p1 >> 32) ^ c[1] ^ k0, static_cast<std::uint32_t>(p1),
         static_cast<std::uint32_t>(p0 >> 32) ^ c[3] ^ k1, static_cast<std::uint32_t>(p0)};
  }
  return c;
}

Words counter_of(std::uint32_t bead, std::uint32_t layer, std::uint32_t sample, std::uint32_t last,
                 std::uint64_t seed) {
  return philox_from_the_paper({bead, layer, sample, last}, static_cast<std::uint32_t>(seed),
                               static_cast<std::uint32_t>(seed >> 32));
}

/// The upper 53 of 64 bits as a fraction.
double fraction(std::uint32_t low, std::uint32_t high) {
  const std::uint64_t bits = (std::uint64_t{high} << 32 | low) >> 11;
  return std::ldexp(static_cast<double>(bits), -53);
}

/// First attempts of a layer, the same from both kernels.
std::vector<double> first_attempts(std::uint64_t seed, std::uint64_t sample, int layer, std::size_t columns) {
  std::vector<double> fast(columns + uniform_padding, -1), plain(columns + uniform_padding, -1);
  const auto word = static_cast<std::uint32_t>(sample);
  fill_first_uniforms(seed, word, layer, fast.data(), columns);
  fill_first_uniforms_plain(seed, word, layer, plain.data(), columns);
  fast.resize(columns);
  plain.resize(columns);
  REQUIRE(fast == plain);
  return fast;
}

TEST_CASE("the second implementation gives the known answers of Random123") {
  constexpr std::uint32_t ones = 0xffffffff;
  CHECK(philox_from_the_paper({0, 0, 0, 0}, 0, 0) == Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  CHECK(philox_from_the_paper({ones, ones, ones, ones}, ones, ones) ==
        Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  CHECK(philox_from_the_paper({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, 0xa4093822, 0x299f31d0) ==
        Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

TEST_CASE("the first numbers of seed 0, sample 0, layer 0 are the known answer to the zero counter") {
  const std::vector<double> uniforms = first_attempts(0, 0, 0, 2);
  CHECK(uniforms[0] == fraction(0x6627e8d5, 0xe169c58d));
  CHECK(uniforms[1] == fraction(0xbc57ac4c, 0x9b00dbd8));
}

TEST_CASE("every number is the documented function of seed, sample, layer, bead and attempt") {
  for (const std::uint64_t seed :
       {std::uint64_t{0}, std::uint64_t{1}, ~std::uint64_t{0}, std::uint64_t{0x123456789abcdef}}) {
    for (const std::uint64_t sample : {std::uint64_t{0}, std::uint64_t{7}, std::uint64_t{8}, max_samples - 1}) {
      const RandomKey key(seed, sample);
      const auto word = static_cast<std::uint32_t>(sample);
      for (const int layer : {0, 1, 199, 1'000'000}) {
        INFO("seed " << seed << ", sample " << sample << ", layer " << layer);
        const auto n = static_cast<std::uint32_t>(layer);
        // First attempts: stream 0, beads 2k and 2k+1 share the counter k; any number of columns, even or odd.
        for (const std::size_t columns : {std::size_t{1}, std::size_t{4}, std::size_t{5}, std::size_t{37}}) {
          const std::vector<double> uniforms = first_attempts(seed, sample, layer, columns);
          for (std::size_t i = 0; i < columns; ++i) {
            const Words w = counter_of(static_cast<std::uint32_t>(i / 2), n, word, 0, seed);
            REQUIRE(uniforms[i] == (i % 2 == 0 ? fraction(w[0], w[1]) : fraction(w[2], w[3])));
          }
        }
        // Later attempts: stream 1 in the low byte of the last word, the attempt above it.
        for (const std::uint32_t attempt : {1U, 2U, 0xffffffU}) {
          const Words w = counter_of(41, n, word, attempt << 8 | 1, seed);
          const UniformPair pair = key.attempt(layer, 41, attempt);
          REQUIRE(pair.first == fraction(w[0], w[1]));
          REQUIRE(pair.second == fraction(w[2], w[3]));
        }
        // Order of the layer: stream 2, shared by eight samples.
        const Words w = counter_of(0, n, word / 8, 2, seed);
        const RandomKey::Order order = key.layer_order(layer, 500);
        REQUIRE(order.first_bead == static_cast<int>(w[0] * std::uint64_t{500} >> 32));
        REQUIRE(order.direction == (w[1] % 2 == 1 ? 1 : -1));
      }
    }
  }
}

TEST_CASE("uniform numbers lie in [0, 1), are multiples of 2^-53 and are uniform in every digit looked at") {
  constexpr std::uint64_t seed = 99;
  CAPTURE(seed);
  CHECK(fraction(0xffffffff, 0xffffffff) < 1);
  constexpr int layers = 2000, columns = 500, bins = 100;
  std::vector<std::uint64_t> histogram(bins), pairs(bins);
  for (int n = 0; n < layers; ++n) {
    const std::vector<double> uniforms = first_attempts(seed, 3, n, columns);
    for (std::size_t i = 0; i < columns; ++i) {
      const double u = uniforms[i];
      REQUIRE((u >= 0 && u < 1 && std::ldexp(u, 53) == std::floor(std::ldexp(u, 53))));
      ++histogram[static_cast<std::size_t>(u * bins)];
      // Neighbouring beads together: ten bins each way.
      if (i > 0) ++pairs[static_cast<std::size_t>(uniforms[i - 1] * 10) * 10 + static_cast<std::size_t>(u * 10)];
    }
  }
  CHECK(std::abs(test::chi_squared_sigmas(test::chi_squared_of_equal(histogram), bins - 1)) < 5);
  // (Pairs that overlap in one bead are not independent, but the statistic of pairs that are uniform stays close.)
  CHECK(std::abs(test::chi_squared_sigmas(test::chi_squared_of_equal(pairs), bins - 1)) < 6);
}

TEST_CASE("eight samples share the order of their layers; over groups it is uniform over beads and directions") {
  constexpr std::uint64_t seed = 17;
  CAPTURE(seed);
  constexpr int columns = 12, layers = 200, groups = 500;
  std::vector<std::uint64_t> beads_and_directions(2 * columns), repeats(2);
  for (std::uint64_t group = 0; group < groups; ++group) {
    for (int n = 0; n < layers; ++n) {
      const auto first = RandomKey(seed, 8 * group).layer_order(n, columns);
      REQUIRE((first.first_bead >= 0 && first.first_bead < columns));
      REQUIRE((first.direction == 1 || first.direction == -1));
      for (std::uint64_t sample = 8 * group; sample < 8 * group + 8; ++sample) {
        const auto order = RandomKey(seed, sample).layer_order(n, columns);
        REQUIRE((order.first_bead == first.first_bead && order.direction == first.direction));
      }
      ++beads_and_directions[static_cast<std::size_t>(first.first_bead) * 2 + (first.direction > 0 ? 1 : 0)];
      // The next layer and the next group turn the other way in half of the cases.
      ++repeats[RandomKey(seed, 8 * group).layer_order(n + 1, columns).direction == first.direction];
    }
  }
  CHECK(std::abs(test::chi_squared_sigmas(test::chi_squared_of_equal(beads_and_directions), 2 * columns - 1)) < 5);
  const double share = static_cast<double>(repeats[1]) / (groups * layers);
  CHECK(std::abs(share - 0.5) < 5 * 0.5 / std::sqrt(double{groups} * layers));
}

TEST_CASE("every bead can be the first one, for any number of columns") {
  for (const int columns : {4, 5, 7, 1000}) {
    std::set<int> seen;
    for (int n = 0; n < 40 * columns; ++n) seen.insert(RandomKey(5, 0).layer_order(n, columns).first_bead);
    CHECK(seen.size() == static_cast<std::size_t>(columns));
  }
}

// Source: the law's description (granusolve.h). Every bead stands where one of its own numbers puts it, unless a repair
// of a bead below has changed its split: of the last layer nobody's is changed, and every bead there keeps its first
// number.

/// Beads of each layer that stand where none of their numbers puts them, of the first `attempts` after the first one.
std::vector<int> beads_off_their_numbers(const Pile& pile, std::uint32_t attempts) {
  constexpr double rounding = 1e-9;  // of a number recomputed from forces; two numbers are as close once in 1e9 times
  const auto columns = static_cast<std::size_t>(pile.lattice.columns());
  std::vector<double> numbers, first(columns + uniform_padding);
  read_split_uniforms(pile, numbers);
  const RandomKey key(pile.seed, pile.sample);
  std::vector<int> off;
  for (int n = 0; n < pile.lattice.layers(); ++n) {
    fill_first_uniforms(pile.seed, static_cast<std::uint32_t>(pile.sample), n, first.data(), columns);
    off.push_back(0);
    for (int i = 0; i < pile.lattice.columns(); ++i) {
      const double number = numbers[pile.lattice.index(n, i)];
      bool found = std::abs(first[static_cast<std::size_t>(i)] - number) < rounding;
      for (std::uint32_t k = 1; k <= attempts && !found; ++k) {
        found = std::abs(key.attempt(n, i, k).first - number) < rounding;
      }
      off.back() += found ? 0 : 1;
    }
  }
  return off;
}

TEST_CASE("in the last layer every bead keeps its first number, however it was solved") {
  for (const double mu : {0.1, 0.3, 0.8, 1.3}) {
    SamplerSpec spec;
    spec.mu = mu;
    spec.seed = 8;
    const Lattice lattice({.columns = 24, .layers = 12});
    const auto sampler = make_sampler(spec, lattice);
    Pile pile(lattice);
    for (std::uint64_t sample = 0; sample < 20; ++sample) {
      REQUIRE_FALSE(sampler->draw(sample, std::vector<double>(24, 1.0), pile));
      CAPTURE(mu, sample);
      CHECK(beads_off_their_numbers(pile, 0).back() == 0);
    }
    CHECK(sampler->counts().pairs + sampler->counts().backtracks > 10);
  }
}

// A pair changes two splits of the layer above. Of P pairs at least half as many as the top layer has changed splits
// were repaired in the middle layer; only the others have changed anything there. A bead of the middle layer that a
// backtrack solves again, or that draws again below a changed parent, stands where a number of its own puts it.
TEST_CASE(
    "beads that a backtrack or a repair above has solved again stand where a later number of their own puts them") {
  const std::vector<double> load = {1, 1, 1, 1, 8, 1, 1, 1};
  const Lattice lattice({.columns = 8, .layers = 3});
  SamplerSpec spec;
  spec.mu = 0.3;
  spec.seed = 17;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice);
  int backtracked = 0, repaired_after_backtrack = 0;
  for (std::uint64_t sample = 0; sample < 6000; ++sample) {
    const SamplerCounts before = sampler->counts();
    REQUIRE_FALSE(sampler->draw(sample, load, pile));
    const SamplerCounts after = sampler->counts();
    if (after.backtracks != before.backtracks + 1 || after.arcs + after.rings != before.arcs + before.rings) continue;
    ++backtracked;
    const int pairs = static_cast<int>(after.pairs - before.pairs);
    // The backtrack solves three beads of the top layer and four of the middle one again, with a number each; what else
    // draws are neighbours of beads of the middle layer that are repaired then.
    const auto numbers = static_cast<int>(after.uniforms - before.uniforms);
    const int neighbours = numbers - 24 - 2 * pairs - 7;
    const std::vector<int> off = beads_off_their_numbers(pile, 32);
    CAPTURE(sample, pairs, numbers, neighbours, off);
    CHECK(neighbours >= 0);
    CHECK(off[1] <= 2 * (pairs - (off[0] + 1) / 2));
    CHECK(off[2] == 0);
    repaired_after_backtrack += neighbours > 0 && off[1] == 2 * (pairs - (off[0] + 1) / 2) ? 1 : 0;
  }
  CAPTURE(backtracked, repaired_after_backtrack);
  CHECK(repaired_after_backtrack >= 40);
}

// Source: blind rejection. Points uniform in the rectangle that miss the band are thrown away; what stays is uniform on
// the polygon by definition.

/// The double nearest below 1: the largest uniform number there is.
const double last_uniform = 1 - std::ldexp(1.0, -53);

struct Polygon {
  Interval A, B, D;
};

std::vector<PairDraw> draw_blindly(const Polygon& p, int count, std::mt19937_64& engine) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<PairDraw> draws;
  for (long tries = 0; static_cast<int>(draws.size()) < count; ++tries) {
    if (tries > 2'000'000L + 20'000L * count) throw std::runtime_error("the polygon is too small to be met blindly");
    const double a = p.A.low + unit(engine) * (p.A.high - p.A.low), b = p.B.low + unit(engine) * (p.B.high - p.B.low);
    if (a - b >= p.D.low && a - b <= p.D.high) draws.push_back({a, b});
  }
  return draws;
}

std::vector<PairDraw> draw_in_closed_form(const Polygon& p, int count, std::mt19937_64& engine) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<PairDraw> draws;
  for (int k = 0; k < count; ++k) {
    const auto drawn = draw_truncated_pair(p.A, p.B, p.D, unit(engine), unit(engine));
    if (!drawn) throw std::runtime_error("nothing drawn from a polygon that is not empty");
    draws.push_back(*drawn);
  }
  return draws;
}

/// Two-sample Kolmogorov-Smirnov statistic times sqrt(n m / (n + m)).
double kolmogorov_smirnov(std::vector<double> x, std::vector<double> y) {
  std::sort(x.begin(), x.end());
  std::sort(y.begin(), y.end());
  const auto n = static_cast<double>(x.size()), m = static_cast<double>(y.size());
  double worst = 0;
  for (std::size_t i = 0, j = 0; i < x.size() && j < y.size();) {
    const double here = std::min(x[i], y[j]);
    while (i < x.size() && x[i] == here) ++i;
    while (j < y.size() && y[j] == here) ++j;
    worst = std::max(worst, std::abs(static_cast<double>(i) / n - static_cast<double>(j) / m));
  }
  return worst * std::sqrt(n * m / (n + m));
}

/// P(statistic > t) ~ 2 exp(-2 t^2): the t that `comparisons` together exceed as rarely as one five-sigma test.
double kolmogorov_smirnov_bound(int comparisons) {
  return std::sqrt(0.5 * std::log(2 * comparisons / test::five_sigma_tail()));
}

TEST_CASE("pairs are uniform on rectangle and band: against blind rejection on polygons of every shape") {
  const unsigned seed = 31337;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Polygon> polygons = {
      {{0, 1}, {0, 1}, {-2, 2}},                         // the whole square
      {{0, 1}, {0, 1}, {0, 2}},                          // a triangle, from its longest side
      {{0, 1}, {0, 1}, {0.95, 2}},                       // a small triangle in the corner
      {{0, 1}, {0, 1}, {-2, -0.9}},                      // the corner opposite
      {{0, 1}, {0, 1}, {0.3, 0.301}},                    // a thin strip along the band
      {{0, 1}, {0, 1e-3}, {0.2, 0.7}},                   // a thin rectangle
      {{-3, 5}, {1, 1.5}, {-1, 0.25}},                   // a trapezoid's middle and fall
      {{0, 1e-3}, {-4, 4}, {-1, 1}},                     // the other side thin
      {{1e6, 1e6 + 1}, {0, 1}, {1e6 - 0.2, 1e6 + 0.1}},  // far from the origin
      {{0, 1}, {0, 0}, {0.25, 0.5}},                     // a segment
      {{2, 2}, {0, 3}, {-1, 1}},                         // the other segment
  };
  for (int k = 0; k < 30; ++k) {
    const auto width = [&] { return std::pow(10, 2 * unit(engine) - 1); };
    const double a = 4 * unit(engine) - 2, b = 4 * unit(engine) - 2, wa = width(), wb = width();
    const double lowest = a - b - wb, span = wa + wb;
    const double from = lowest + span * 0.9 * unit(engine), to = from + span * (0.05 + unit(engine));
    polygons.push_back({{a, a + wa}, {b, b + wb}, {from, to}});
  }
  const int count = 40'000 / share_of_samples;
  REQUIRE(count >= 2000);
  const double bound = kolmogorov_smirnov_bound(4 * static_cast<int>(polygons.size()));
  for (const Polygon& p : polygons) {
    CAPTURE(p.A.low, p.A.high, p.B.low, p.B.high, p.D.low, p.D.high);
    const auto closed = draw_in_closed_form(p, count, engine), blind = draw_blindly(p, count, engine);
    const auto compare = [&](auto number) {
      std::vector<double> x, y;
      for (const PairDraw& draw : closed) x.push_back(number(draw));
      for (const PairDraw& draw : blind) y.push_back(number(draw));
      return kolmogorov_smirnov(x, y);
    };
    CHECK(compare([](const PairDraw& d) { return d.a; }) < bound);
    CHECK(compare([](const PairDraw& d) { return d.b; }) < bound);
    CHECK(compare([](const PairDraw& d) { return d.a - d.b; }) < bound);
    // A direction of its own, so that the joint law is seen and not only its marginals.
    CHECK(compare([](const PairDraw& d) { return 2 * d.a + 3 * d.b; }) < bound);
  }
}

TEST_CASE("the comparison would see a wrong law") {
  // a uniform on its own shadow and then b uniform on its chord is not uniform on a triangle.
  const unsigned seed = 5;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const int count = 40'000 / share_of_samples;
  std::vector<double> wrong, right;
  for (const PairDraw& draw : draw_blindly({{0, 1}, {0, 1}, {0, 2}}, count, engine)) right.push_back(draw.a);
  for (int k = 0; k < count; ++k) wrong.push_back(unit(engine));
  CHECK(kolmogorov_smirnov(wrong, right) > 2 * kolmogorov_smirnov_bound(200));
}

TEST_CASE("the difference stays in its band, and the numbers in their intervals, at any scale of forces") {
  const unsigned seed = 8;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  int drawn_count = 0, none = 0, wrong = 0;
  double worst = 0;
  for (int k = 0; k < 1'000'000 / share_of_samples; ++k) {
    const auto width = [&] { return unit(engine) < 0.1 ? 0 : std::pow(10, 12 * unit(engine) - 9); };
    const double a = 200 * unit(engine) - 100, b = 200 * unit(engine) - 100;
    const Interval A{a, a + width()}, B{b, b + width()};
    const double from = a - b + 2 * (unit(engine) - 0.5) * (A.high - a + B.high - b);
    const Interval D{from, from + width()};
    const auto uniform = [&] { return unit(engine) < 0.1 ? (unit(engine) < 0.5 ? 0.0 : last_uniform) : unit(engine); };
    const auto drawn = draw_truncated_pair(A, B, D, uniform(), uniform());
    const double low = std::max(D.low, A.low - B.high), high = std::min(D.high, A.high - B.low);
    wrong += drawn.has_value() != (low <= high);
    if (!drawn) {
      ++none;
      continue;
    }
    ++drawn_count;
    wrong += drawn->a < A.low || drawn->a > A.high || drawn->b < B.low || drawn->b > B.high;
    // a and b round at their own size: at most a unit in the last place each.
    const double ulp =
        std::ldexp(std::max({std::abs(A.low), std::abs(A.high), std::abs(B.low), std::abs(B.high)}), -52);
    worst = std::max(worst, std::max(low - (drawn->a - drawn->b), drawn->a - drawn->b - high) / ulp);
  }
  CAPTURE(drawn_count, none);
  CHECK(wrong == 0);
  CHECK(worst <= 2);
  CHECK(drawn_count > 100'000 / share_of_samples);
  CHECK(none > 10'000 / share_of_samples);
}

TEST_CASE("polygons without area: a segment, a point, nothing") {
  const auto point = draw_truncated_pair({1, 1}, {2, 2}, {-1, -1}, 0.3, 0.6);
  REQUIRE(point.has_value());
  CHECK(point->a == 1);
  CHECK(point->b == 2);
  // The band touches the square in one corner.
  const auto corner = draw_truncated_pair({0, 1}, {0, 1}, {1, 5}, 0.3, 0.6);
  REQUIRE(corner.has_value());
  CHECK(corner->a == 1);
  CHECK(corner->b == 0);
  // A band of no width across the square: the segment a - b = 1/4 is sampled along its length.
  const auto segment = draw_truncated_pair({0, 1}, {0, 1}, {0.25, 0.25}, 0.5, 0.5);
  REQUIRE(segment.has_value());
  CHECK(segment->a == 0.625);
  CHECK(segment->b == 0.375);
  CHECK_FALSE(draw_truncated_pair({0, 1}, {0, 1}, {1.5, 2}, 0.5, 0.5).has_value());
  CHECK_FALSE(draw_truncated_pair({0, 1}, {0, 1}, {-3, -1.5}, 0.5, 0.5).has_value());
  CHECK_FALSE(draw_truncated_pair({1, 0}, {0, 1}, {-3, 3}, 0.5, 0.5).has_value());
  CHECK_FALSE(draw_truncated_pair({0, 1}, {1, 0}, {-3, 3}, 0.5, 0.5).has_value());
  CHECK_FALSE(draw_truncated_pair({0, 1}, {0, 1}, {0.5, 0.2}, 0.5, 0.5).has_value());
}

TEST_CASE("loads scaled by a power of two give the scaled pair bit for bit") {
  const unsigned seed = 12;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  int compared = 0;
  for (int k = 0; k < 100'000 / share_of_samples; ++k) {
    const double a = unit(engine), b = unit(engine), d = a - b + unit(engine) - 0.5;
    const Polygon p{{a, a + unit(engine)}, {b, b + unit(engine)}, {d, d + unit(engine)}};
    const double u = unit(engine), v = unit(engine);
    const auto plain = draw_truncated_pair(p.A, p.B, p.D, u, v);
    if (!plain) continue;
    for (const int power : {-200, 200}) {
      const auto scaled = [&](Interval i) { return Interval{std::ldexp(i.low, power), std::ldexp(i.high, power)}; };
      const auto big = draw_truncated_pair(scaled(p.A), scaled(p.B), scaled(p.D), u, v);
      REQUIRE(big.has_value());
      REQUIRE(big->a == std::ldexp(plain->a, power));
      REQUIRE(big->b == std::ldexp(plain->b, power));
      ++compared;
    }
  }
  CHECK(compared > 100'000 / share_of_samples);
}

// Source: what the system's allocator says it has handed out.

/// In bytes.
double handed_out() {
  const struct mallinfo2 now = ::mallinfo2();
  return static_cast<double>(now.uordblks + now.hblkhd);
}

TEST_CASE("drawing takes no more memory than is estimated, and not much less") {
  if (test::sanitized) return;  // its allocator keeps no such account
  for (const double mu : {0.1, 0.3}) {
    for (const LatticeSpec size : {LatticeSpec{64, 800}, {500, 200}}) {
      CAPTURE(mu, size.columns, size.layers);
      const Lattice lattice(size);
      SamplerSpec spec;
      spec.mu = mu;
      spec.effort = 1000;
      const std::size_t piles = piles_at_once(spec, lattice);
      std::vector<std::vector<double>> loads(piles, std::vector<double>(static_cast<std::size_t>(size.columns), 1.0));
      loads[3][25] = 1e3;  // evicted from its group, and drawn by itself
      const std::vector<std::span<const double>> views(loads.begin(), loads.end());
      std::vector<std::uint64_t> samples(piles);
      std::iota(samples.begin(), samples.end(), std::uint64_t{24});
      KeptLayers all, some{{}, true};
      for (int layer = 0; layer < size.layers; ++layer) {
        all.layers.push_back(layer);
        if (layer % 20 == 0) some.layers.push_back(layer);
      }
      std::vector<std::optional<SamplingFailure>> failures(piles);
      for (const KeptLayers* const kept : {&all, &some}) {
        const double before = handed_out();
        const auto sampler = make_sampler(spec, lattice);
        sampler->keep_layers(*kept);
        sampler->draw_groups(samples, views, failures);
        const double taken = handed_out() - before, estimated = drawing_memory(spec, lattice, kept);
        INFO(taken << " of " << estimated << " for " << kept->layers.size() << " layers");
        CHECK(taken <= 1.02 * estimated);
        CHECK(taken >= (kept == &all ? 0.6 : 0.5) * estimated);
      }
    }
  }
}

// Source: a draw that is stopped leaves a sampler that draws as if nothing had been.

/// Asked for until the end of its life.
class Stop {
 public:
  Stop() { request_interruption(true); }
  ~Stop() { request_interruption(false); }
  Stop(const Stop&) = delete;
  Stop& operator=(const Stop&) = delete;
};

TEST_CASE("every law stops in the midst of a pile where that is asked for, and goes on afterwards") {
  const Lattice lattice({6, 6});
  const std::vector<double> load(6, 1.0);
  const std::vector<std::span<const double>> loads(8, load);
  const std::vector<std::uint64_t> samples = {0, 1, 2, 3, 4, 5, 6, 7};
  for (const Law law : all_laws) {
    CAPTURE(name_of(law));
    SamplerSpec spec;
    spec.law = law;
    spec.mu = 0.5;
    spec.burn_in = spec.thinning = law == Law::polytope ? 50 : 0;
    const auto stopped = make_sampler(spec, lattice), other = make_sampler(spec, lattice);
    Pile pile(lattice), expected(lattice);
    std::vector<std::optional<SamplingFailure>> failures(8);
    {
      const Stop stop;
      CHECK_THROWS_AS(stopped->draw(3, load, pile), Interrupted);
      CHECK_THROWS_AS(stopped->draw_groups(samples, loads, failures), Interrupted);
    }
    stopped->take_counts();
    REQUIRE_FALSE(other->draw(5, load, expected));
    REQUIRE_FALSE(stopped->draw(5, load, pile));
    CHECK(pile.H_R == expected.H_R);
    CHECK(stopped->counts().uniforms == other->counts().uniforms);
    const auto groups = stopped->draw_groups(samples, loads, failures);
    double weight = 0;
    for (const PileGroup& group : groups) weight += group.weight(group.row(5));
    CHECK(weight > 0);
  }
}

TEST_CASE("a backtrack that finds no way does not outlive a request to stop") {
  const Lattice lattice({16, 40});
  const std::vector<double> load(16, 1.0);
  SamplerSpec spec;
  spec.mu = 0.3;
  spec.rules = RepairRules::backtrack_only;
  spec.effort = 1e9;
  Pile pile(lattice);
  const auto sampler = make_sampler(spec, lattice);
  // By backtracks alone no such pile is completed; without the request this would go on for days.
  const std::jthread later([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    request_interruption(true);
  });
  CHECK_THROWS_AS(sampler->draw(0, load, pile), Interrupted);
  request_interruption(false);
}

}  // namespace

}  // namespace granuscope
