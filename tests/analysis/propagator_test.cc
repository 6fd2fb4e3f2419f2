// The estimator fluctuation from its sums on: against what geometry fixes exactly, against a linear model whose
// response is known, and against the responses to loads. Each of its ingredients is left out once, and must be missed.
#include "analysis/dispersion.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

#include "analysis/linear_model.h"
#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"
#include "support/error.h"

using namespace granuscope;
using test::LinearModel;

namespace {

constexpr double c = LinearModel::c, D = LinearModel::D;
constexpr int model_columns = LinearModel::columns, model_modes = LinearModel::modes;

FitSpec window(int first, int last) {
  FitSpec fit;
  fit.first_layer = fit.shallow_layer = first;
  fit.last_layer = last;
  return fit;
}

std::vector<int> every_third(int first, int last) {
  std::vector<int> lags;
  for (int lag = first; lag <= last; lag += 3) lags.push_back(lag);
  return lags;
}

Transport measure(const MeasuredEnsemble& ensemble) {
  return measure_transport(ensemble, window(40, 70), {}, 0).transport;
}

double pull(const Estimate& estimate, double truth) { return (estimate.value - truth) / estimate.standard_error; }

/// Shares of ensembles whose c and D lie within one standard error of the truth, their mean pulls, and what of these
/// noise makes: the distance of the mean from what all piles give together. The noise of that is the one of the mean
/// and drops out, so that a bias of a tenth of an error is seen, where the mean pull of 400 is known to a twentieth.
void check_coverage(int ensembles, double margin_of_share, double margin_of_pull, double most_bias) {
  struct Number {
    const char* name;
    Estimate Transport::*of;
    double truth, inside = 0, pulls = 0, mean = 0, squares = 0;
  };
  std::array numbers{Number{"c", &Transport::c, c}, Number{"D", &Transport::D, D}};
  MeasuredEnsemble all;
  for (int r = 0; r < ensembles; ++r) {
    const MeasuredEnsemble one =
        test::linear_ensemble({}, 100 + static_cast<std::uint64_t>(r), 24, every_third(40, 70), 32, 2);
    const Transport t = measure(one);
    for (Number& number : numbers) {
      const Estimate& found = t.*number.of;
      REQUIRE(found.known());
      const double off = pull(found, number.truth);
      number.inside += std::abs(off) <= 1 ? 1.0 / ensembles : 0;
      number.pulls += off / ensembles;
      number.mean += found.value / ensembles;
      number.squares += found.standard_error * found.standard_error / ensembles;
    }
    if (r == 0) {
      all = one;
    } else {
      merge_into(all.record, one.record);
    }
  }
  const Transport together = measure(all);
  for (const Number& number : numbers) {
    const double bias = (number.mean - (together.*number.of).value) / std::sqrt(number.squares);
    CAPTURE(number.name, number.inside, number.pulls, bias);
    CHECK(number.inside == Approx(0.683).margin(margin_of_share));
    CHECK(std::abs(number.pulls) < margin_of_pull);
    CHECK(std::abs(bias) < most_bias);
    CHECK(std::abs(pull(together.*number.of, number.truth)) < 3.5);
  }
}

EnsembleSpec real_piles(double mu, LatticeSpec lattice, std::uint64_t samples) {
  EnsembleSpec spec;
  spec.response.estimator = EstimatorName::fluctuation;
  spec.response.samples = samples;
  spec.sampler.mu = mu;
  spec.sampler.seed = 5;
  spec.lattice = lattice;
  return spec;
}

Transport measure_real(EnsembleSpec spec, const FitSpec& fit) {
  spec.layers = layers_to_record(fit, {});
  return measure_transport({spec, run_ensemble(spec, 0, nullptr)}, fit, {}, 0).transport;
}

}  // namespace

