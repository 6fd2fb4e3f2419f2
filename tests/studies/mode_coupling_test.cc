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
#include "studies/mode_coupling/measure.h"
#include "studies/mode_coupling/study.h"
#include "studies/mode_coupling/theory.h"
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

namespace {

double width_squared(const CoupledPeak& peak, double z) { return std::pow(peak.shape(z).width, 2); }

}  // namespace

TEST_CASE("Without coupling a peak is a Gaussian that moves and spreads by diffusion") {
  const CoupledPeak peak = solve_coupled_peak({.D = 0.1, .c = 0.5, .depth = 128, .ring = 512});
  for (const double z : {32.0, 64.0, 128.0}) {
    // The fitted Gaussians are integrated over a bead, of variance 1/12.
    CHECK(width_squared(peak, z) == Approx(0.1 * z - 1.0 / 12).epsilon(1e-3));
    CHECK(peak.shape(z).peak == Approx(0.5 * z).epsilon(1e-6));
    CHECK(std::abs(peak.mode_at(z, 0.2)) == Approx(std::exp(-0.1 * 0.04 * z / 2)).epsilon(1e-4));
  }
}

TEST_CASE("A peak coupled to itself comes to spread as z^(4/3), one coupled to torque is late, skew and wide") {
  const CoupledPeak itself = solve_coupled_peak({.D = 0.5, .c = 0.5, .to_itself = 1, .depth = 1024, .ring = 2048});
  CHECK(std::log2(width_squared(itself, 1024) / width_squared(itself, 512)) == Approx(4.0 / 3).margin(0.02));
  // lambda^2/4 = 1; by the fit of two Gaussians.
  CHECK(width_squared(itself, 1024) / std::pow(2 * 1024, 4.0 / 3) == Approx(0.51).margin(0.02));
  CHECK(std::abs(itself.mode_at(512, 0.01).imag()) < 1e-9);

  const CouplingSpec torque{.D = 0.18, .c = 0.527, .to_torque = 0.05, .D_torque = 0.38, .depth = 512, .ring = 1024};
  const CoupledPeak coupled = solve_coupled_peak(torque);
  double before = 1;
  for (double z : {64.0, 128.0, 256.0}) {
    const double power = std::log2(width_squared(coupled, 2 * z) / width_squared(coupled, z));
    CHECK(power > 1.1);
    CHECK(power < 4.0 / 3);
    // The tail lies behind the peak, towards the torque that it has left: the peak itself runs ahead of c, less and
    // less.
    const double ahead = coupled.shape(z).peak / z - torque.c;
    CHECK(ahead > 0);
    CHECK(ahead < before);
    before = ahead;
    CHECK(coupled.mode_at(z, 0.05).imag() < 0);
  }
  CouplingSpec finer = torque;
  finer.step = 0.5;
  CouplingSpec finest = torque;
  finest.step = 0.25;
  // What happens within a step adds to D for good; beyond that the equation is known to a percent.
  const auto bent = [](const CoupledPeak& peak) { return width_squared(peak, 512) - 4 * width_squared(peak, 128); };
  const double coarse = bent(coupled), fine = bent(solve_coupled_peak(finer)), limit = bent(solve_coupled_peak(finest));
  CHECK(std::abs(fine - limit) < 0.6 * std::abs(coarse - limit));
  CHECK(coarse == Approx(limit).epsilon(0.01));
  // Steps as long as those to great depth: kernels are means over them, since at their begin they fall faster than
  // that.
  CouplingSpec long_steps = torque;
  long_steps.step = 8;
  const CoupledPeak deep = solve_coupled_peak(long_steps);
  CHECK(bent(deep) == Approx(limit).epsilon(0.05));
  CHECK(width_squared(deep, 512) == Approx(width_squared(solve_coupled_peak(finest), 512)).epsilon(0.05));
}

