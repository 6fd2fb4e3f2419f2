// Transport coefficients from ensembles of every estimator.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "analysis/claims.h"
#include "analysis/mean_response.h"
#include "analysis/scaling.h"
#include "analysis/shape_fit.h"
#include "analysis/synthetic_ensemble.h"
#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"
#include "kit/linear_response.h"
#include "kit/same_bytes.h"
#include "kit/temporary_folder.h"
#include "model/lattice.h"
#include "sampling/simple_laws.h"
#include "storage/ensemble_file.h"
#include "support/error.h"

namespace granuscope {
namespace {

using test::same_bytes;
using test::TemporaryFolder;

}  // namespace

namespace {

constexpr int made_up_columns = 300;

FitSpec shallow_window() {
  return {.first_layer = 60, .last_layer = 120, .layer_step = 5, .shallow_layer = 40, .other_scaling_windows = {}};
}

Transport measure_shallow(const MeasuredEnsemble& ensemble, int threads = 2) {
  return measure_transport(ensemble, shallow_window(), {60, 120}, threads).transport;
}

/// All block sums and counts twice, as if every sample had entered its block twice.
MeasuredEnsemble doubled(MeasuredEnsemble ensemble) {
  for (auto& count : ensemble.record.sums.count) count *= 2;
  for (auto& [name, quantity] : ensemble.record.sums.quantities) {
    for (double& sum : quantity.sum) sum *= 2;
    for (double& sum : quantity.sum_of_squares) sum *= 2;
  }
  return ensemble;
}

/// The pile without friction as an ensemble: every block the same exact sums.
MeasuredEnsemble frictionless_ensemble(const std::vector<int>& layers, double overload) {
  Pile pile(Lattice({made_up_columns, layers.back() + 1}));
  pile.load[static_cast<std::size_t>(made_up_columns / 2)] += overload;
  fill_frictionless(std::vector<double>(pile.load), pile);
  MeasuredEnsemble ensemble;
  ensemble.spec.response.overload = overload;
  BlockSums& sums = ensemble.record.sums;
  sums.layers = layers;
  sums.count.assign(8, 8);
  auto& weight = sums.quantities["weight"];
  auto& thrust = sums.quantities["thrust"];
  weight.width = made_up_columns;
  for (int block = 0; block < 8; ++block) {
    for (int layer : layers) {
      double total_thrust = 0;
      for (int i = 0; i < made_up_columns; ++i) {
        const std::size_t at = pile.lattice.index(layer, i);
        weight.sum.push_back(8 * (pile.V_R[at] + pile.V_L[at]));
        total_thrust += sqrt3 * (pile.H_R[at] - pile.H_L[at]);
      }
      thrust.sum.push_back(8 * total_thrust / (made_up_columns + overload));
    }
  }
  return ensemble;
}

}  // namespace

TEST_CASE("layers to record hold the window, alternate parities and the figures' layers") {
  const std::vector<int> layers = layers_to_record(shallow_window(), {61, 80, 119});
  CHECK(std::is_sorted(layers.begin(), layers.end()));
  for (int layer : {60, 61, 65, 80, 119, 120, 40}) CHECK(std::count(layers.begin(), layers.end(), layer) == 1);
}

TEST_CASE("a noiseless response gives back its c and D") {
  const KnownTransport known;
  const Transport t = measure_shallow(
      synthetic_ensemble(known, {1e-7, 1}, made_up_columns, layers_to_record(shallow_window(), {}), 32, 100));
  CHECK(t.c.value == Approx(known.c).margin(1e-7));
  CHECK(t.D.value == Approx(known.D).margin(1e-6));
  CHECK(t.position_offset.value == Approx(known.position_offset).margin(1e-5));
  CHECK(t.width_offset.value == Approx(known.width_offset).margin(1e-5));
  CHECK(t.c_thrust.value == Approx(tan30 * std::sqrt(known.alpha_thrust)).margin(1e-8));
  CHECK(t.window_layers[0] == 60);
  CHECK(t.window_layers[1] == 120);
  CHECK_FALSE(t.exact);
}

TEST_CASE("at another angle of the contacts the same peaks are read in bead diameters, and claims stay open") {
  MeasuredEnsemble ensemble =
      synthetic_ensemble({}, {1e-7, 1}, made_up_columns, layers_to_record(shallow_window(), {}), 32, 100);
  const Transport usual = measure_shallow(ensemble);
  for (const double angle : {20.0, 45.0, 60.0}) {
    CAPTURE(angle);
    const BeadGeometry geometry(angle);
    ensemble.spec.lattice.angle = angle;
    ensemble.record.sums.rows = rows_of({}, angle);
    const Transport t = measure_shallow(ensemble);
    // From columns and layers of 30 degrees to those of another lattice.
    const double across = geometry.twice_sine, down = geometry.twice_cosine / sqrt3;
    CHECK(t.c0() == Approx(geometry.tangent));
    CHECK(t.c.value == Approx(usual.c.value * across / down).margin(1e-7));
    CHECK(t.D.value == Approx(usual.D.value * across * across / down).margin(1e-6));
    CHECK(t.c_thrust.value / t.c0() == Approx(usual.c_thrust.value / tan30));
    REQUIRE(t.profiles.size() == usual.profiles.size());
    for (std::size_t i = 0; i < t.profiles[1].x.size(); ++i) {
      REQUIRE(t.profiles[1].x[i] == Approx(across * usual.profiles[1].x[i]));
      REQUIRE(t.profiles[1].pressure[i] == Approx(usual.profiles[1].pressure[i] / across));
      REQUIRE(t.profiles[1].fit[i] == Approx(usual.profiles[1].fit[i] / across).margin(1e-7));
    }
    Analysis analysis;
    analysis.results = {t};
    for (const Claim& claim : judge_claims(analysis, {}, {})) CHECK(claim.verdict == not_tested);
  }
  // Nor are claims about beads whose loads lean, act beside the centres or are not the only ones.
  for (double SamplerSpec::*unusual :
       {&SamplerSpec::load_angle, &SamplerSpec::load_offset, &SamplerSpec::bead_weight}) {
    Analysis analysis;
    analysis.results = {usual};
    analysis.results[0].spec.sampler.*unusual = 0.1;
    for (const Claim& claim : judge_claims(analysis, {}, {})) CHECK(claim.verdict == not_tested);
  }
}

TEST_CASE("on a ring just wide enough no image of a peak is taken for it") {
  // The two peaks at the deepest layer are 0.577 z on either side, so that 2 c z + 8 W = 143 columns are needed.
  KnownTransport known;
  for (const int narrow : {150, 180, 210}) {
    const MeasuredEnsemble ensemble =
        synthetic_ensemble(known, {}, narrow, layers_to_record(shallow_window(), {}), 16, 256);
    const MeasuredTransport measured = measure_transport(ensemble, shallow_window(), {}, 1);
    INFO(narrow);
    CHECK(std::abs(measured.transport.c.value - known.c) < 5 * measured.transport.c.standard_error);
    for (const DepthFit& depth : measured.transport.depths) CHECK(depth.peak_position.value < 0.5 * narrow);
  }
}

TEST_CASE("layers recorded for a figure change no number") {
  const auto window = layers_to_record(shallow_window(), {}), more = layers_to_record(shallow_window(), {61, 88, 119});
  const MeasuredEnsemble with_figures = synthetic_ensemble({}, {0.5, 3}, made_up_columns, more, 32, 100);
  MeasuredEnsemble without = with_figures;
  BlockSums& sums = without.record.sums;
  sums.layers = window;
  for (auto& [name, quantity] : sums.quantities) {
    const auto& all = with_figures.record.sums.quantities.at(name);
    const auto width = static_cast<std::size_t>(all.width);
    const auto keep = [&](const std::vector<double>& from) {
      std::vector<double> kept;
      for (std::size_t at = 0; at < from.size(); at += width) {
        const int layer = more[at / width % more.size()];
        if (!std::binary_search(window.begin(), window.end(), layer)) continue;
        for (std::size_t i = 0; i < width; ++i) kept.push_back(from[at + i]);
      }
      return kept;
    };
    quantity.sum = keep(all.sum);
    quantity.sum_of_squares = keep(all.sum_of_squares);
  }
  const Transport a = measure_shallow(with_figures), b = measure_shallow(without);
  CHECK(a.depths.size() == b.depths.size() + 3);
  CHECK(a.depths_in_window == b.depths_in_window);
  CHECK(a.c.value == b.c.value);
  CHECK(a.D.value == b.D.value);
  CHECK(a.alpha_thrust.value == b.alpha_thrust.value);
}

TEST_CASE("noisy responses are unbiased, their errors right and chi2 about 1", "[unsanitized]") {
  // 60 ensembles with known truth. The mean of (value - truth)/error has an error of 1/sqrt(60) = 0.13, its variance
  // one of 0.19; five of those.
  const KnownTransport known;
  double pull_c = 0, pull_D = 0, square_c = 0, square_D = 0, chi2 = 0;
  int depths = 0;
  constexpr int repetitions = 60;
  for (std::uint64_t seed = 1; seed <= repetitions; ++seed) {
    const Transport t = measure_shallow(
        synthetic_ensemble(known, {0.5, seed}, made_up_columns, layers_to_record(shallow_window(), {}), 32, 100));
    REQUIRE(t.c.known());
    const double c = (t.c.value - known.c) / t.c.standard_error, D = (t.D.value - known.D) / t.D.standard_error;
    pull_c += c / repetitions;
    pull_D += D / repetitions;
    square_c += c * c / repetitions;
    square_D += D * D / repetitions;
    for (const DepthFit& depth : t.depths) chi2 += depth.chi2_per_dof, ++depths;
  }
  CHECK(std::abs(pull_c) < 5 * 0.13);
  CHECK(std::abs(pull_D) < 5 * 0.13);
  CHECK(square_c == Approx(1).margin(5 * 0.19));
  CHECK(square_D == Approx(1).margin(5 * 0.19));
  // The noise estimate of each mode has about 9 x 31 degrees of freedom: chi2 per degree is 1 to about 1 %.
  CHECK(chi2 / depths == Approx(1).margin(0.03));
}

TEST_CASE("every sample entered twice within its block leaves every number and every error unchanged") {
  const MeasuredEnsemble once =
      synthetic_ensemble({}, {0.5, 7}, made_up_columns, layers_to_record(shallow_window(), {}), 32, 100);
  const Transport a = measure_shallow(once), b = measure_shallow(doubled(once));
  const auto same = [](const Estimate& x, const Estimate& y) {
    CHECK(x.value == Approx(y.value).epsilon(1e-12));
    CHECK(x.standard_error == Approx(y.standard_error).epsilon(1e-9));
    CHECK(x.standard_error > 0);
  };
  same(a.c, b.c);
  same(a.D, b.D);
  same(a.position_offset, b.position_offset);
  same(a.width_offset, b.width_offset);
  same(a.alpha_thrust, b.alpha_thrust);
  same(a.c_thrust, b.c_thrust);
  same(a.c_minus_c_thrust, b.c_minus_c_thrust);
  CHECK(b.samples == 2 * a.samples);
  for (std::size_t i = 0; i < a.depths.size(); ++i) {
    same(a.depths[i].peak_position, b.depths[i].peak_position);
    same(a.depths[i].width, b.depths[i].width);
  }
  for (std::size_t i = 0; i < a.profiles.front().x.size(); ++i) {
    CHECK(a.profiles.front().standard_error[i] == Approx(b.profiles.front().standard_error[i]).epsilon(1e-9));
  }
}

TEST_CASE("the number of threads changes nothing") {
  const MeasuredEnsemble ensemble =
      synthetic_ensemble({}, {0.5, 7}, made_up_columns, layers_to_record(shallow_window(), {}), 32, 100);
  const Transport one = measure_shallow(ensemble, 1), many = measure_shallow(ensemble, 5);
  CHECK(one.c.value == many.c.value);
  CHECK(one.c.standard_error == many.c.standard_error);
  CHECK(one.D.value == many.D.value);
  CHECK(one.D.standard_error == many.D.standard_error);
}

TEST_CASE("without friction c is tan 30 degrees and D is 0 by the exact path") {
  for (double overload : {1.0, 0.25, 3.0}) {
    const Transport t = measure_shallow(frictionless_ensemble(layers_to_record(shallow_window(), {}), overload));
    CHECK(t.exact);
    CHECK(std::abs(t.c.value - tan30) < 1e-14);
    CHECK(std::abs(t.D.value) < 1e-14);
    CHECK(t.c.standard_error == 0.0);
    CHECK(t.D.standard_error == 0.0);
    CHECK(t.alpha_thrust.value == Approx(1).epsilon(1e-13));
  }
}

TEST_CASE("a width below the bead's is flagged and leaves the window") {
  KnownTransport narrow;
  narrow.c = 0.57;
  narrow.D = 0.004;
  narrow.width_offset = 0.0;  // W = 0.5 at z = 62.5
  const Transport t = measure_shallow(
      synthetic_ensemble(narrow, {0.01, 3}, made_up_columns, layers_to_record(shallow_window(), {}), 32, 1000));
  for (const DepthFit& depth : t.depths) {
    INFO("layer " << depth.layer << " W " << depth.width.value);
    if (std::abs(narrow.D * depth.z - 0.25) < 0.01) continue;  // too close to tell
    CHECK(depth.identifiable == (narrow.D * depth.z > 0.25));
    CHECK(depth.identifiable == depth.reason.empty());
  }
  CHECK(t.window_layers[0] > 60);
  CHECK(std::abs(t.D.value - narrow.D) < 5 * t.D.standard_error);
}

TEST_CASE("an ensemble with an empty block is unknown, not a crash") {
  MeasuredEnsemble ensemble =
      synthetic_ensemble({}, {0.5, 7}, made_up_columns, layers_to_record(shallow_window(), {}), 32, 100);
  ensemble.record.sums.count[5] = 0;
  const Transport t = measure_shallow(ensemble);
  CHECK_FALSE(t.c.known());
  CHECK_FALSE(t.c.reason.empty());
  CHECK_FALSE(t.c_thrust.known());
}

TEST_CASE("profiles are mirror symmetric, sum to the overload and carry their fit") {
  const Transport t = measure_shallow(
      synthetic_ensemble({}, {0.5, 7}, made_up_columns, layers_to_record(shallow_window(), {}), 32, 100));
  REQUIRE(t.profiles.size() == 2);
  for (const ResponseProfile& profile : t.profiles) {
    const std::size_t n = profile.x.size();
    double sum = 0;
    for (double p : profile.pressure) sum += p;
    CHECK(sum == Approx(1).epsilon(1e-10));
    CHECK(std::is_sorted(profile.x.begin(), profile.x.end()));
    for (std::size_t i = 0; i < n; ++i) {
      const auto mirror = std::find(profile.x.begin(), profile.x.end(), -profile.x[i]);
      if (mirror == profile.x.end()) continue;  // the bead on the far side of the ring is its own mirror image
      const auto j = static_cast<std::size_t>(mirror - profile.x.begin());
      CHECK(profile.pressure[i] == Approx(profile.pressure[j]).margin(1e-14));
    }
    CHECK(profile.fit.size() == n);
  }
}

TEST_CASE("c and D alone are those that come with their errors") {
  for (const double noise : {0.05, 0.5, 3.0}) {
    const FitSpec spec = shallow_window();
    const MeasuredEnsemble ensemble =
        synthetic_ensemble({}, {noise, 9}, made_up_columns, layers_to_record(spec, {}), 16, 50);
    const Transport whole = measure_shallow(ensemble);
    const Slopes slopes = measure_slopes(ensemble, spec);
    CAPTURE(noise);
    CHECK(whole.c.known() == std::isfinite(slopes.c));
    if (!whole.c.known()) continue;
    CHECK(slopes.c == Approx(whole.c.value).epsilon(1e-12));
    CHECK(slopes.D == Approx(whole.D.value).epsilon(1e-12));
  }
  const FitSpec spec = shallow_window();
  const MeasuredEnsemble exact = frictionless_ensemble(layers_to_record(spec, {}), 1);
  CHECK(measure_slopes(exact, spec).c == Approx(tan30).epsilon(1e-9));
  CHECK(measure_slopes(exact, spec).D == Approx(0).margin(1e-9));
}

namespace {

/// 500 x 200 beads, overload 1 on a uniform load of 1, 3461 samples, slopes over layers 58 to 179; one standard error.
/// Numbers on record: the independent implementation that printed them (two throw-away codes in agreement) is not in
/// the repository. c_thrust is computed anew by a second implementation in tests/ensemble/thrust_test.cc.
struct IndependentResult {
  double mu;
  double c, c_error;
  double D, D_error;
  double c_thrust;  ///< to all printed digits
};
constexpr IndependentResult independent[] = {{0.1, 0.5748, 0.0002, 0.0048, 0.0003, 0.5748},
                                             {0.2, 0.5690, 0.0006, 0.0257, 0.0012, 0.5674},
                                             {0.3, 0.5600, 0.0010, 0.078, 0.005, 0.5560}};
constexpr double half_unit = 0.5e-4;  ///< of the last printed digit of c_thrust
constexpr std::uint64_t seed = 4711;

MeasuredTransport measure_shallow(double mu, const FitSpec& fit) {
  EnsembleSpec spec;
  spec.sampler.mu = mu;
  spec.sampler.seed = seed;
  spec.response.samples = 3456;
  spec.layers = layers_to_record(fit, {});
  return measure_transport({spec, run_ensemble(spec, 0, nullptr)}, fit, {}, 0);
}

}  // namespace

TEST_CASE("c, D, c_thrust and beta of real piles agree with an independent implementation", "[long]") {
  const FitSpec fit;
  std::vector<MeasuredTransport> results;
  for (const IndependentResult& expected : independent) {
    results.push_back(measure_shallow(expected.mu, fit));
    const Transport& t = results.back().transport;
    CAPTURE(seed, expected.mu, t.c.value, t.c.standard_error, t.D.value, t.D.standard_error, t.c_thrust.value);
    REQUIRE(t.c.known());
    CHECK(t.failed.empty());
    CHECK(std::abs(t.c.value - expected.c) <= 3 * std::hypot(t.c.standard_error, expected.c_error));
    CHECK(std::abs(t.D.value - expected.D) <= 3 * std::hypot(t.D.standard_error, expected.D_error));
    CHECK(std::abs(t.c_thrust.value - expected.c_thrust) <= 3 * t.c_thrust.standard_error + half_unit);
    // The comparison must be able to tell: errors no larger than those of the other code.
    CHECK(t.c.standard_error <= 1.5 * expected.c_error);
    CHECK(t.D.standard_error <= 1.5 * expected.D_error);
  }
  results.push_back(measure_shallow(0.15, fit));
  const ScalingFit beta = fit_scaling(results, {0.1, 0.3}).beta;
  CAPTURE(beta.exponent.value, beta.exponent.standard_error);
  CHECK(beta.points == 4);
  CHECK(beta.exponent.standard_error <= 0.15);
  // The paper's 2.5 and the independent implementation's 2.5, to half a unit of the last digit.
  CHECK(std::abs(beta.exponent.value - 2.5) <= 3 * std::hypot(beta.exponent.standard_error, 0.05));
}

namespace {

/// f: fitted, s: of another shape, u: unidentified; shallowest first.
std::vector<std::size_t> run_of(const std::string& depths) {
  std::vector<DepthUse> uses;
  for (const char depth : depths) {
    uses.push_back(depth == 'f' ? DepthUse::fitted : depth == 's' ? DepthUse::other_shape : DepthUse::unidentified);
  }
  return identifiable_depths(uses);
}

using Run = std::vector<std::size_t>;

}  // namespace

TEST_CASE("the deepest run ends at an unidentified depth and at two of another shape, and leaves a single one out") {
  CHECK(run_of("") == Run{});
  CHECK(run_of("ffff") == Run{0, 1, 2, 3});
  CHECK(run_of("ffuff") == Run{3, 4});
  CHECK(run_of("fffu") == Run{});
  CHECK(run_of("ffsff") == Run{0, 1, 3, 4});
  CHECK(run_of("fsfsf") == Run{0, 2, 4});
  CHECK(run_of("ffssff") == Run{4, 5});
  CHECK(run_of("fffs") == Run{0, 1, 2});
  CHECK(run_of("ffss") == Run{});
  CHECK(run_of("ffusff") == Run{4, 5});
  CHECK(run_of("fsuff") == Run{3, 4});
  CHECK(run_of("sfff") == Run{1, 2, 3});
  CHECK(run_of("ssss") == Run{});
}

// The analysis does not know whether profiles are in memory or in a file.

TEST_CASE("an opened ensemble is measured as one in memory is") {
  const TemporaryFolder folder;
  const auto [quantity, width] = GENERATE(table<const char*, int>(
      {{"weight", 16}, {"response", 16}, {"correlation", 16}, {"propagation", 32}}));  // one for each kind of estimator
  CAPTURE(quantity);
  EnsembleRecord record;
  record.sums.layers = {0, 2, 5};
  record.sums.count = {8, 16, 8, 24, 8};
  QuantitySums& sums = record.sums.quantities[quantity];
  sums.width = width;
  sums.sum.resize(record.sums.count.size() * record.sums.layers.size() * static_cast<std::size_t>(width));
  std::mt19937_64 random(7);
  for (double& number : sums.sum) number = std::uniform_real_distribution<double>(1, 2)(random);
  write_ensemble(folder / "ensemble.h5", record);
  const BlockSums opened = open_ensemble(folder / "ensemble.h5").sums;
  REQUIRE(opened.quantities.at(quantity).sum.empty());
  for (std::size_t row = first_response(record.sums); row < record.sums.layers.size(); ++row) {
    const LayerSpectrum one = layer_spectrum(record.sums, row, 0.5), other = layer_spectrum(opened, row, 0.5);
    CHECK(same_bytes(one.whole, other.whole));
    CHECK(same_bytes(one.noise, other.noise));
    const BlockMeans response = mean_response(record.sums, row, 0.5), of_opened = mean_response(opened, row, 0.5);
    CHECK(same_bytes(response.whole, of_opened.whole));
    for (std::size_t b = 0; b < record.sums.count.size(); ++b) {
      CHECK(same_bytes(one.without_block.at(b), other.without_block.at(b)));
      CHECK(same_bytes(response.without_block.at(b), of_opened.without_block.at(b)));
    }
  }
}

namespace {

EnsembleSpec multiplexed(double mu, int columns, int layers) {
  EnsembleSpec spec;
  spec.response.estimator = EstimatorName::multiplexed;
  spec.sampler.mu = mu;
  spec.sampler.seed = 3;
  spec.lattice = {.columns = columns, .layers = layers};
  spec.response.samples = 128;
  spec.response.blocks = 16;
  return spec;
}

}  // namespace

TEST_CASE("multiplexed: the top layers respond as geometry has it, and every layer carries the whole load") {
  for (const int columns : {20, 21}) {
    const EnsembleSpec spec = multiplexed(0.5, columns, 30);
    const EnsembleRecord record = run_ensemble(spec, 0, nullptr);
    const Lattice lattice(spec.lattice);
    for (std::size_t row = 0; row < 30; ++row) {
      const BlockMeans response = mean_response(record.sums, row, 1);
      const auto check = [&](const std::vector<double>& profile) {
        double sum = 0;
        for (int i = 0; i < columns; ++i) {
          const double value = profile[static_cast<std::size_t>(i)];
          sum += value;
          const double x = lattice.x(static_cast<int>(row), i);
          if (row == 0) CHECK(value == Approx(x == 0 ? 1 : 0).margin(1e-12));
          // Each of the two beads below takes half, whatever their splits.
          if (row == 1) CHECK(value == Approx(std::abs(x) == 0.5 ? 0.5 : 0).margin(1e-12));
        }
        CHECK(sum == Approx(1).epsilon(1e-11));
      };
      check(response.whole);
      check(response.without_block[7]);
    }
  }
}

TEST_CASE("multiplexed: modes are those of the mean response") {
  const EnsembleSpec spec = multiplexed(0.5, 30, 40);
  const EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  for (const int layer : {18, 19}) {
    const Lattice lattice(spec.lattice);
    const auto row = static_cast<std::size_t>(layer);
    const LayerSpectrum spectrum = layer_spectrum(record.sums, row, 1);
    const BlockMeans response = mean_response(record.sums, row, 1);
    REQUIRE(spectrum.whole.size() == 14);
    for (int m = 1; m <= 14; ++m) {
      double whole = 0, without = 0;
      for (int i = 0; i < 30; ++i) {
        const double cosine = std::cos(2 * std::numbers::pi * m * lattice.x(layer, i) / 30);
        whole += response.whole[static_cast<std::size_t>(i)] * cosine;
        without += response.without_block[4][static_cast<std::size_t>(i)] * cosine;
      }
      const auto at = static_cast<std::size_t>(m) - 1;
      CHECK(spectrum.whole[at] == Approx(whole).margin(1e-11));
      CHECK(spectrum.without_block[4][at] == Approx(without).margin(1e-11));
      CHECK(spectrum.noise[at] > 0);
    }
  }
}

// The eight piles of a chain share their loads: one pattern of signs in each block, which may lack a mode altogether.
TEST_CASE("multiplexed: a block whose loads lack a mode says nothing about it, and leaves its noise known") {
  EnsembleSpec spec = multiplexed(0.5, 20, 30);
  EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  constexpr std::size_t row = 6, mode = 3, block = 2, columns = 20, layers = 30;
  const double before = layer_spectrum(record.sums, row, 1).noise[mode - 1];
  std::vector<double>& sums = record.sums.quantities.at("correlation").sum;
  for (const std::size_t at : {std::size_t{0}, row}) {
    for (const std::size_t part : {2 * mode - 1, 2 * mode}) sums[(block * layers + at) * columns + part] = 0;
  }
  const LayerSpectrum spectrum = layer_spectrum(record.sums, row, 1);
  CHECK(std::isfinite(spectrum.whole[mode - 1]));
  for (const double noise : spectrum.noise) CHECK(std::isfinite(noise));
  CHECK(spectrum.noise[mode - 1] > before / 2);
  CHECK(spectrum.noise[mode - 1] < before * 2);
}

TEST_CASE("multiplexed: without friction c is tan 30 degrees and D is 0, exactly") {
  FitSpec fit;
  fit.first_layer = 20;
  fit.last_layer = 60;
  fit.shallow_layer = 20;
  EnsembleSpec spec = multiplexed(0, 100, 81);
  spec.layers = layers_to_record(fit, {});
  const Transport t = measure_transport({spec, run_ensemble(spec, 0, nullptr)}, fit, {}, 0).transport;
  CHECK(t.exact);
  CHECK(t.c.value == Approx(tan30).epsilon(1e-11));
  CHECK(std::abs(t.D.value) < 1e-10);
  CHECK(t.c.standard_error == 0);
  CHECK(t.depths.front().layer == 21);  // layer 0 is no depth of the fit
}

TEST_CASE("multiplexed: without layer 0 there is no response") {
  const EnsembleSpec spec = multiplexed(0.5, 20, 30);
  EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  record.sums.layers.front() = 1;
  CHECK_THROWS_AS(mean_response(record.sums, 5, 1), InputError);
}

TEST_CASE("an ensemble without profiles has no response") {
  EnsembleSpec spec = multiplexed(0.5, 20, 30);
  spec.response.estimator = EstimatorName::point;
  spec.record_profiles = false;
  CHECK_THROWS_AS(mean_response(run_ensemble(spec, 0, nullptr).sums, 5, 1), InputError);
}

TEST_CASE("multiplexed and point agree where the response is nearly linear", "[long]") {
  const FitSpec fit;
  for (const auto& [mu, c, c_error, D, D_error] : test::linear_response) {
    EnsembleSpec spec = multiplexed(mu, 500, 200);
    spec.response.samples = 1536;
    spec.response.blocks = 32;
    spec.layers = layers_to_record(fit, {});
    const Transport t = measure_transport({spec, run_ensemble(spec, 0, nullptr)}, fit, {}, 0).transport;
    CAPTURE(mu, t.c.value, t.c.standard_error, t.D.value, t.D.standard_error);
    REQUIRE(t.c.known());
    // Half a unit of the last digit printed by the other code.
    CHECK(std::abs(t.c.value - c) <= 3 * std::hypot(t.c.standard_error, c_error) + 0.5e-4);
    CHECK(std::abs(t.D.value - D) <= 3 * std::hypot(t.D.standard_error, D_error) + 0.5e-4);
    CHECK(t.c.standard_error <= 2 * c_error);
    CHECK(t.D.standard_error <= 1.5 * D_error);
  }
}

}  // namespace granuscope