TEST_CASE("correlations of three layers obey the wave equation that balance makes of them, whatever the piles") {
  // w_{n+1}(x) = w_{n-1}(x) + sqrt(3) [H_n(x - 1/2) - H_n(x + 1/2)], bead by bead.
  EnsembleSpec spec = real_piles(0.4, {30, 70}, 64);
  spec.response.blocks = 8;
  spec.response.first_base = 10;
  spec.layers = {4, 5, 6, 7};
  for (const int reference : {0, 5}) {
    spec.response.reference_lag = reference;
    const BlockSums sums = run_ensemble(spec, 0, nullptr).sums;
    const std::size_t width = 60;
    const auto part = [&](std::size_t block, std::size_t row, std::size_t m, std::size_t which) {
      return sums.quantities.at("propagation").sum[(block * sums.layers.size() + row) * width + 4 * (m - 1) + which];
    };
    for (const std::size_t row : {2U, 3U}) {
      for (std::size_t m = 1; m <= 8; ++m) {
        const double twice = 2 * sqrt3 * std::sin(std::numbers::pi * static_cast<double>(m) / 30);
        REQUIRE(part(3, row + 1, m, 0) != 0);
        CHECK(part(3, row + 1, m, 0) == Approx(part(3, row - 1, m, 0) + twice * part(3, row, m, 3)).margin(1e-9));
        CHECK(part(3, row + 1, m, 2) == Approx(part(3, row - 1, m, 2) - twice * part(3, row, m, 1)).margin(1e-9));
      }
    }
  }
}

TEST_CASE("the response in x is the one that its modes make") {
  const MeasuredEnsemble ensemble = test::linear_ensemble({}, 1, 24, {40, 43}, 8, 4);
  for (const std::size_t row : {1U, 2U}) {
    const BlockMeans found = propagated_modes(ensemble.record.sums, row).cosines,
                     response = propagated_response(ensemble.record.sums, row);
    const int layer = ensemble.record.sums.layers[row];
    const Lattice lattice({model_columns, layer + 1});
    double area = 0, mode = 0;
    for (int i = 0; i < model_columns; ++i) {
      const double value = response.without_block[2][static_cast<std::size_t>(i)];
      area += value;
      mode += value * std::cos(2 * std::numbers::pi * 7 * lattice.x(layer, i) / model_columns);
    }
    CHECK(area == Approx(1));
    CHECK(mode == Approx(found.without_block[2][6]).margin(1e-12));
    CHECK(found.whole.size() == model_modes);
  }
}

TEST_CASE("fluctuations of a linear model give its c and D, with errors one can bet on", "[unsanitized]") {
  check_coverage(20, 0.33, 0.9, 0.4);
}

TEST_CASE("fluctuations of a linear model: 400 ensembles", "[long]") { check_coverage(400, 0.05, 0.15, 0.1); }

TEST_CASE("what single layers have for themselves is biased without a reference and not with it", "[unsanitized]") {
  LinearModel model;
  model.slip = 0.1;
  const Transport with = measure(test::linear_ensemble(model, 1, 24, every_third(40, 70), 32, 8));
  CHECK(std::abs(pull(with.c, c)) < 3);
  CHECK(std::abs(pull(with.D, D)) < 3);
  const MeasuredEnsemble without = test::linear_ensemble(model, 1, 0, every_third(40, 70), 32, 8);
  // The share of its variance that does not travel is missing from every mode of w.
  const LayerSpectrum spectrum = layer_spectrum(without.record.sums, 5, 0);
  const double z = Lattice::depth(without.record.sums.layers[5]) - Lattice::depth(0),
               k = 2 * std::numbers::pi / model_columns;
  const double truth = std::cos(c * k * z) * std::exp(-D * k * k * z / 2);
  CHECK(spectrum.whole[0] == Approx(truth * (1 + 1 / (1 + model.slip)) / 2).margin(4 * spectrum.noise[0]));
  CHECK(std::abs(spectrum.whole[0] - truth) > 4 * spectrum.noise[0]);
}

