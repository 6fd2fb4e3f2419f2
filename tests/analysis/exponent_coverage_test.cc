// Errors one can bet on, of the numbers that come last: exponents of mu and D, from real ensembles under other seeds.
// The truth is what all of them together give. (400 times 256 piles of 500 x 200 beads at mu = 0.1, 0.2 and 0.3 once:
// beta 70, gamma 73, alpha 70(2) % within one error, where Student's t has 67.5 %, and 96, 95, 95(1) % within two.)
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "analysis/scaling.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/merge.h"

using namespace granuscope;

namespace {

constexpr int ensembles = 60;
constexpr std::array friction{0.15, 0.2, 0.3, 0.4};
constexpr std::array window{0.15, 0.4};

struct Pulls {
  std::string name;
  double sum = 0, squares = 0, count = 0;

  void add(const Estimate& estimate, double truth) {
    REQUIRE(estimate.known());
    const double pull = (estimate.value - truth) / estimate.standard_error;
    sum += pull;
    squares += pull * pull;
    ++count;
  }
};

EnsembleSpec spec_at(double mu, std::uint64_t seed) {
  EnsembleSpec spec;
  spec.response = multiplexed_response(0.25, true);
  spec.response.samples = 256;
  spec.sampler.mu = mu;
  spec.sampler.seed = seed;
  spec.lattice = {160, 100};
  return spec;
}

}  // namespace

TEST_CASE("coverage: exponents of friction and of the number of piles", "[long]") {
  FitSpec fit;
  fit.first_layer = fit.shallow_layer = 35;
  fit.last_layer = 79;
  fit.layer_step = 4;
  std::vector<std::vector<MeasuredTransport>> measured(ensembles);
  std::vector<MeasuredTransport> together;
  for (const double mu : friction) {
    MeasuredEnsemble all;
    for (int r = 0; r < ensembles; ++r) {
      EnsembleSpec spec = spec_at(mu, 9'000 + static_cast<std::uint64_t>(r));
      spec.layers = layers_to_record(fit, {});
      const MeasuredEnsemble one{spec, run_ensemble(spec, 0, nullptr)};
      measured[static_cast<std::size_t>(r)].push_back(measure_transport(one, fit, {}, 0));
      if (r == 0) {
        all = one;
      } else {
        merge_into(all.record, one.record);
      }
    }
    together.push_back(measure_transport(all, fit, {}, 0));
  }
  const ScalingFits truth = fit_scaling(together, window);
  Pulls beta{"beta"}, gamma{"gamma"}, alpha{"alpha"}, c{"c"}, D{"D"};
  for (const std::vector<MeasuredTransport>& one : measured) {
    const ScalingFits fits = fit_scaling(one, window);
    beta.add(fits.beta.exponent, truth.beta.exponent.value);
    gamma.add(fits.gamma.exponent, truth.gamma.exponent.value);
    alpha.add(fits.alpha.exponent, truth.alpha.exponent.value);
    for (std::size_t i = 0; i < one.size(); ++i) {
      c.add(one[i].transport.c, together[i].transport.c.value);
      D.add(one[i].transport.D, together[i].transport.D.value);
    }
  }
  for (const Pulls* one : {&beta, &gamma, &alpha, &c, &D}) {
    // Of 60 pulls the mean is known to 0.13 and the spread to 9 %; the truth has their noise, an eighth of an error.
    const double mean = one->sum / one->count, spread = std::sqrt(one->squares / one->count - mean * mean);
    CAPTURE(one->name, mean, spread);
    CHECK(std::abs(mean) < 0.4);
    CHECK(spread == Approx(1).margin(0.28));
  }
}