TEST_CASE("Torque fluctuates and spreads in layers as in those computed here bead by bead") {
  FluctuationPiles piles;
  piles.sampler.mu = 0.5;
  piles.columns = 60;
  piles.layers = {20, 40};
  piles.samples = 16;
  piles.blocks = 8;
  const Fluctuations one = measure_fluctuations(piles, 1), other = measure_fluctuations(piles, 3);
  REQUIRE(one.layers.size() == 2);
  CHECK(one.D_torque.value == other.D_torque.value);
  CHECK(one.D_torque.value > 0.2);
  CHECK(one.D_torque.value < 0.7);
  const Lattice lattice({piles.columns, layers_needed(piles)});
  const auto sampler = make_sampler(piles.sampler, lattice);
  const std::vector<double> load(60, 1.0);
  Pile pile(lattice);
  double w = 0, H = 0, torque = 0;
  for (std::uint64_t sample = 0; sample < piles.samples; ++sample) {
    REQUIRE_FALSE(sampler->draw(sample, load, pile));
    std::complex<double> w_k, H_k, torque_k;
    for (int i = 0; i < 60; ++i) {
      const std::size_t at = lattice.index(40, i);
      const auto phase = std::polar(1.0, -2 * std::numbers::pi * 3 * i / 60);
      const double T_R = (std::sqrt(3) * pile.H_R[at] - pile.V_R[at]) / 2;
      const double T_L = (std::sqrt(3) * pile.H_L[at] + pile.V_L[at]) / 2;
      w_k += (pile.V_R[at] + pile.V_L[at]) * phase;
      H_k += (pile.H_R[at] + pile.H_L[at]) * phase;
      torque_k += (T_R + T_L) * phase;
    }
    w += std::norm(w_k) / 60 / 16;
    H += std::norm(H_k) / 60 / 16;
    torque += std::norm(torque_k) / 60 / 16;
  }
  const LayerFluctuations& layer = one.layers[1];
  CHECK(layer.layer == 40);
  CHECK(layer.k[2] == Approx(2 * std::numbers::pi * 3 / 60));
  CHECK(layer.of_w[2].value == Approx(w));
  CHECK(layer.of_H[2].value == Approx(H));
  CHECK(layer.of_torque[2].value == Approx(torque));
  CHECK(other.layers[1].of_torque[2].without_block == layer.of_torque[2].without_block);
}