TEST_CASE("with one field left out, or one sign wrong, the response is another", "[unsanitized]") {
  const MeasuredEnsemble whole = test::linear_ensemble({}, 1, 24, every_third(40, 70), 32, 8);
  const Transport good = measure(whole);
  CHECK(std::abs(pull(good.c, c)) < 3);
  CHECK(std::abs(pull(good.D, D)) < 3);
  const auto damaged = [&](auto damage) {
    MeasuredEnsemble other = whole;
    std::vector<double>& sum = other.record.sums.quantities.at("propagation").sum;
    for (std::size_t at = 0; at < sum.size(); at += 4) damage(&sum[at]);
    const Transport t = measure(other);
    return !t.c.known() || std::abs(pull(t.c, c)) > 5 || !t.D.known() || std::abs(pull(t.D, D)) > 5;
  };
  CHECK(damaged([](double* part) { part[2] = part[3] = 0; }));  // H left out
  CHECK(damaged([](double* part) { part[3] = -part[3]; }));     // as if H did not change its sign in a mirror
}

TEST_CASE("piles without friction do not fluctuate, and the reason is said") {
  const FitSpec fit = window(20, 40);
  const Transport t = measure_real(real_piles(0, {60, 160}, 256), fit);
  CHECK_FALSE(t.c.known());
  CHECK(t.depths.front().reason.find("without friction") != std::string::npos);
  CHECK(t.alpha_thrust.value == Approx(1));
}

TEST_CASE("an ensemble without lag 0 is refused") {
  MeasuredEnsemble ensemble = test::linear_ensemble({}, 1, 24, {40, 43, 46}, 8, 1);
  ensemble.record.sums.layers[0] = 7;
  CHECK_THROWS_AS(propagated_modes(ensemble.record.sums, 1), InputError);
}

TEST_CASE("fluctuations give the c and D that the response to loads has", "[unsanitized]") {
  const FitSpec fit = window(41, 119);
  const Transport by_fluctuations = measure_real(real_piles(0.3, {300, 400}, 512), fit);
  EnsembleSpec loaded = real_piles(0.3, {300, 140}, 2048);
  loaded.response.estimator = EstimatorName::multiplexed;
  loaded.response.opposite = true;
  loaded.response.epsilon = 0.15;
  const Transport by_loads = measure_real(loaded, fit);
  for (const auto& [one, other] :
       {std::pair{by_fluctuations.c, by_loads.c}, std::pair{by_fluctuations.D, by_loads.D}}) {
    CAPTURE(one.value, one.standard_error, other.value, other.standard_error);
    CHECK(std::abs(one.value - other.value) < 4 * std::hypot(one.standard_error, other.standard_error));
  }
  CHECK(by_fluctuations.D.standard_error < 0.03 * by_fluctuations.D.value);
}

TEST_CASE("bases in the top, where fluctuations still build up, give another response than deep ones", "[long]") {
  // At mu = 0.1 that takes some hundred layers, and peaks are faster above: the reason for response.first_base.
  const FitSpec fit = window(58, 148);
  EnsembleSpec shallow = real_piles(0.1, {300, 240}, 2048);
  shallow.response.first_base = 10;
  shallow.response.base_step = 3;
  const Estimate top = measure_real(shallow, fit).c, deep = measure_real(real_piles(0.1, {300, 1200}, 256), fit).c;
  CAPTURE(top.value, top.standard_error, deep.value, deep.standard_error);
  CHECK(top.value - deep.value > 4 * std::hypot(top.standard_error, deep.standard_error));
}

TEST_CASE("without a reference lag two Gaussians of area 1 fit badly", "[long]") {
  const FitSpec fit = window(58, 148);
  // What single contacts do to single beads stays in C_0 and makes all amplitudes too small.
  const auto chi2_with = [&](int reference) {
    EnsembleSpec spec = real_piles(0.4, {300, 900}, 512);
    spec.response.reference_lag = reference;
    return measure_real(spec, fit).depths.front().chi2_per_dof;
  };
  CHECK(chi2_with(0) > 1.5 * chi2_with(24));
}

