// Are the stated errors errors one can bet on? Over many independent ensembles with known truth the interval of one
// standard error must cover it as often as Student's t says, and the mean must lie within a fifth of the error from it.
// page_coverage_test.cc asks it of every number of the page.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/precision.h"
#include "analysis/synthetic_ensemble.h"
#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"

using namespace granuscope;

namespace {

constexpr int repetitions = 400;
/// Student's t with 31 degrees of freedom, which 32 blocks leave.
constexpr double share_in_one_error = 0.675;

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
      CHECK(coverage->share() == Approx(share_in_one_error).margin(0.05));
      CHECK(std::abs(coverage->mean_pull()) < 0.2);
    }
  }
};

/// Numbers under other seeds: how far they scatter, and what they say about it.
class Spread {
 public:
  explicit Spread(double truth) : truth_(truth) {}

  void add(const Estimate& estimate) {
    REQUIRE(estimate.known());
    all_.push_back(estimate);
  }
  double scatter() const {
    double mean = 0, squares = 0;
    for (const Estimate& e : all_) mean += e.value / count();
    for (const Estimate& e : all_) squares += std::pow(e.value - mean, 2) / (count() - 1);
    return std::sqrt(squares);
  }
  double stated() const {
    double squares = 0;
    for (const Estimate& e : all_) squares += e.standard_error * e.standard_error / count();
    return std::sqrt(squares);
  }
  double count() const { return static_cast<double>(all_.size()); }
  /// Within one stated error of their mean.
  double share() const {
    double mean = 0, inside = 0;
    for (const Estimate& e : all_) mean += e.value / count();
    for (const Estimate& e : all_) inside += std::abs(e.value - mean) <= e.standard_error ? 1 : 0;
    return inside / count();
  }
  double mean_pull() const {
    double sum = 0;
    for (const Estimate& e : all_) sum += (e.value - truth_) / e.standard_error / count();
    return sum;
  }

 private:
  double truth_;
  std::vector<Estimate> all_;
};

FitSpec short_window(int first, int last) {
  FitSpec spec;
  spec.first_layer = spec.shallow_layer = first;
  spec.last_layer = last;
  return spec;
}

/// One ensemble that has all blocks of `parts`, so that it knows their noise better than any of them.
MeasuredEnsemble side_by_side(const std::vector<MeasuredEnsemble>& parts) {
  MeasuredEnsemble all = parts.front();
  BlockSums& sums = all.record.sums;
  for (std::size_t p = 1; p < parts.size(); ++p) {
    const BlockSums& more = parts[p].record.sums;
    sums.count.insert(sums.count.end(), more.count.begin(), more.count.end());
    for (auto& [name, quantity] : sums.quantities) {
      const QuantitySums& other = more.quantities.at(name);
      quantity.sum.insert(quantity.sum.end(), other.sum.begin(), other.sum.end());
      quantity.sum_of_squares.insert(quantity.sum_of_squares.end(), other.sum_of_squares.begin(),
                                     other.sum_of_squares.end());
    }
  }
  return all;
}

/// The same piles in fewer blocks, a divisor of those there are.
MeasuredEnsemble in_blocks(MeasuredEnsemble ensemble, int blocks) {
  BlockSums& sums = ensemble.record.sums;
  const auto whole = static_cast<std::size_t>(blocks), each = sums.count.size() / whole;
  const auto joined = [&](const auto& values) {
    auto result = values;
    const std::size_t size = values.size() / (whole * each);
    result.assign(whole * size, 0);
    for (std::size_t b = 0; b < whole * each; ++b) {
      for (std::size_t i = 0; i < size; ++i) result[b / each * size + i] += values[b * size + i];
    }
    return result;
  };
  for (auto& [name, quantity] : sums.quantities) {
    quantity.sum = joined(quantity.sum);
    quantity.sum_of_squares = joined(quantity.sum_of_squares);
  }
  sums.count = joined(sums.count);
  return ensemble;
}

}  // namespace

TEST_CASE("coverage: synthetic responses with noise that is correlated along the layer and in depth", "[long]") {
  const KnownTransport known;
  const FitSpec fit = short_window(60, 120);
  Coverages coverages;
  Spread noise_exponent(-0.5);
  for (std::uint64_t seed = 1; seed <= repetitions; ++seed) {
    const SyntheticNoise noise{.per_sample = 0.5, .seed = seed, .depth_correlation = 0.5};
    const Transport t =
        measure_transport(synthetic_ensemble(known, noise, 300, layers_to_record(fit, {}), 32, 100), fit, {}, 0)
            .transport;
    coverages.add(t, known.c, known.D);
    noise_exponent.add(t.exponents.noise);
    for (const DepthFit& depth : t.depths) {
      coverages.position.add(depth.peak_position, known.position_offset + known.c * depth.z);
      coverages.width.add(depth.width, std::sqrt(known.width_offset + known.D * depth.z));
    }
  }
  coverages.check();
  // The scatter of 400 is known to 3.5 %. It was 0.55 of what was stated before mean_response.cc minded that a
  // jackknife doubles the variance of a squared mean, and counted as many sub-ensembles without a block as with it.
  CAPTURE(noise_exponent.scatter(), noise_exponent.stated());
  CHECK(noise_exponent.scatter() == Approx(noise_exponent.stated()).epsilon(0.15));
}

