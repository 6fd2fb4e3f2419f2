// Source of the expected numbers: the known-answer vectors of Philox4x32-10 in the Random123 distribution
// (tests/kat_vectors) and a second implementation written from the paper (Salmon et al., SC 2011).
#include "sampling/random_key.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <set>
#include <vector>

#include "kit/sampling_statistics.h"
#include "sampling/layer_kernels.h"

namespace granuscope {
namespace {

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

}  // namespace
}  // namespace granuscope