TEST_CASE("reference lags of 12 and 24 and 40 layers give nearly the same c and D", "[long]") {
  // A reference is part of the way: c and D belong to the depth r + l, and since D grows with depth 40 layers give 1 %
  // more of it than 24 at mu = 0.4, and a c that is lower by 4e-5 at mu = 0.1 and by 1e-4 at 0.3. 12 layers leave some
  // slip: 4e-5 in c at mu = 0.1, 2 % of D at 0.4; none leave 12e-5 and 3 %.
  struct Case {
    double mu, of_c, of_D;  // margins, the latter relative
  };
  const Case one = GENERATE(Case{0.1, 1e-4, 0.02}, Case{0.3, 2e-4, 0.02}, Case{0.4, 3e-4, 0.03});
  FitSpec fit = window(58, 148);
  fit.layer_step = 3;
  const auto measured = [&](int reference) {
    EnsembleSpec spec = real_piles(one.mu, {300, 900}, 512);
    spec.response.reference_lag = reference;
    spec.layers = layers_to_record(fit, {});
    return measure_transport({spec, run_ensemble(spec, 0, nullptr)}, fit, {}, 0);
  };
  const MeasuredTransport usual = measured(24);
  for (const int reference : {12, 40}) {
    // Block by block, so that what the piles have in common drops out.
    const MeasuredTransport other = measured(reference);
    const Estimate of_c = estimate(transform(std::minus<>{}, other.c, usual.c)),
                   of_D = estimate(transform([](double a, double b) { return a / b - 1; }, other.D, usual.D));
    CAPTURE(one.mu, reference, of_c.value, of_c.standard_error, of_D.value, of_D.standard_error);
    CHECK(std::abs(of_c.value) < one.of_c);
    CHECK(std::abs(of_D.value) < one.of_D);
    CHECK(of_c.standard_error < one.of_c / 3);
    CHECK(of_D.standard_error < one.of_D / 3);
  }
}

TEST_CASE("fluctuations under another law than granusolve travel as its thrust has it", "[long]") {
  // The law polytope on rings as wide as can be drawn: c of its waves is c_thrust of its piles, and the flat measure
  // spreads a load more than the exact law, as loads near the top say, too (0.52(4) and 0.22(3), examples/laws.toml).
  std::vector<Estimate> D;
  for (const double lambda : {0.0, 1.0}) {
    EnsembleSpec spec = real_piles(0.3, {32, 72}, 256);
    spec.sampler.law = Law::polytope;
    spec.sampler.lambda = lambda;
    spec.sampler.burn_in = lambda == 0 ? 400 : 2000;
    spec.sampler.thinning = lambda == 0 ? 50 : 200;
    spec.response.first_base = 16;
    spec.response.reference_lag = 8;
    spec.response.base_step = 1;
    spec.layers = {12};
    const BlockSums sums = run_ensemble(spec, 0, nullptr).sums;
    const Estimate c_thrust = estimate(thrust_speed(sums, 0));
    const BandOfModes band = measure_dispersion(sums, 0, 1, {0.3, 0.8}, {c_thrust.value, 0.3}).front();
    CAPTURE(lambda, c_thrust.value, band.c.value, band.c.standard_error, band.D.value, band.D.standard_error);
    CHECK(std::abs(band.c.value - c_thrust.value) < 4 * band.c.standard_error);
    CHECK(band.c.standard_error < 0.05 * c_thrust.value);
    D.push_back(band.D);
  }
  CHECK(D[0].value - D[1].value > 4 * std::hypot(D[0].standard_error, D[1].standard_error));
}

