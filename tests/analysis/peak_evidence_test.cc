// One peak or two: what cosines leave open sines tell, and only where there is something to tell.
#include "analysis/shape_diagnostics.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace granuscope;

namespace {

constexpr int columns = 24, modes = 6, blocks = 32;

/// The modes of `truth` and as many sines, each with Gaussian noise of this size that 32 blocks tell.
LayerSpectrum noisy_spectrum(DoubleGaussian truth, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> of_block(0, noise * std::sqrt(blocks));
  std::vector<ModeValue> cosines(modes), sines(modes);
  fourier_modes(truth, columns, false, cosines, sines);
  const auto means_of = [&](const std::vector<ModeValue>& values) {
    BlockMeans means{{}, std::vector<std::vector<double>>(blocks)};
    for (const ModeValue& mode : values) {
      std::vector<double> parts(blocks);
      double sum = 0;
      for (double& part : parts) sum += part = mode.value + of_block(random);
      means.whole.push_back(sum / blocks);
      for (int b = 0; b < blocks; ++b) {
        const auto block = static_cast<std::size_t>(b);
        means.without_block[block].push_back((sum - parts[block]) / (blocks - 1));
      }
    }
    return means;
  };
  LayerSpectrum spectrum;
  spectrum.columns = columns;
  const BlockMeans of_cosines = means_of(cosines);
  spectrum.whole = of_cosines.whole;
  spectrum.without_block = of_cosines.without_block;
  spectrum.noise.assign(modes, noise);
  spectrum.sines = means_of(sines);
  return spectrum;
}

struct Verdict {
  PeakEvidence evidence;
  std::string reason;
};
Verdict judge(const LayerSpectrum& spectrum) {
  const auto best = fit_shape(spectrum, coarse_shape(spectrum, 14));
  REQUIRE(best);
  const PeakEvidence evidence = weigh_peaks(spectrum, *best);
  return {evidence, reason_against_identification(*best, evidence, FitSpec{})};
}

}  // namespace

TEST_CASE("sines tell that a peak has moved, however wide it is and wherever on the ring") {
  // Merged; beyond the far side of the ring, where its mirror image comes from the other way; clear of each other.
  for (const DoubleGaussian truth : {DoubleGaussian{4, 6}, {2, 5}, {16, 5}, {7, 2}}) {
    LayerSpectrum spectrum = noisy_spectrum(truth, 0.01, 1);
    CAPTURE(truth.peak, truth.width);
    const Verdict by_both = judge(spectrum);
    CHECK(by_both.evidence.for_moved_peak > 25);
    CHECK(by_both.reason.empty());
    const bool merged = truth.peak < truth.width;
    spectrum.sines = {};
    const Verdict by_cosines = judge(spectrum);
    CHECK(std::isnan(by_cosines.evidence.for_moved_peak));
    CHECK(by_cosines.evidence.for_two_peaks == by_both.evidence.for_two_peaks);
    CHECK(by_cosines.reason.empty() == !merged);
  }
}

TEST_CASE("a peak in the middle is called moved as seldom as its noise is two standard errors large") {
  int moved = 0;
  constexpr int times = 400;
  for (int seed = 1; seed <= times; ++seed) {
    const Verdict verdict = judge(noisy_spectrum({0, 4}, 0.05, static_cast<unsigned>(seed)));
    CHECK(verdict.evidence.for_moved_peak > -1e-9);
    moved += verdict.evidence.for_moved_peak > least_evidence_for_two_peaks ? 1 : 0;
  }
  CAPTURE(moved);
  CHECK(moved < 40);
}
