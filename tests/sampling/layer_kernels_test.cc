#include "sampling/layer_kernels.h"

#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "kit/instruction_sets.h"
#include "sampling/random_key.h"

using namespace granuscope;

namespace {

std::vector<std::uint64_t> bits(const std::vector<double>& values, std::size_t count) {
  std::vector<std::uint64_t> result;
  for (std::size_t i = 0; i < count; ++i) result.push_back(std::bit_cast<std::uint64_t>(values[i]));
  return result;
}

struct Row {
  explicit Row(std::size_t size) : V_R(size), V_L(size), H(size), H_R(size), H_L(size), slack(size) {}
  LowerRow view() { return {V_R.data(), V_L.data(), H.data(), H_R.data(), H_L.data(), slack.data()}; }
  std::vector<double> V_R, V_L, H, H_R, H_L, slack;
};

}  // namespace

TEST_CASE("first uniforms are the same bytes on every instruction set") {
  for (std::size_t beads : {1U, 4U, 5U, 17U, 500U, 1001U}) {
    std::vector<double> plain(beads + uniform_padding), vectorised(beads + uniform_padding);
    fill_first_uniforms_plain(0x123456789abcdef0ULL, 0xfffffffeU, 137, plain.data(), beads);
    for_each_instruction_set([&] {
      fill_first_uniforms(0x123456789abcdef0ULL, 0xfffffffeU, 137, vectorised.data(), beads);
      CHECK(bits(plain, beads) == bits(vectorised, beads));
    });
    for (std::size_t i = 0; i < beads; ++i) CHECK((plain[i] >= 0 && plain[i] < 1));
  }
}

TEST_CASE("numbers of later attempts are those of the random key on every instruction set") {
  const std::uint64_t seed = 0x123456789abcdef0ULL;
  const RandomKey key(seed, 0xfffffffeU);
  const std::array<std::uint32_t, attempts_at_once> beads{0, 1, 2, 7, 499, 500, 1'000'000, 2'147'483'647};
  const std::array<std::uint32_t, attempts_at_once> attempts{1, 2, 3, 255, 256, 65'535, 1U << 23, (1U << 24) - 1};
  for_each_instruction_set([&] {
    std::array<double, attempts_at_once> numbers{};
    later_numbers(PhiloxKeys(seed), key.sample(), 137, beads, attempts, numbers);
    for (std::size_t k = 0; k < attempts_at_once; ++k) {
      CHECK(numbers[k] == key.attempt(137, static_cast<int>(beads[k]), attempts[k]).first);
    }
  });
}

TEST_CASE("beads drawn in vectors are the same bytes as bead by bead on every instruction set") {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> uniform;
  for (double mu : {1e-9, 0.1, 0.57735026918962576451, 1.3, 1.73}) {
    const FrictionCone cone(mu);
    const std::size_t beads = 1003;
    std::vector<double> V_UL(beads), V_UR(beads), H_UL(beads), H_UR(beads), u(beads + uniform_padding);
    for (std::size_t i = 0; i < beads; ++i) {
      // Forces over many orders of magnitude, some without any solution, some exactly 0.
      const double scale = std::exp2(static_cast<double>(i % 40) - 20);
      V_UL[i] = i % 97 == 0 ? 0 : uniform(generator) * scale;
      V_UR[i] = i % 89 == 0 ? 0 : uniform(generator) * scale;
      H_UL[i] = uniform(generator) * V_UL[i];
      H_UR[i] = -uniform(generator) * V_UR[i];
      u[i] = i % 13 == 0 ? 0 : uniform(generator);
    }
    const UpperRow above{V_UL.data(), V_UR.data(), H_UL.data(), H_UR.data()};
    Row plain(beads);
    draw_beads_plain(cone, above, u.data(), beads, plain.view());
    for_each_instruction_set([&] {
      Row vectorised(beads);
      draw_beads(cone, above, u.data(), beads, vectorised.view());
      CHECK(bits(plain.V_R, beads) == bits(vectorised.V_R, beads));
      CHECK(bits(plain.V_L, beads) == bits(vectorised.V_L, beads));
      CHECK(bits(plain.H, beads) == bits(vectorised.H, beads));
      CHECK(bits(plain.H_R, beads) == bits(vectorised.H_R, beads));
      CHECK(bits(plain.H_L, beads) == bits(vectorised.H_L, beads));
      CHECK(bits(plain.slack, beads) == bits(vectorised.slack, beads));
    });
  }
}

TEST_CASE("failing beads are the same bits on every instruction set") {
  std::mt19937_64 generator(4);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (std::size_t beads : {1U, 7U, 8U, 63U, 64U, 65U, 500U}) {
    std::vector<double> slack(beads);
    for (double& value : slack) value = uniform(generator);
    slack[beads / 2] = 0;
    slack[beads / 3] = std::nan("");  // has no solution either
    std::vector<std::uint64_t> plain((beads + 63) / 64, ~std::uint64_t{0}), vectorised(plain);
    find_failing_plain(slack.data(), beads, plain.data());
    for_each_instruction_set([&] {
      find_failing(slack.data(), beads, vectorised.data());
      CHECK(plain == vectorised);
    });
    for (std::size_t i = 0; i < 64 * plain.size(); ++i) {
      const bool failing = (plain[i / 64] >> (i % 64) & 1) != 0;
      CHECK(failing == (i < beads && !(slack[i] >= 0)));
    }
  }
}
