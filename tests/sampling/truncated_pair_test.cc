// Source: blind rejection. Points uniform in the rectangle that miss the band are thrown away; what stays is uniform on
// the polygon by definition.
#include "sampling/random_key.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "kit/sampling_statistics.h"

namespace granuscope {
namespace {

using test::share_of_samples;

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

}  // namespace
}  // namespace granuscope
