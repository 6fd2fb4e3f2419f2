// How forces are distributed: the counts, held against closed forms, a recursion and a second implementation.
#include "ensemble/estimator.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>

#include "ensemble/ensemble_runner.h"
#include "ensemble/small_ensemble.h"
#include "model/equilibrium.h"
#include "sampling/sampler.h"
#include "support/error.h"

namespace granuscope {
namespace {

EnsembleSpec counted(double mu, LatticeSpec lattice, std::uint64_t samples) {
  EnsembleSpec spec;
  spec.sampler.mu = mu;
  spec.sampler.seed = 11;
  spec.lattice = lattice;
  spec.load = Load::uniform;
  spec.response.samples = samples;
  spec.response.blocks = 32;
  spec.record_profiles = false;
  spec.record_forces = true;
  return spec;
}

/// Per bead or contact of a recorded layer, with the standard error of the blocks.
struct Mean {
  double value = 0, error = 0;
};

Mean moment(const EnsembleRecord& record, std::size_t row, ForceMoment which, double per_pile) {
  const LayerSums sums = record.sums.layer("force_moments", row);
  double sum = 0, squares = 0;
  const auto blocks = static_cast<double>(sums.blocks());
  for (std::size_t b = 0; b < sums.blocks(); ++b) {
    const double mean = sums.block(b)[static_cast<int>(which)] / (per_pile * static_cast<double>(record.sums.count[b]));
    sum += mean;
    squares += mean * mean;
  }
  const double mean = sum / blocks;
  return {mean, std::sqrt(std::max(0.0, squares / blocks - mean * mean) / (blocks - 1))};
}

/// All blocks together.
std::vector<double> counts_of(const EnsembleRecord& record, std::size_t row, std::size_t first, std::size_t bins) {
  const LayerSums sums = record.sums.layer("force_counts", row);
  std::vector<double> counts(bins);
  for (std::size_t b = 0; b < sums.blocks(); ++b) {
    for (std::size_t i = 0; i < counts.size(); ++i) counts[i] += sums.block(b)[first + i];
  }
  return counts;
}

constexpr double sigmas = 5;

}  // namespace

TEST_CASE("forces of the top layers are those of uniform splits, in closed form") {
  const EnsembleSpec spec = counted(0.1, {16, 3}, 8192);
  const EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  const FrictionCone cone(0.1);
  const double spread = cone.t_plus() - cone.t_minus();
  // Layer 0: H is uniform on [t-, t+]/2, alike on both contacts of a bead; |T|/(mu N) is its angle from the contact.
  const Mean N = moment(record, 0, ForceMoment::N, 2 * 16), tangential = moment(record, 0, ForceMoment::tangential, 32);
  CHECK(N.value + tan30 == Approx((cone.t_plus() + cone.t_minus() + 2 * sqrt3) / 8).margin(sigmas * N.error));
  CHECK(N.error < 2e-4);
  CHECK(tangential.value > 0);
  const auto counts = counts_of(record, 0, force_bins::mobilisation, force_bins::mobilisations + 2);
  const double beads = 8192 * 16;
  const auto below = [&](double m) {
    return (std::tan(std::atan(tan30) + std::atan(0.1 * m)) - cone.t_minus()) / spread;
  };
  CHECK(counts.front() == 0);
  CHECK(counts.back() == 0);
  double chi2 = 0;
  for (std::size_t i = 0; i < force_bins::mobilisations; ++i) {
    const double low = 2 * static_cast<double>(i) / force_bins::mobilisations - 1,
                 high = low + 2.0 / force_bins::mobilisations;
    const double expected = beads * (below(high) - below(low)), found = counts[i + 1] / 2;
    chi2 += std::pow(found - expected, 2) / expected;
  }
  const double degrees = force_bins::mobilisations - 1;
  CHECK(std::abs(chi2 - degrees) < sigmas * std::sqrt(2 * degrees));
  // Layer 2: w - 1 = sqrt 3 (h1 - 2 h2 + h3) of three splits h.
  const Mean variance = moment(record, 2, ForceMoment::w_2, 16), third = moment(record, 2, ForceMoment::w_3, 16);
  CHECK(std::abs(variance.value - 3 * spread * spread / 8) < sigmas * variance.error);
  CHECK(variance.error < 0.01 * variance.value);
  CHECK(std::abs(third.value) < sigmas * third.error);
}

TEST_CASE("without friction every contact bears the same normal force and nothing else") {
  EnsembleSpec spec = counted(0, {8, 12}, 256);
  spec.layers = {0, 11};
  const EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  for (const std::size_t row : {0U, 1U}) {
    CHECK(moment(record, row, ForceMoment::tangential, 1).value < 1e-13);
    CHECK(moment(record, row, ForceMoment::mobilisation, 1).value == 0);
    CHECK(moment(record, row, ForceMoment::w_2, 1).value < 1e-25);
    const auto N = counts_of(record, row, force_bins::normal, force_bins::values);
    CHECK(N[static_cast<std::size_t>(tan30 * force_bins::per_unit)] == 256 * 8 * 2);
    CHECK(std::accumulate(N.begin(), N.end(), 0.0) == 256 * 8 * 2);
  }
}

namespace {

/// <w_0 w_x> of the q-model with uniform shares on a ring, `rows` below w = 1. Each bead hands q to the left, 1 - q to
/// the right: <q^2> = 1/3, <q (1 - q)> = 1/6, and 1/4 for the shares of two beads.
std::vector<double> q_model_correlation(std::size_t columns, int rows) {
  std::vector<double> correlation(columns, 1);
  for (int n = 0; n < rows; ++n) {
    std::vector<double> next(columns);
    for (std::size_t x = 0; x < columns; ++x) {
      const std::size_t before = (x + columns - 1) % columns, after = (x + 1) % columns;
      next[x] = 2 * (x == 0 ? 1.0 / 3 : 0.25) * correlation[x] + (before == 0 ? 1.0 / 6 : 0.25) * correlation[before] +
                (after == 0 ? 1.0 / 6 : 0.25) * correlation[after];
    }
    correlation = std::move(next);
  }
  return correlation;
}

}  // namespace

TEST_CASE("the q-model has the variance of its recursion in each layer, and comes to P(w) = 4 w exp(-2 w)") {
  // The variance reaches 1/2 as the root of the layer (Coppersmith et al. 1996).
  const auto missing = [](int rows) { return 1.5 - q_model_correlation(512, rows)[0]; };
  CHECK(missing(100) / missing(400) == Approx(2).epsilon(0.03));
  EnsembleSpec spec = counted(0.1, {128, 401}, 512);
  spec.sampler.model.name = ModelName::q_model;
  spec.layers = {1, 2, 10, 400};
  const EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  for (std::size_t row = 0; row < 4; ++row) {
    const Mean mean = moment(record, row, ForceMoment::w, 128), variance = moment(record, row, ForceMoment::w_2, 128);
    CHECK(std::abs(mean.value) < 1e-13);
    CAPTURE(row);
    CHECK(std::abs(variance.value - (q_model_correlation(128, spec.layers[row])[0] - 1)) < sigmas * variance.error);
    CHECK(variance.error < 0.02 * variance.value);
  }
  const auto counts = counts_of(record, 3, force_bins::weight, force_bins::values);
  double below = 0, farthest = 0;
  for (std::size_t i = 0; i + 1 < counts.size(); ++i) {
    below += counts[i] / (512 * 128);
    const double w = (static_cast<double>(i) + 1) / force_bins::per_unit;
    farthest = std::max(farthest, std::abs(below - (1 - (1 + 2 * w) * std::exp(-2 * w))));
  }
  CHECK(farthest < 0.015);  // 1/2 - variance is still 0.02
}

TEST_CASE("piles drawn side by side are counted as single ones are, in pieces and by any number of threads") {
  EnsembleSpec spec = counted(0.3, {12, 30}, 512);
  spec.layers = {3, 9, 29};
  const EnsembleRecord record = run_ensemble(spec, 1, nullptr);
  CHECK(test::same_bytes(record, run_ensemble(spec, 3, nullptr)));
  EnsembleRecord pieces = begin_ensemble(spec);
  add_groups(spec, 0, 20, pieces, 2, nullptr);
  add_groups(spec, 20, groups_of(spec), pieces, 2, nullptr);
  CHECK(test::same_bytes(record, pieces));
  BlockSums alone = zero_sums(record.sums, 0, 1);
  const ForceCounts counts(spec, alone, 0);
  const Lattice lattice(spec.lattice);
  const auto sampler = make_sampler(spec.sampler, lattice);
  const std::vector<double> load(12, 1.0);
  for (std::uint64_t sample = 0; sample < 512; ++sample) {
    Pile pile(lattice);
    const std::optional<SamplingFailure> failure = sampler->draw(sample, load, pile);
    const std::span<const double> of_pile = pile.load;
    counts.add(group_of(pile, of_pile), {&failure, 1});
  }
  for (std::size_t row = 0; row < 3; ++row) {
    const auto found = counts_of(record, row, 0, force_bins::width);
    const double* const expected = alone.layer("force_counts", row).block(0);
    CHECK(std::equal(found.begin(), found.end(), expected));
    CHECK(std::accumulate(found.begin(), found.end(), 0.0) == 512 * 12 * (1 + 3 * 2));
    CHECK(std::abs(moment(record, row, ForceMoment::w, 12).value) < 1e-13);
  }
  spec.load = Load::point;
  CHECK_THROWS_AS(validate(spec), InputError);
}

TEST_CASE("the law rejection has the forces of piles that are drawn bead by bead and thrown away where one fails") {
  EnsembleSpec spec = counted(0.3, {4, 4}, 8192);
  spec.sampler.law = Law::rejection;
  spec.layers = {3};
  const EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  const FrictionCone cone(0.3);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> number;
  Pile pile{Lattice(spec.lattice)};
  const auto completed = [&] {
    for (int layer = 0; layer < 4; ++layer) {
      for (int bead = 0; bead < 4; ++bead) {
        const Incoming in = incoming(pile, layer, bead);
        const Outgoing out = balance(cone, in);
        const Interval interval = split_interval(cone, out, in.H);
        if (out.V_R < 0 || out.V_L < 0 || interval.empty()) return false;
        const std::size_t at = pile.lattice.index(layer, bead);
        pile.V_R[at] = out.V_R, pile.V_L[at] = out.V_L;
        pile.H_R[at] = point_at(interval, number(random)), pile.H_L[at] = in.H - pile.H_R[at];
      }
    }
    return true;
  };
  std::array<double, 4> sum{}, squares{};
  constexpr int piles = 20'000;
  for (int n = 0; n < piles;) {
    if (!completed()) continue;
    ++n;
    std::array<double, 4> of_pile{};
    for (std::size_t at = pile.lattice.index(3, 0); at < pile.lattice.beads(); ++at) {
      for (const auto& [V, H] : {std::pair{pile.V_R[at], pile.H_R[at]}, std::pair{pile.V_L[at], -pile.H_L[at]}}) {
        const double N = H / 2 + sqrt3 / 2 * V, T = sqrt3 / 2 * H - V / 2;
        of_pile[0] += N - tan30;
        of_pile[1] += std::pow(N - tan30, 2);
        of_pile[2] += std::abs(T) / (0.3 * N);
      }
      of_pile[3] += std::pow(pile.V_R[at] + pile.V_L[at] - 1, 2);
    }
    for (std::size_t k = 0; k < 4; ++k) sum[k] += of_pile[k], squares[k] += of_pile[k] * of_pile[k];
  }
  const std::array which{ForceMoment::N, ForceMoment::N_2, ForceMoment::mobilisation, ForceMoment::w_2};
  for (std::size_t k = 0; k < 4; ++k) {
    const Mean found = moment(record, 0, which[k], 1);
    const double expected = sum[k] / piles, error = std::sqrt((squares[k] / piles - expected * expected) / piles);
    CAPTURE(k, found.value, expected);
    CHECK(std::abs(found.value - expected) < sigmas * std::hypot(found.error, error));
    CHECK(found.error < 0.05 * std::abs(expected) + 1e-3);
  }
}

}  // namespace granuscope