TEST_CASE("Thrust by what rows of beads carry is the parabola through rows of known slope and torque") {
  // Layers of 32 beads whose eights carry slopes and torques of their own, w = 2, and the thrust that belongs to them.
  const auto thrust = [](double h, double torque) { return 0.9 + 2.5 * h * h / 2 - 6.5 * torque * torque / 2; };
  std::vector<BlockRegression> blocks;
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> some(-0.2, 0.2);
  for (int block = 0; block < 8; ++block) {
    BlockRegression& sums = blocks.emplace_back(8);
    Pile pile(Lattice({32, 3}));
    for (int row = 0; row < 4; ++row) {
      const double h = some(engine), torque = some(engine), w = 2;
      for (int i = 8 * row; i < 8 * row + 8; ++i) {
        const std::size_t at = pile.lattice.index(1, i);
        const double V_difference = std::sqrt(3) * h * w + 2 * torque * w;  // of V_R and V_L, an odd layer
        pile.V_R[at] = (w + V_difference) / 2;
        pile.V_L[at] = (w - V_difference) / 2;
        pile.H_R[at] = (h * w + thrust(h, torque) * w / std::sqrt(3)) / 2;
        pile.H_L[at] = (h * w - thrust(h, torque) * w / std::sqrt(3)) / 2;
      }
    }
    sums.add(pile, 1);
  }
  const ThrustInBlocks found = thrust_in_blocks(blocks);
  CHECK(found.beads == 8);
  CHECK(found.by_slope.value == Approx(2.5).epsilon(1e-9));
  CHECK(found.by_torque.value == Approx(-6.5).epsilon(1e-9));
  REQUIRE(found.by_slope.without_block.size() == 8);
  CHECK(found.by_slope.without_block[3] == Approx(2.5).epsilon(1e-9));
  // Without noise no row says otherwise; one that does moves all replicates but the one without it.
  Pile other(Lattice({8, 1}));
  other.V_R.assign(8, 0.5);
  other.V_L.assign(8, 0.5);
  other.H_R.assign(8, 2);
  blocks[3].add(other, 0);
  const ThrustInBlocks moved = thrust_in_blocks(blocks);
  CHECK(moved.by_slope.without_block[3] == Approx(2.5).epsilon(1e-9));
  CHECK(moved.by_slope.without_block[4] > 3);
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
  set("wide_mu", std::vector<double>{0.5});
  set("loaded_mu", std::vector<double>{0.5});
  main.response.epsilon = 0.15;
  set("loaded_samples", std::int64_t{256});
  set("fluctuation_layers", std::vector<std::int64_t>{64, 512});
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
  // Thrust in rows of beads goes with slope and torque as under loads.
  const auto& rows = found["thrust_in_blocks"];
  REQUIRE(rows.size() == 4);  // 8 to 64 of 160 beads
  CHECK(rows[3]["beads"] == 64);
  for (const auto& [by_rows, by_loads] :
       {std::pair("by_slope", "thrust_by_slope"), {"by_torque", "thrust_by_torque"}}) {
    const auto &one = rows[1][by_rows], &other = found[by_loads]["curvature"];
    CAPTURE(by_rows, value(one), error(one), value(other), error(other));
    CHECK(error(one) < 0.5);
    CHECK(std::abs(value(one) - value(other)) < 5 * std::hypot(error(one), error(other)));
  }
  const double sound = value(found["response"]["c_thrust"]);
  CHECK(std::abs(value(found["plateau"]["C_H_over_C_w"]) - sound * sound) <
        5 * error(found["plateau"]["C_H_over_C_w"]));
  // Both saturate as 1 - exp(-D k^2 z), with D of the dispersion relation, and not with twice that.
  const auto& saturation = found["saturation"];
  const int points = saturation["points"];
  CAPTURE(saturation.dump());
  REQUIRE(points >= 5);
  CHECK(saturation["chi2"].get<double>() < points + 5 * std::sqrt(2.0 * points));
  CHECK(saturation["chi2_with_twice_D"].get<double>() > 3 * (points + 5 * std::sqrt(2.0 * points)));
  // What the equation says about single waves, where they are known to 5 %.
  int waves = 0;
  double predicted_off = 0, without_torque_off = 0;
  for (std::size_t band = 0; band < found["response"]["dispersion"].size(); ++band) {
    const auto& D = found["response"]["dispersion"][band]["D"];
    if (error(D) > 0.05 * value(D)) continue;
    const auto off = [&](const char* theory) {
      return std::log(value(found[theory]["dispersion"][band]["D"]) / value(D));
    };
    CAPTURE(band, D.dump(), off("predicted"), off("without_torque"));
    CHECK(std::abs(off("predicted")) < 0.2);  // one loop
    predicted_off += std::pow(off("predicted"), 2);
    without_torque_off += std::pow(off("without_torque"), 2);
    ++waves;
  }
  CHECK(waves >= 3);
  CAPTURE(predicted_off, without_torque_off);
  CHECK(predicted_off < without_torque_off);
  // Deeper the thrust is a little less, long waves of torque having built up, under every load alike: the curvatures
  // stay.
  const auto& deeper = found["thrust_largest_change_with_depth"];
  CAPTURE(deeper.dump());
  CHECK(std::abs(value(deeper)) < 0.005 * value(found["thrust_by_slope"]["at_zero"]));
  for (const char* by : {"thrust_by_slope", "thrust_by_torque"}) {
    const auto& change = found[by]["curvature_deeper_less_here"];
    CAPTURE(by, change.dump());
    CHECK(error(change) < 0.5);
    CHECK(std::abs(value(change)) < 5 * error(change));
  }
  REQUIRE(found["thrust_twice_as_wide"].size() == 2);
  for (const auto& load : found["thrust_twice_as_wide"]) {
    const auto& change = load["wide_less_here"];
    CAPTURE(load.dump());
    CHECK(error(change) < 0.001);
    CHECK(std::abs(value(change)) < 5 * error(change));
  }
  CHECK(value(found["coupling_to_torque"]) > 10 * value(found["coupling_to_itself"]));
  const auto& strength = found["fit"]["strength"];
  CHECK(std::abs(value(strength) - 1) < 5 * error(strength) + 0.2);
  CHECK(found["predicted"]["octaves"].size() == 3);
  // The first octave is the measured one.
  CHECK(found["predicted"]["octaves"][0]["D"].get<double>() ==
        Approx(value(found["response"]["octaves"][0]["D"])).epsilon(1e-3));
  // Once more in wide piles, and by loads.
  REQUIRE(found["checks"].size() == 2);
  const auto& wide = found["checks"][0]["response"];
  CHECK(wide["columns"] == 320);
  CHECK(found["checks"][1]["response"]["estimator"] == "multiplexed");
  for (std::size_t octave = 0; octave < 3; ++octave) {
    const auto &one = found["response"]["octaves"][octave]["D"], &other = wide["octaves"][octave]["D"];
    CAPTURE(octave, value(one), value(other), error(other));
    CHECK(std::abs(value(one) - value(other)) < 5 * std::hypot(error(one), error(other)));
  }
  // Each has a prediction of its own, that of loads from the surface on; the couplings are the same.
  for (const auto& check : found["checks"]) {
    CAPTURE(check.dump());
    const auto& of_check = check["fit"]["strength"];
    CHECK(std::abs(value(of_check) - 1) < 5 * error(of_check) + 0.2);
    CHECK(check["predicted"]["octaves"][0]["D"].get<double>() ==
          Approx(value(check["response"]["octaves"][0]["D"])).epsilon(1e-3));
    CHECK(check["predicted"]["chi2"].get<double>() > 0);
  }
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
    piles.fit.strength = strength;
    piles.predicted.chi2 = with;
    piles.without_torque.chi2 = without;
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
