// Are the stated errors errors one can bet on? Over many independent ensembles with known truth the interval of one
// standard error must cover it in 68 % of the cases, and the mean must lie within a fifth of the error from it.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/merge.h"
#include "synthetic_ensemble.h"

using namespace granuscope;

namespace {

constexpr int repetitions = 400;

/// How often the interval of one standard error covers the truth, and by how many of them the mean is off.
class Coverage {
 public:
  void add(const Estimate& estimate, double truth) {
    ++asked_;
    if (!estimate.known()) return;  // refused with a reason: a true double Gaussian is, once in a thousand times
    const double pull = (estimate.value - truth) / estimate.standard_error;
    inside_ += std::abs(pull) <= 1 ? 1 : 0;
    pull_ += pull;
    ++count_;
  }
  double share() const { return inside_ / count_; }
  double mean_pull() const { return pull_ / count_; }
  double known_share() const { return count_ / asked_; }

 private:
  double inside_ = 0, pull_ = 0, count_ = 0, asked_ = 0;
};

struct Coverages {
  Coverage c, D, position, width;

  void add(const Transport& t, double c_truth, double D_truth) {
    c.add(t.c, c_truth);
    D.add(t.D, D_truth);
  }
  void check() const {
    for (const auto& [name, coverage] :
         {std::pair{"c", &c}, {"D", &D}, {"peak position", &position}, {"width", &width}}) {
      INFO(name);
      CHECK(coverage->known_share() > 0.99);
      CHECK(coverage->share() == Approx(0.68).margin(0.05));
      CHECK(std::abs(coverage->mean_pull()) < 0.2);
    }
  }
};

FitSpec short_window(int first, int last) {
  FitSpec spec;
  spec.first_layer = spec.shallow_layer = first;
  spec.last_layer = last;
  return spec;
}

/// Real ensembles under other seeds; the truth is their sum, twenty times as precise as one of them.
void check_real(EnsembleSpec spec, const FitSpec& fit = short_window(25, 49),
                const LatticeSpec& lattice = {.columns = 120, .layers = 70}) {
  spec.lattice = lattice;
  spec.layers = layers_to_record(fit, {});
  std::vector<Transport> measured;
  MeasuredEnsemble all;
  for (int r = 0; r < repetitions; ++r) {
    spec.sampler.seed = 500 + static_cast<std::uint64_t>(r);
    MeasuredEnsemble one;
    one.overload = spec.overload;
    one.record = run_ensemble(spec, 0, nullptr);
    measured.push_back(measure_transport(one, fit, {}, 0).transport);
    if (r == 0) {
      all = one;
    } else {
      merge_into(all.record, one.record);
    }
  }
  const Transport truth = measure_transport(all, fit, {}, 0).transport;
  Coverages coverages;
  for (const Transport& t : measured) {
    coverages.add(t, truth.c.value, truth.D.value);
    for (std::size_t i = 0; i < t.depths.size(); ++i) {
      coverages.position.add(t.depths[i].peak_position, truth.depths[i].peak_position.value);
      coverages.width.add(t.depths[i].width, truth.depths[i].width.value);
    }
  }
  coverages.check();
}

}  // namespace

TEST_CASE("coverage: synthetic responses with noise that is correlated along the layer and in depth", "[long]") {
  const KnownTransport known;
  const FitSpec fit = short_window(60, 120);
  Coverages coverages;
  for (std::uint64_t seed = 1; seed <= repetitions; ++seed) {
    const SyntheticNoise noise{.per_sample = 0.5, .seed = seed, .depth_correlation = 0.5};
    const Transport t =
        measure_transport(synthetic_ensemble(known, noise, 300, layers_to_record(fit, {}), 32, 100), fit, {}, 0)
            .transport;
    coverages.add(t, known.c, known.D);
    for (const DepthFit& depth : t.depths) {
      coverages.position.add(depth.peak_position, known.position_offset + known.c * depth.z);
      coverages.width.add(depth.width, std::sqrt(known.width_offset + known.D * depth.z));
    }
  }
  coverages.check();
}

TEST_CASE("coverage: small real ensembles of the estimator multiplexed", "[long]") {
  EnsembleSpec spec;
  spec.estimator = EstimatorName::multiplexed;
  spec.sampler.mu = 0.3;
  spec.samples = 256;
  check_real(spec);
}

TEST_CASE("coverage: errors of precise ensembles, whose peaks are not quite Gaussian, are not too small", "[long]") {
  // What the fit makes of the peaks' skewness depends on the weights of the modes, which each ensemble measures by
  // itself: with weights held fixed the errors of c stated here are 1.27 times too small. The scatter of 40 ensembles
  // is known to 11 %.
  constexpr int ensembles = 40;
  EnsembleSpec spec;
  spec.estimator = EstimatorName::multiplexed;
  spec.opposite = true;
  spec.sign_run = 2;
  spec.sampler.mu = 0.3;
  spec.samples = 1024;
  spec.lattice = {300, 140};
  FitSpec fit = short_window(41, 119);
  fit.layer_step = 3;
  spec.layers = layers_to_record(fit, {});
  std::vector<Estimate> c, D;
  for (int r = 0; r < ensembles; ++r) {
    spec.sampler.seed = 70'000 + static_cast<std::uint64_t>(r);
    MeasuredEnsemble one;
    one.overload = spec.overload;
    one.record = run_ensemble(spec, 0, nullptr);
    const Transport t = measure_transport(one, fit, {}, 0).transport;
    c.push_back(t.c);
    D.push_back(t.D);
  }
  for (const auto& [name, all] : {std::pair{"c", &c}, {"D", &D}}) {
    double mean = 0, squares = 0, stated = 0;
    for (const Estimate& e : *all) mean += e.value / ensembles;
    for (const Estimate& e : *all) {
      squares += (e.value - mean) * (e.value - mean) / (ensembles - 1);
      stated += e.standard_error * e.standard_error / ensembles;
    }
    CAPTURE(name, std::sqrt(squares / stated));
    CHECK(squares < 1.2 * 1.2 * stated);
    CHECK(squares > 0.3 * 0.3 * stated);
  }
}

TEST_CASE("coverage: small real ensembles of the estimator point", "[long]") {
  EnsembleSpec spec;
  spec.sampler.mu = 0.3;
  spec.samples = 2048;
  check_real(spec);
}
