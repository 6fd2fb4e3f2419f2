#include "ensemble/group_fourier.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "kit/instruction_sets.h"

using namespace granuscope;

namespace {

using Complex = std::complex<double>;

Complex root(std::size_t k, std::size_t n) {
  return std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(k % n) / static_cast<double>(n));
}

AlignedArray<double> random_numbers(std::size_t size, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  AlignedArray<double> numbers = aligned_array<double>(size);
  for (std::size_t i = 0; i < size; ++i) numbers[i] = uniform(generator);
  return numbers;
}

}  // namespace

TEST_CASE("the transforms of eight rings are their Fourier sums, in every lane and on every machine the same") {
  for (const std::size_t n : {4U, 5U, 6U, 7U, 12U, 30U, 49U, 60U, 64U, 97U, 121U, 210U, 500U, 512U}) {
    const AlignedArray<double> re = random_numbers(n * group_lanes, n), im = random_numbers(n * group_lanes, n + 1);
    std::vector<double> first;
    for_each_instruction_set([&] {
      AlignedArray<double> out_re = aligned_array<double>(n * group_lanes),
                           out_im = aligned_array<double>(n * group_lanes);
      std::copy_n(re.get(), n * group_lanes, out_re.get());
      std::copy_n(im.get(), n * group_lanes, out_im.get());
      // The last lane holds what the first one does.
      for (std::size_t i = 0; i < n; ++i) {
        out_re[i * group_lanes + 7] = re[i * group_lanes];
        out_im[i * group_lanes + 7] = im[i * group_lanes];
      }
      GroupFourier(n).transform(out_re.get(), out_im.get());
      INFO("rings of " << n);
      double worst = 0;
      bool same_lanes = true;
      for (std::size_t m = 0; m < n; ++m) {
        for (std::size_t k = 0; k < group_lanes - 1; ++k) {
          Complex sum = 0;
          for (std::size_t j = 0; j < n; ++j) {
            sum += Complex(re[j * group_lanes + k], im[j * group_lanes + k]) * root(j * m, n);
          }
          const std::size_t at = m * group_lanes + k;
          worst = std::max(worst, std::abs(sum - Complex(out_re[at], out_im[at])));
        }
        const std::size_t at = m * group_lanes;
        same_lanes = same_lanes && out_re[at] == out_re[at + 7] && out_im[at] == out_im[at + 7];
      }
      CHECK(worst < 1e-13 * static_cast<double>(n));
      CHECK(same_lanes);
      std::vector<double> numbers(out_re.get(), out_re.get() + n * group_lanes);
      numbers.insert(numbers.end(), out_im.get(), out_im.get() + n * group_lanes);
      if (first.empty()) first = numbers;
      CHECK(numbers == first);
    });
  }
}

TEST_CASE("correlations of layers are sums of products, the same on every machine") {
  constexpr std::size_t layers = 9;
  const std::size_t of_layer = correlation_parts * group_lanes;
  const AlignedArray<double> fields = random_numbers(layers * of_layer, 5), before = random_numbers(of_layer, 6);
  const std::vector<int> pairs = {0, 3, 2, 5, 4, 7, 5, 8};
  std::vector<double> first;
  for_each_instruction_set([&] {
    AlignedArray<double> sums = aligned_array<double>(of_layer);
    std::copy_n(before.get(), of_layer, sums.get());
    add_correlations(fields.get(), pairs, sums.get());
    for (std::size_t k = 0; k < group_lanes; ++k) {
      Complex ww = 0, HH = 0, wH = 0, Hw = 0;
      for (std::size_t i = 0; i < pairs.size(); i += 2) {
        const auto field = [&](int layer, std::size_t part) {
          const double* const at = &fields[static_cast<std::size_t>(layer) * of_layer + 2 * part * group_lanes + k];
          return Complex(at[0], at[group_lanes]);
        };
        const Complex w = field(pairs[i], 0), H = field(pairs[i], 1), w2 = field(pairs[i + 1], 0),
                      H2 = field(pairs[i + 1], 1);
        ww += w2 * std::conj(w);
        HH += H2 * std::conj(H);
        wH += w2 * std::conj(H);
        Hw += H2 * std::conj(w);
      }
      CHECK(sums[k] == Approx(before[k] + ww.real()).epsilon(1e-12));
      CHECK(sums[8 + k] == Approx(before[8 + k] + HH.real()).epsilon(1e-12));
      CHECK(sums[16 + k] == Approx(before[16 + k] + wH.imag()).epsilon(1e-12));
      CHECK(sums[24 + k] == Approx(before[24 + k] + Hw.imag()).epsilon(1e-12));
    }
    const std::vector<double> numbers(sums.get(), sums.get() + of_layer);
    if (first.empty()) first = numbers;
    CHECK(numbers == first);
  });
}
