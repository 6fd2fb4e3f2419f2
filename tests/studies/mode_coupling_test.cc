#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "ensemble/ensemble_runner.h"
#include "kit/temporary_folder.h"
#include "plot/figure_texts.h"
#include "sampling/sampler.h"
#include "studies/mode_coupling/fields.h"
#include "support/files.h"

using namespace granuscope;

TEST_CASE("The peak of the class of Kardar, Parisi and Zhang has its known moments") {
  // Prähofer and Spohn (2004): variance 0.5105; Baik and Rains (2000): variance 1.15039 of the height at 0.
  CHECK(stationary_height_variance(0) == Approx(1.15039).margin(1e-5));
  CHECK(stationary_height_variance(4) == Approx(8).margin(1e-9));  // far out the height is that of two random walks
  CHECK(stationary_height_variance(-1.3) == stationary_height_variance(1.3));
  const KpzPeak& peak = kpz_peak();
  CHECK(peak.variance == Approx(0.510523).margin(2e-6));
  CHECK(peak.mode(0) == Approx(1).margin(1e-8));
  const double k = 0.05;
  CHECK(2 * (1 - peak.mode(k)) / (k * k) == Approx(1).epsilon(1e-3));  // scaled to variance 1
  double fourth = 0;
  for (std::size_t i = 1; i < peak.density.size(); ++i) {
    CHECK(peak.density[i] < peak.density[i - 1] + 1e-8);
    CHECK(peak.density[i] > -1e-8);
    fourth += 2 * KpzPeak::step * std::pow(KpzPeak::step * static_cast<double>(i), 4) * peak.density[i];
  }
  // Its tails, exp(-0.295 |y|^3), are shorter than a Gaussian's.
  CHECK(fourth / (peak.variance * peak.variance) < 2.9);
  CHECK(std::log(peak.density[30] / peak.density[25]) == Approx(-0.295 * (27 - 15.625)).epsilon(0.2));
}

TEST_CASE("Torque fluctuates and spreads in layers as in those computed here bead by bead") {
  FluctuationPiles piles;
  piles.sampler.mu = 0.5;
  piles.columns = 60;
  piles.layer = 40;
  piles.samples = 16;
  piles.blocks = 8;
  const LayerFluctuations layer = measure_fluctuations(piles, 1), other = measure_fluctuations(piles, 3);
  CHECK(layer.D_torque.value == other.D_torque.value);
  CHECK(layer.D_torque.value > 0.2);
  CHECK(layer.D_torque.value < 0.7);
  const Lattice lattice({piles.columns, layers_needed(piles)});
  const auto sampler = make_sampler(piles.sampler, lattice);
  const std::vector<double> load(60, 1.0);
  Pile pile(lattice);
  double w = 0, H = 0, torque = 0;
  for (std::uint64_t sample = 0; sample < piles.samples; ++sample) {
    REQUIRE_FALSE(sampler->draw(sample, load, pile));
    constexpr int bases = 24;  // of which the mean is taken
    for (int n = 40; n < 40 + 8 * bases; n += 8) {
      std::complex<double> w_k, H_k, torque_k;
      for (int i = 0; i < 60; ++i) {
        const std::size_t at = lattice.index(n, i);
        const auto phase = std::polar(1.0, -2 * std::numbers::pi * 3 * i / 60);
        const double T_R = (std::sqrt(3) * pile.H_R[at] - pile.V_R[at]) / 2;
        const double T_L = (std::sqrt(3) * pile.H_L[at] + pile.V_L[at]) / 2;
        w_k += (pile.V_R[at] + pile.V_L[at]) * phase;
        H_k += (pile.H_R[at] + pile.H_L[at]) * phase;
        torque_k += (T_R + T_L) * phase;
      }
      w += std::norm(w_k) / 60 / 16 / bases;
      H += std::norm(H_k) / 60 / 16 / bases;
      torque += std::norm(torque_k) / 60 / 16 / bases;
    }
  }
  CHECK(layer.layer == 40);
  CHECK(layer.k[2] == Approx(2 * std::numbers::pi * 3 / 60));
  CHECK(layer.of_w[2].value == Approx(w));
  CHECK(layer.of_H[2].value == Approx(H));
  CHECK(layer.of_torque[2].value == Approx(torque));
  CHECK(other.of_torque[2].without_block == layer.of_torque[2].without_block);
}