TEST_CASE("coverage: errors and values of precise ensembles, whose peaks are not quite Gaussian", "[long]") {
  // What the fit makes of the peaks' skewness depends on the weights of the modes. With weights from the noise of each
  // depth these ensembles in 8 blocks stated errors of c 1.7 times too large, and c scattered 1.4 times as much as in
  // 32; weights that do not look at the noise do neither. The scatter of 40 ensembles is known to 11 %.
  constexpr int ensembles = 40;
  EnsembleSpec spec;
  spec.response.estimator = EstimatorName::multiplexed;
  spec.response.opposite = true;
  spec.response.sign_run = 2;
  spec.sampler.mu = 0.3;
  spec.response.samples = 1024;
  spec.lattice = {200, 140};
  FitSpec fit = short_window(41, 119);
  fit.layer_step = 3;
  spec.layers = layers_to_record(fit, {});
  std::vector<MeasuredEnsemble> all;
  for (int r = 0; r < ensembles; ++r) {
    spec.sampler.seed = 70'000 + static_cast<std::uint64_t>(r);
    all.push_back({spec, run_ensemble(spec, 0, nullptr)});
  }
  const Transport truth = measure_transport(side_by_side(all), fit, {}, 0).transport;
  double scatter_of_c_in_32 = 0;
  for (const int blocks : {32, min_blocks}) {
    Spread c(truth.c.value), D(truth.D.value);
    std::vector<Spread> positions;
    for (const DepthFit& depth : truth.depths) positions.emplace_back(depth.peak_position.value);
    for (const MeasuredEnsemble& one : all) {
      const Transport t = measure_transport(in_blocks(one, blocks), fit, {}, 0).transport;
      c.add(t.c);
      D.add(t.D);
      for (std::size_t i = 0; i < positions.size(); ++i) positions[i].add(t.depths[i].peak_position);
    }
    for (const auto& [name, spread] : {std::pair{"c", &c}, {"D", &D}}) {
      CAPTURE(blocks, name, spread->scatter(), spread->scatter() / spread->stated(), spread->mean_pull());
      CHECK(spread->scatter() < 1.25 * spread->stated());
      CHECK(spread->scatter() > 0.75 * spread->stated());
      CHECK(std::abs(spread->mean_pull()) < 0.2);
    }
    double pull = 0;
    for (const Spread& position : positions) pull += position.mean_pull() / static_cast<double>(positions.size());
    CAPTURE(blocks, pull);
    CHECK(std::abs(pull) < 0.15);
    if (blocks == 32) scatter_of_c_in_32 = c.scatter();
    // The blocks say how large an error is, not what the value is: the piles are the same.
    CHECK(c.scatter() < 1.15 * scatter_of_c_in_32);
  }
}

TEST_CASE("coverage: small real ensembles that grow until D is as precise as asked", "[long]") {
  constexpr int ensembles = 120;
  const FitSpec fit = short_window(25, 49);
  EnsembleSpec spec;
  spec.response = multiplexed_response(0.25, true);
  spec.sampler.mu = 0.3;
  spec.lattice = {120, 70};
  spec.layers = layers_to_record(fit, {});
  PrecisionSpec asked;
  std::vector<Transport> stopped;
  MeasuredEnsemble all;
  for (std::uint64_t r = 0; r <= ensembles; ++r) {
    spec.sampler.seed = 6000 + r;
    MeasuredEnsemble one;
    Transport measured;
    std::uint64_t rounds = 1;
    for (;; rounds = next_size(rounds)) {
      spec.response.samples = rounds * group_size * static_cast<std::uint64_t>(spec.response.blocks);
      one = {spec, run_ensemble(spec, 0, nullptr)};
      measured = measure_transport(one, fit, {}, 0).transport;
      // The first ensemble tells what to ask of the others: two or three times as many piles.
      if (r == 0) asked.D = 0.65 * measured.D.standard_error;
      if (r == 0 || look_at_precision(asked, measured, spec.response.samples).reached) break;
    }
    if (r == 0) continue;
    if (r == 1) {
      all = one;
    } else {
      merge_into(all.record, one.record);
    }
    one.record.sums.scatter = stopped_scatter(spec.response.blocks);
    stopped.push_back(measure_transport(one, fit, {}, 0).transport);
    CHECK(stopped.back().D.value == Approx(measured.D.value));
    CHECK(stopped.back().D.standard_error <= 1.01 * asked.D);
  }
  const Transport truth = measure_transport(all, fit, {}, 0).transport;
  for (const auto number : {&Transport::c, &Transport::D}) {
    Coverage coverage;
    Spread spread((truth.*number).value);
    for (const Transport& t : stopped) {
      coverage.add(t.*number, (truth.*number).value);
      spread.add(t.*number);
    }
    CAPTURE(coverage.share(), coverage.mean_pull(), spread.scatter() / spread.stated());
    // 120 ensembles: 4.3 % of coverage, 0.09 of a mean, 6.5 % of a scatter; three of each. (200 of them once: 73 and
    // 72.5 % within one error of c and D, which scattered by 1.01 and 0.95 of what was stated.)
    CHECK(coverage.share() == Approx(share_in_one_error).margin(0.13));
    CHECK(std::abs(coverage.mean_pull()) < 0.27);
    CHECK(spread.scatter() == Approx(spread.stated()).epsilon(0.2));
  }
}
