// Fluctuations and Fourier modes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <numeric>
#include <random>
#include <tuple>
#include <vector>

#include "ensemble/ensemble_runner.h"
#include "ensemble/estimator.h"
#include "ensemble/group_fourier.h"
#include "ensemble/small_ensemble.h"
#include "kit/instruction_sets.h"
#include "sampling/sampler.h"
#include "support/error.h"

namespace granuscope {

// Source of the expected numbers: each pile drawn by itself, its layers transformed and multiplied straight from the
// definition.

namespace {

using Complex = std::complex<double>;

EnsembleSpec small_ensemble(int columns) {
  EnsembleSpec spec = test::small_ensemble({.estimator = EstimatorName::fluctuation}, columns);
  spec.response.first_base = 20;
  spec.response.reference_lag = 4;
  spec.response.base_step = 2;
  spec.lattice.layers = 60;
  spec.layers = {1, 3, 8};  // lag 0 comes along
  return spec;
}

struct Modes {
  Complex w, H;
};
Modes modes_of(const Pile& pile, int layer, int m) {
  Modes modes;
  for (int i = 0; i < pile.lattice.columns(); ++i) {
    const std::size_t at = pile.lattice.index(layer, i);
    const Complex wave = std::polar(1.0, -2 * std::numbers::pi * m * pile.lattice.x(layer, i) / pile.lattice.columns());
    modes.w += wave * (pile.V_R[at] + pile.V_L[at] - 1);
    modes.H += wave * (pile.H_R[at] + pile.H_L[at]);
  }
  return modes;
}

/// What the sums hold of some modes, block and lags, against the piles themselves.
void check_sums(const EnsembleSpec& spec, const std::vector<int>& modes) {
  const EnsembleRecord record = run_ensemble(spec, 2, nullptr);
  const FluctuationPlan plan = fluctuation_plan(spec);
  REQUIRE(plan.bases.size() > 2);
  REQUIRE(record.sums.layers == plan.lags);
  const Lattice lattice(spec.lattice);
  const auto sampler = make_sampler(spec.sampler, lattice);
  const std::size_t block = 3, width = 2 * static_cast<std::size_t>(lattice.columns());
  std::vector<Pile> piles;
  for (std::uint64_t sample = 24; sample < 32; ++sample) {
    const std::vector<double> load(static_cast<std::size_t>(lattice.columns()), 1.0);
    REQUIRE_FALSE(sampler->draw(sample, load, piles.emplace_back(lattice)).has_value());
  }
  std::map<std::tuple<std::uint64_t, int, int>, Modes> modes_by;
  double unmirrored = 0;
  for (std::size_t l = 0; l < plan.lags.size(); ++l) {
    const double* const sums = &record.sums.quantities.at("propagation").sum[(block * plan.lags.size() + l) * width];
    for (const int m : modes) {
      Complex ww = 0, HH = 0, wH = 0, Hw = 0;
      for (const Pile& pile : piles) {
        const auto known = [&](int layer) {
          const auto [found, is_new] = modes_by.try_emplace({pile.sample, layer, m});
          if (is_new) found->second = modes_of(pile, layer, m);
          return found->second;
        };
        for (const int base : plan.bases) {
          const Modes at = known(base), below = known(base + plan.reference + plan.lags[l]);
          ww += below.w * std::conj(at.w);
          HH += below.H * std::conj(at.H);
          wH += below.w * std::conj(at.H);
          Hw += below.H * std::conj(at.w);
        }
      }
      const bool counts = m <= plan.modes[l];
      const double scale = counts ? 1.0 / lattice.columns() / static_cast<double>(plan.bases.size()) : 0;
      const double* const part = sums + 4 * (m - 1);
      CAPTURE(l, m, counts);
      CHECK(part[0] == Approx(scale * ww.real()).epsilon(1e-9).margin(1e-12));
      CHECK(part[1] == Approx(scale * HH.real()).epsilon(1e-9).margin(1e-12));
      CHECK(part[2] == Approx(scale * wH.imag()).epsilon(1e-9).margin(1e-12));
      CHECK(part[3] == Approx(scale * Hw.imag()).epsilon(1e-9).margin(1e-12));
      // A pile's mirror image has the modes (conj w, -conj H), so that these are the means over both. Without the
      // images C has other entries, too, here:
      if (counts) unmirrored = std::max({unmirrored, scale * std::abs(ww.imag()), scale * std::abs(wH.real())});
    }
    double thrust = 0;
    for (const Pile& pile : piles) {
      for (const int base : plan.bases) {
        for (int i = 0; i < lattice.columns(); ++i) {
          const std::size_t at = lattice.index(base + plan.reference + plan.lags[l], i);
          thrust += sqrt3 * (pile.H_R[at] - pile.H_L[at]) / lattice.columns() / static_cast<double>(plan.bases.size());
        }
      }
    }
    CHECK(record.sums.quantities.at("thrust").sum[block * plan.lags.size() + l] == Approx(thrust).epsilon(1e-10));
  }
  CHECK(unmirrored > 1e-4);
}

}  // namespace

TEST_CASE("fluctuation: block sums are the correlations of layers of separately drawn piles") {
  for (const int columns : {20, 21}) {
    std::vector<int> modes(static_cast<std::size_t>((columns - 1) / 2));
    std::iota(modes.begin(), modes.end(), 1);
    check_sums(small_ensemble(columns), modes);
  }
  EnsembleSpec chains = small_ensemble(12);  // each pile drawn by itself
  chains.sampler.law = Law::polytope;
  chains.sampler.burn_in = 64;
  chains.sampler.thinning = 8;
  check_sums(chains, {1, 2, 5});
}

TEST_CASE("fluctuation: piles whose layers do not fit into memory at once are compared all the same") {
  EnsembleSpec spec = small_ensemble(2000);
  spec.sampler.mu = 0.1;  // nearly all modes carry weight
  spec.lattice.layers = 320;
  spec.response.base_step = 1;
  spec.layers = {10, 11};
  check_sums(spec, {1, 77, 900});
  // From a base to its partners there are more layers farther down, where partners of earlier bases lie between.
  spec.response.base_step = 4;
  spec.layers = {100, 101};
  check_sums(spec, {1, 500});
}

TEST_CASE("fluctuation: threads, partial groups and instruction sets change no byte") {
  EnsembleSpec spec = small_ensemble(20);
  spec.response.blocks = 9;
  spec.response.samples = 8 * 11 + 3;
  const EnsembleRecord one = run_ensemble(spec, 1, nullptr);
  for (const int threads : {2, 5}) CHECK(test::same_bytes(run_ensemble(spec, threads, nullptr), one));
  for_each_instruction_set([&] { CHECK(test::same_bytes(run_ensemble(spec, 1, nullptr), one)); });
  // One sample after the other adds up to the same bytes as all together.
  EnsembleRecord record = begin_ensemble(spec);
  const auto sampler = make_sampler(spec.sampler, Lattice(spec.lattice));
  sampler->keep_layers(layers_to_keep(spec));
  const auto estimator = make_estimator(spec, {*sampler, *sampler}, record.sums, 0);
  for (std::uint64_t sample = 0; sample < 8; ++sample) REQUIRE_FALSE(estimator->measure(sample));
  for (std::uint64_t sample = 72; sample < 80; ++sample) REQUIRE_FALSE(estimator->measure(sample));
  const std::vector<double>&sums = record.sums.quantities.at("propagation").sum,
        &expected = one.sums.quantities.at("propagation").sum;
  const std::size_t of_block = sums.size() / 9;
  CHECK(std::equal(sums.begin(), sums.begin() + static_cast<std::ptrdiff_t>(of_block), expected.begin()));
}

TEST_CASE("fluctuation: bases are saturated, evenly spaced and leave room for reference, lag and bottom") {
  EnsembleSpec spec;
  spec.response.estimator = EstimatorName::fluctuation;
  spec.sampler.mu = 0.3;
  spec.lattice = {300, 400};
  for (int layer = 58; layer <= 148; layer += 3) spec.layers.push_back(layer);
  const FluctuationPlan plan = fluctuation_plan(spec);
  CHECK(plan.bases.front() == 60);
  CHECK(plan.bases[1] - plan.bases[0] == 6);
  CHECK(plan.bases.back() + plan.reference + 148 < 380);
  CHECK(plan.bases.back() + 6 + plan.reference + 148 >= 380);
  CHECK(plan.reference >= 24);
  CHECK((plan.reference + 148) % 3 == 0);  // partners fall on few layers
  CHECK(plan.layers_needed == 60 + plan.reference + 148 + 21);
  CHECK(std::is_sorted(plan.modes.rbegin(), plan.modes.rend()));  // the deeper, the fewer
  spec.lattice.layers = plan.layers_needed;
  CHECK(fluctuation_plan(spec).bases.size() == 1);
  CHECK_NOTHROW(validate(spec));
  --spec.lattice.layers;
  CHECK_THROWS_AS(validate(spec), InputError);
  spec.sampler.mu = 0.01;
  CHECK(fluctuation_plan(spec).layers_needed == 2000 + plan.reference + 148 + 21);
  // Legs that push are a matter of the deepest lag; noise that is free is the same in every layer. None looks back.
  spec.sampler.model.name = ModelName::three_leg;
  CHECK(fluctuation_plan(spec).layers_needed == 60 + plan.reference + 148 + 1);
  for (const MiddleLaw law : {MiddleLaw::positive, MiddleLaw::clipped}) {
    spec.sampler.model.three_leg.law = law;
    CHECK(fluctuation_plan(spec).layers_needed == 2 * 148 + plan.reference + 148 + 1);
  }
}

TEST_CASE("fluctuation: its keys are refused under other estimators and belong to the configuration under its own") {
  for (int key = 0; key < 3; ++key) {
    EnsembleSpec spec = small_ensemble(20), changed = spec;
    int& number = key == 0   ? changed.response.reference_lag
                  : key == 1 ? changed.response.first_base
                             : changed.response.base_step;
    number += 1;
    CHECK(configuration_text(changed) != configuration_text(spec));
    changed.response.estimator = EstimatorName::point;
    CHECK(find_problem(changed));
    changed = spec;
    number = -1;
    CHECK(find_problem(changed));
  }
  EnsembleSpec spec = small_ensemble(20);
  spec.layers = {0};
  CHECK(find_problem(spec));
  CHECK(replay_command(small_ensemble(20), 5).find("--load uniform") != std::string::npos);
}

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

TEST_CASE("the spectrum of a ring is its Fourier sum, and the inverse gives the ring back") {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const std::size_t n : {4U, 5U, 7U, 12U, 97U, 500U}) {
    std::vector<double> ring(n);
    for (double& value : ring) value = uniform(generator);
    std::vector<double> spectrum = ring;
    const RealSpectrum fourier(n);
    fourier.transform(spectrum);
    INFO("ring of " << n);
    for (std::size_t m = 0; m <= n / 2; ++m) {
      std::complex<double> sum = 0;
      for (std::size_t j = 0; j < n; ++j) {
        sum +=
            ring[j] * std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(m * j % n) / static_cast<double>(n));
      }
      CHECK(spectrum[m == 0 ? 0 : 2 * m - 1] == Approx(sum.real()).margin(1e-12 * static_cast<double>(n)));
      if (m > 0 && 2 * m < n) CHECK(spectrum[2 * m] == Approx(sum.imag()).margin(1e-12 * static_cast<double>(n)));
    }
    fourier.inverse(spectrum);
    for (std::size_t j = 0; j < n; ++j) CHECK(spectrum[j] == Approx(ring[j]).margin(1e-13));
    CHECK_THROWS_AS(fourier.transform(std::span<double>(spectrum).first(n - 1)), std::logic_error);
  }
}

}  // namespace granuscope