TEST_CASE("The couplings predict the spreading of the peaks, on a ring that they go around", "[unsanitized]") {
  const std::unique_ptr<Study> study = mode_coupling_study();
  MainLine main;
  const auto set = [&](const std::string& name, const KeyValue& value) {
    for (const Key& key : study->keys()) {
      if (key.name == name) key.set(value);
    }
  };
  CHECK_FALSE(study->asked());
  set("mu", std::vector<double>{0.5});
  set("octaves", std::int64_t{3});
  set("columns", std::int64_t{150});
  set("samples", std::int64_t{512});
  set("loaded_samples", std::int64_t{256});
  set("fluctuation_layer", std::int64_t{512});
  set("fluctuation_samples", std::int64_t{256});
  REQUIRE(study->asked());
  const auto found_problem = study->find_problem(main);
  REQUIRE(found_problem);  // less than twelve widths
  CHECK(found_problem->message.find("meet on the ring") != std::string::npos);
  CHECK(found_problem->message.find("give 158 columns") != std::string::npos);
  set("columns", std::int64_t{160});  // at z = 222 the peaks have met behind it, at 117 on either side
  REQUIRE_FALSE(study->find_problem(main));
  study->begin(main, 2);
  for (const StudyEnsemble& one : study->ensembles(main))
    study->add(one, {one.spec, run_ensemble(one.spec, 0, nullptr)});
  study->finish();
  const auto results = study->json();
  REQUIRE(results.size() == 1);
  const auto& found = results[0];
  const auto value = [](const auto& number) { return number.at("value").template get<double>(); };
  const auto error = [](const auto& number) { return number.at("stderr").template get<double>(); };
  // A(0) is the thrust ratio of upright piles, sound has the speed that follows from it.
  CHECK(value(found["thrust_by_slope"]["at_zero"]) == Approx(0.833).margin(0.004));
  CHECK(value(found["thrust_by_slope"]["curvature"]) > 3 * error(found["thrust_by_slope"]["curvature"]));
  CHECK(value(found["thrust_by_torque"]["curvature"]) < -5);
  const double sound = value(found["response"]["c_thrust"]);
  // Of waves down to k = 0.5, which begin to see beads.
  CHECK(std::abs(value(found["plateau"]["C_H_over_C_w"]) - sound * sound) <
        5 * error(found["plateau"]["C_H_over_C_w"]) + 0.02 * sound * sound);
  CHECK(value(found["coupling_to_torque"]) > 10 * value(found["coupling_to_itself"]));
  CHECK(std::abs(value(found["strength"]) - 1) < 5 * error(found["strength"]) + 0.2);
  // The first octave is the measured one; the others are nearer to it than one D.
  const auto& predicted = found["predicted"];
  REQUIRE(predicted["slopes"].size() == 3);
  CHECK(predicted["slopes"][0].get<double>() == Approx(value(found["response"]["octaves"][0]["D"])).epsilon(1e-5));
  CHECK(predicted["octaves"] == 2);
  CHECK(predicted["chi2"].get<double>() < found["diffusion_chi2"].get<double>());
  // B three times: from the couplings, from how waves decay, from how peaks spread.
  for (const char* by : {"of_widths", "of_waves"}) {
    const auto& B = found[by]["B"];
    CAPTURE(by, found[by].dump(), found["B"].dump());
    CHECK(std::abs(value(B) - value(found["B"])) < 5 * error(B) + 0.2 * value(found["B"]));
    CHECK(found[by]["chi2"].get<double>() < 25 * (1 + found[by]["degrees_of_freedom"].get<double>()));
  }
  CHECK(value(found["speeds"]["ratio"]) > 0.4);
  CHECK(study->claims({}).front().id == "mode-coupling");
  const test::TemporaryFolder folder;
  for (const FigurePlot& plot : study->figures({})) {
    const Figure figure = plot(folder.path());
    CAPTURE(figure.id, figure.failure);
    REQUIRE(figure.is_there());
    check_texts(read_file(folder / figure.screen));
    check_at_widths_of_journals(folder / "figures", figure.id);
  }
  // Each peak is shown where it is, 117 of the ring's 160 columns away at the deepest lag: 2 W P = 0.4 in its middle.
  for (int lag = 1; lag <= 3; ++lag) {
    const std::string table = read_file(folder / fmt::format("figures/peak-shape-{}.csv", lag));
    double middle = 0;
    for (std::size_t line = table.find('\n', table.find('\n') + 1); line + 1 < table.size();
         line = table.find('\n', line + 1)) {
      std::size_t end = 0;
      const double x = std::stod(table.substr(line + 1), &end);
      if (std::abs(x) < 0.15) middle = std::stod(table.substr(line + 2 + end));
    }
    CAPTURE(lag);
    CHECK(middle == Approx(0.4).margin(0.05));
  }
}

TEST_CASE("Page 1 says that torque explains the spreading where it makes the prediction better, and names where not") {
  const auto one = [](double mu, const Estimate& strength, double with, double without) {
    CoupledSpreading piles;
    piles.mu = mu;
    piles.strength = strength;
    piles.predicted.chi2 = with;
    piles.diffusion_chi2 = without;
    piles.response.octaves.resize(3);
    return piles;
  };
  const auto told = [](const std::vector<CoupledSpreading>& list) { return coupling_page_1(list); };
  const CoupledSpreading good = one(0.5, {0.9, 0.04, {}}, 9, 583), other = one(0.8, {1.1, 0.04, {}}, 15, 1084);
  CHECK(told({good, other}).at("explained") == true);
  CHECK(told({good, other}).at("fails_somewhere") == false);
  CHECK(told({good, other}).at("last").at("key") == "/studies/mode_coupling/0/response/octaves/2");
  // A large error alone does not make it hold.
  const auto partly = told({one(0.2, {0.41, 0.14, {}}, 28, 10), good});
  CHECK(partly.at("explained") == true);
  CHECK(partly.at("fails_somewhere") == true);
  REQUIRE(partly.at("failed").size() == 1);
  CHECK(partly.at("failed")[0].at("key") == "/studies/mode_coupling/0");
  CHECK(told({one(0.5, {0.5, 0.04, {}}, 9, 583)}).at("explained") == false);
  CHECK(told({one(0.1, {}, 0, 0), good}).at("any").at("key") == "/studies/mode_coupling/1");
}