namespace {

using Complex = std::complex<double>;

/// What a model with noise that is independent from bead to bead makes of a mode of w and H within a row, on the mean.
struct RowPropagator {
  ModelSpec model;
  std::function<std::array<Complex, 4>(double)> of;  ///< ww, wH, Hw, HH
};

std::vector<RowPropagator> row_propagators() {
  static constexpr Complex i(0, 1);
  RowPropagator q, legs, osl;
  q.model.name = ModelName::q_model;
  q.of = [](double k) { return std::array<Complex, 4>{std::cos(k / 2), 0, 0, 0}; };
  legs.model.name = ModelName::three_leg;
  legs.model.three_leg.middle = 0.3;
  legs.model.three_leg.noise = 0.3;
  legs.of = [](double k) {
    return std::array<Complex, 4>{0.3 + 0.7 * std::cos(k), -i * std::sin(k), -0.7 * i * std::sin(k), std::cos(k)};
  };
  osl.model.name = ModelName::stochastic_osl;
  osl.model.stochastic_osl.grid = 1;
  osl.model.stochastic_osl.disorder = 0.4;
  osl.of = [](double k) {
    // H lies between the beads; its mean over both sides of a bead has the factor cos(k/2).
    const double courant = std::sqrt(3.0) / 2, eta = 1.0 / 3;
    const Complex push = -courant * eta * 2.0 * i * std::sin(k / 2), press = -courant * 2.0 * i * std::sin(k / 2);
    return std::array<Complex, 4>{1.0 + press * push, press / std::cos(k / 2), push * std::cos(k / 2), 1.0};
  };
  return {q, legs, osl};
}

/// `step` times itself, so many times.
std::array<Complex, 4> power(const std::array<Complex, 4>& step, int times) {
  std::array<Complex, 4> all{1, 0, 0, 1};
  for (int n = 0; n < times; ++n) {
    all = {step[0] * all[0] + step[1] * all[2], step[0] * all[1] + step[1] * all[3],
           step[2] * all[0] + step[3] * all[2], step[2] * all[1] + step[3] * all[3]};
  }
  return all;
}

}  // namespace

TEST_CASE("fluctuations of models that hand forces down row by row give their exact response, mode by mode") {
  for (const RowPropagator& exact : row_propagators()) {
    const bool scalar = exact.model.name == ModelName::q_model;
    EnsembleSpec spec = real_piles(0.3, {48, scalar ? 140 : 90}, 4096);
    spec.sampler.model = exact.model;
    spec.response.reference_lag = scalar ? 1 : 6;
    spec.response.base_step = 2;
    spec.layers = {3, 8, 17};
    const EnsembleRecord record = run_ensemble(spec, 0, nullptr);
    int compared = 0, precise = 0;
    double chi2 = 0;
    for (std::size_t row = 1; row < record.sums.layers.size(); ++row) {
      const PropagatedModes found = propagated_modes(record.sums, row);
      const auto compare = [&](const BlockMeans& modes, std::size_t m, double truth) {
        Replicated mode{modes.whole[m], {}};
        for (const auto& without : modes.without_block) mode.without_block.push_back(without[m]);
        const double off = pull(estimate(mode), truth);
        if (estimate(mode).standard_error < 0.01) ++precise;
        CAPTURE(configuration_text(exact.model), record.sums.layers[row], m + 1, mode.value, truth);
        CHECK(std::abs(off) < 5);
        chi2 += off * off;
        ++compared;
      };
      std::vector<std::array<Complex, 4>> propagators;
      double of_w = 0, of_H = 0;
      for (std::size_t m = 0; m < found.cosines.whole.size(); ++m) {
        const auto step = exact.of(2 * std::numbers::pi * static_cast<double>(m + 1) / 48);
        propagators.push_back(power(step, record.sums.layers[row]));
        of_w += std::abs(propagators.back()[1].imag());
        of_H += std::abs(propagators.back()[2].imag());
      }
      CHECK(found.sines.whole.size() == (scalar ? 0 : propagators.size()));
      const double s = std::sqrt(of_H / of_w);
      for (std::size_t m = 0; m < propagators.size(); ++m) {
        const auto& [ww, wH, Hw, HH] = propagators[m];
        compare(found.cosines, m, scalar ? ww.real() : (ww + HH).real() / 2);
        if (!scalar) compare(found.sines, m, -(s * wH + Hw / s).imag() / 2);
      }
    }
    CAPTURE(configuration_text(exact.model), compared, precise, chi2);
    CHECK(precise > 20);
    CHECK(chi2 < 2 * compared);
  }
}
