#include "history/comparison.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "history/nightly.h"

using namespace granuscope;

namespace {

std::vector<KnownNumber> numbers(double first, double error) {
  return {{"c", first, error}, {"D", 0.1, 0.01}, {"alpha", 0.6, 0.02}};
}

const MovedNumber& named(const std::vector<MovedNumber>& all, const std::string& name) {
  for (const MovedNumber& one : all) {
    if (one.name == name) return one;
  }
  throw std::runtime_error("no number " + name);
}

}  // namespace

TEST_CASE("Student's t is the reference of jackknife errors") {
  // Tables: the two-sided 0.1 % point of 31 degrees of freedom is 3.633, that of many 3.291.
  CHECK(chance_of(3.633, 31) == Approx(1e-3).epsilon(0.01));
  CHECK(chance_of(3.291, 1e6) == Approx(1e-3).epsilon(0.01));
  CHECK(chance_of(INFINITY, 31) == 0);
}

TEST_CASE("Holm's correction is by the number of numbers, and goes on after the first") {
  // Both with 31 + 31 degrees of freedom: 4.2 standard errors are a chance of 9e-5, which 1e-3 / 3 allows.
  const auto moved = hold_against(numbers(0.5, 0.003), 32, numbers(0.5 + 4.2 * std::hypot(0.003, 0.003), 0.003), 32);
  CHECK(named(moved, "c").z == Approx(4.2));
  CHECK(named(moved, "c").moved);
  CHECK_FALSE(named(moved, "D").moved);
  // 3.6 standard errors are 6e-4: too much for one of three.
  const auto not_moved =
      hold_against(numbers(0.5, 0.003), 32, numbers(0.5 + 3.6 * std::hypot(0.003, 0.003), 0.003), 32);
  CHECK_FALSE(named(not_moved, "c").moved);
}

TEST_CASE("An exact number that changes has moved, whatever the others say") {
  const auto moved = hold_against(numbers(0.5, 0), 32, numbers(0.5000001, 0), 32);
  CHECK(named(moved, "c").moved);
  CHECK(std::isinf(named(moved, "c").z));
  CHECK_FALSE(named(hold_against(numbers(0.5, 0), 32, numbers(0.5, 0), 32), "c").moved);
}

TEST_CASE("What rounding leaves of an exact width has not moved") {
  const auto widths = [](double W) {
    return depth_numbers(
        {{"scan", "mu"},
         {"results", {{{"mu", 0.0}, {"depths", {{{"layer", 17}, {"width", {{"value", W}, {"stderr", 0.0}}}}}}}}}});
  };
  REQUIRE(widths(2.9e-7).size() == 1);
  CHECK(hold_against(widths(2.9e-7), 32, widths(1.1e-6), 32)[0].z == 0);
  CHECK(std::isinf(hold_against(widths(2.9e-7), 32, widths(1.1e-4), 32)[0].z));
}

TEST_CASE("Numbers that only one side knows are not compared") {
  std::vector<KnownNumber> fewer = numbers(0.5, 0.01);
  fewer.pop_back();
  CHECK(hold_against(numbers(0.5, 0.01), 32, fewer, 32).size() == 2);
  CHECK(hold_against(fewer, 32, numbers(0.5, 0.01), 32).size() == 2);
}

TEST_CASE("Of 2000 simulated nights without a change fewer than one in a thousand alarms") {
  const std::uint64_t seed = 17;
  CAPTURE(seed);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> gauss;
  constexpr int blocks = 32, family = 24, nights = 2000;
  // What a jackknife over 32 blocks would say: the mean of so many blocks and the scatter of these.
  const auto measure = [&](double samples) {
    std::vector<KnownNumber> all;
    for (int k = 0; k < family; ++k) {
      double sum = 0, squares = 0;
      for (int b = 0; b < blocks; ++b) {
        const double one = gauss(random) * std::sqrt(blocks / samples);
        sum += one;
        squares += one * one;
      }
      const double mean = sum / blocks;
      all.push_back({std::to_string(k), mean, std::sqrt((squares / blocks - mean * mean) / (blocks - 1))});
    }
    return all;
  };
  int told = 0, watched = 0;
  std::vector<Night> before;
  for (int n = 1; n <= nights; ++n) {
    Night night;
    for (const MovedNumber& one : hold_against(measure(n), blocks, measure(1), blocks)) {
      night.numbers.push_back({one.name, one.after, one.after.value, one.after.standard_error, one.z, one.moved});
    }
    add_soft_alarms(night, before);
    for (const Alarm& alarm : night.alarms) (alarm.state == "open" ? told : watched) += 1;
    before = {night};
  }
  WARN("false alarms told: " << told << " of " << nights << " nights; numbers that moved on one night: " << watched);
  CHECK(told < nights / 1000);
  // Holm's rate is 1e-3 for the whole family: 2 in 2000 nights are expected, more than 11 come once in 1e5.
  CHECK(watched <= 11);
}

TEST_CASE("A number must move, and a verdict change, on two nights in a row") {
  Night first, second, third;
  first.numbers = {{"c", {"c", 0.5, 0.01}, 0.6, 0.01, 7.0, true}};
  first.verdicts = {{"claim", "reproduced", 1}, {"other", "reproduced", 2.5}};
  add_soft_alarms(first, {});
  REQUIRE(first.alarms.size() == 1);
  CHECK(first.alarms[0].state == "watched");
  second.numbers = first.numbers;
  second.verdicts = {{"claim", "not reproduced", 5}, {"other", "not reproduced", 3.5}};
  add_soft_alarms(second, {first});
  REQUIRE(second.alarms.size() == 2);
  CHECK(second.alarms[0].state == "open");
  CHECK(second.alarms[1].state == "watched");  // the verdict of "claim"; "other" is at the edge
  third.verdicts = second.verdicts;
  add_soft_alarms(third, {first, second});
  REQUIRE(third.alarms.size() == 1);
  CHECK(third.alarms[0].state == "open");
  CHECK(third.alarms[0].what == "claim: not reproduced for two nights now where it was reproduced");
  Night fourth = third;
  fourth.alarms.clear();
  add_soft_alarms(fourth, {second, third});
  CHECK(fourth.alarms.empty());
  // What becomes undecided, or decided for the first time, is no change.
  Night undecided = first, decided = first;
  undecided.alarms.clear();
  decided.alarms.clear();
  undecided.numbers.clear();
  decided.numbers.clear();
  undecided.verdicts = {{"claim", "undetermined", 1}};
  add_soft_alarms(undecided, {first});
  CHECK(undecided.alarms.empty());
  decided.verdicts = {{"claim", "not reproduced", 6}};
  add_soft_alarms(decided, {undecided, undecided});
  CHECK(decided.alarms.empty());
  add_soft_alarms(decided, {first, undecided, decided});  // but not on the way through
  REQUIRE(decided.alarms.size() == 1);
  CHECK(decided.alarms[0].state == "open");
}
