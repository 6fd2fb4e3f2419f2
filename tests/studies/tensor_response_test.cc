// Stresses below a point load: made-up waves that a closure relation makes, an elastic half plane, and the balance that
// sigma_xx is found by, against contacts.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <sstream>

#include "ensemble/ensemble_runner.h"
#include "ensemble/estimator.h"
#include "kit/sampling_statistics.h"
#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "model/lattice.h"
#include "model/pile.h"
#include "plot/figure_texts.h"
#include "report/number_text.h"
#include "sampling/sampler.h"
#include "studies/made_up_ensemble.h"
#include "studies/study.h"
#include "support/files.h"
#include "support/plain_text.h"

namespace granuscope {
std::unique_ptr<Study> tensor_response_study();  // as src/studies/study.cc declares it
}

using namespace granuscope;
using namespace granuscope::made_up;

namespace {

constexpr int columns = 240;
const std::vector<int> lags{0, 32, 33, 64, 65};

/// Two depths, of 32 and 64 layers.
void set_depths(Study& study) {
  for (const Key& key : study.keys()) {
    if (key.name == "first_lag") key.set(std::int64_t{32});
    if (key.name == "octaves") key.set(std::int64_t{1});
  }
}

/// The parts ww, HH, wH, Hw of a mode of wave number k at a depth in layers.
using Parts = std::array<double, 4>;

template <typename Propagator>
nlohmann::ordered_json tensor_json(Propagator parts_at, double kappa) {
  MeasuredEnsemble ensemble = ensemble_of(0.3, {columns, 200}, lags);
  add_quantity(ensemble.record.sums, "thrust", 1, [&](int, int, int) { return kappa; });
  add_quantity(ensemble.record.sums, "propagation", 2 * columns, [&](int block, int row, int i) {
    const int mode = i / 4 + 1;
    if (mode > 40) return 0.0;
    const Parts parts = parts_at(2 * std::numbers::pi * mode / columns, lags[static_cast<std::size_t>(row)]);
    return parts[static_cast<std::size_t>(i % 4)] * (1 + 1e-9 * (block % 3 - 1));
  });
  const auto study = tensor_response_study();
  set_depths(*study);
  study->add({}, ensemble);
  study->finish();
  return study->json().at(0);
}

/// Waves of sigma_xx = eta sigma_zz - nu d/dx sigma_xz and sigma_zx = sigma_xz, handed down layer by layer.
nlohmann::ordered_json closed(double eta, double nu) {
  return tensor_json(
      [&](double k, int layers) {
        using Complex = std::complex<double>;
        const Complex i(0, 1);
        const double cosine = std::cos(k / 2), sine = sqrt3 * std::sin(k / 2), slope = 2 * std::sin(k / 2);
        std::array<std::array<Complex, 2>, 2> fields{{{1, 0}, {0, 1}}};  // w and H of either load
        for (int n = 0; n < layers; ++n) {
          for (auto& [w, H] : fields) {
            const Complex xx = eta * w - nu * i * slope * H;
            const Complex next = cosine * w - i * sine * H;
            H = cosine * H - i * sine * xx;
            w = next;
          }
        }
        return Parts{fields[0][0].real(), fields[1][1].real(), fields[1][0].imag(), fields[0][1].imag()};
      },
      3 * eta);
}

/// 0 for a share that is no more than noise.
double value(const nlohmann::ordered_json& depth, const char* name) {
  const auto& number = depth.at(name);
  return number.contains("reason") && number.at("reason") == "no more than noise" ? 0
                                                                                  : number.at("value").get<double>();
}

/// The study at mu = 0.3 over two octaves of few beads.
std::unique_ptr<Study> few_beads(std::int64_t samples) {
  auto study = tensor_response_study();
  for (const Key& key : study->keys()) {
    if (key.name == "mu") key.set(std::vector<double>{0.3});
    if (key.name == "octaves") key.set(std::int64_t{1});
    if (key.name == "columns") key.set(std::int64_t{120});
    if (key.name == "samples") key.set(samples);
  }
  return study;
}

}  // namespace

namespace {

/// The file of all stresses: rows of z, x and, of each load, sigma_zz, sigma_xz and sigma_xx with their errors.
std::vector<std::vector<double>> stresses_of(const Study& study, const std::string& name) {
  const test::TemporaryFolder folder;
  REQUIRE(study.figures({}).at(0)(folder.path()).failure == "");
  std::istringstream lines(read_file(folder / "figures" / ("tensor-response-stresses-" + name + ".csv")));
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('z') || line.starts_with('#')) continue;
    std::vector<double> row;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

// Rays go straight: half of a vertical force passes along either, and half of a horizontal one over tan(angle) presses
// and pulls.
TEST_CASE("Without friction stresses are two peaks of one bead at z tan(angle), and sigma_xx is tan^2 sigma_zz") {
  for (const double angle : {30.0, 45.0}) {
    const BeadGeometry geometry(angle);
    const int ring = 201, first_lag = 33;  // odd: all modes are known, and beads lie at half-integer places
    MeasuredEnsemble ensemble = ensemble_of(0.3, {ring, 200, angle}, {0, first_lag, first_lag + 1});
    ensemble.record.sums.rows = rows_of({}, angle);
    MeasuredEnsemble loaded = ensemble;
    loaded.spec.response.estimator = EstimatorName::multiplexed;
    const auto wave = [&](int row, int mode) {
      return std::numbers::pi * mode / ring * ensemble.record.sums.layers[static_cast<std::size_t>(row)];
    };
    for (MeasuredEnsemble* one : {&ensemble, &loaded})
      add_quantity(one->record.sums, "thrust", 1, [](int, int, int) { return 1.0; });
    const auto jitter = [](int block) { return 1 + 1e-9 * (block % 3 - 1); };
    add_quantity(ensemble.record.sums, "propagation", 2 * ring, [&](int block, int row, int i) {
      const double phase = wave(row, i / 4 + 1), c = std::cos(phase), s = -std::sin(phase);
      if (i / 4 + 1 > ring / 2) return 0.0;
      return jitter(block) * Parts{c, c, s * geometry.cotangent, s * geometry.tangent}[static_cast<std::size_t>(i % 4)];
    });
    for (const bool of_w : {true, false}) {
      add_quantity(loaded.record.sums, of_w ? "correlation" : "correlation_H", ring, [&](int block, int row, int i) {
        const int mode = (i + 1) / 2;
        const double half_k = row == 1 ? std::numbers::pi * mode / ring : 0;  // beads count from the left one
        const std::complex<double> field =
            of_w ? std::cos(wave(row, mode)) : std::complex(0.0, -geometry.tangent * std::sin(wave(row, mode)));
        const std::complex<double> by_bead = field * std::polar(1.0, half_k);
        return jitter(row == 0 ? 0 : block) * (i % 2 == 1 || i == 0 ? by_bead.real() : by_bead.imag());
      });
    }
    const auto study = tensor_response_study();
    for (const Key& key : study->keys()) {
      if (key.name == "first_lag") key.set(std::int64_t{first_lag});
      if (key.name == "octaves") key.set(std::int64_t{0});
    }
    study->add({}, ensemble);
    study->add({.label = {}, .file = {}, .spec = {}, .part = 2}, loaded);
    for (const auto& one : study->json())
      CHECK(value(one.at("depths").at(0), "eta") == Approx(std::pow(geometry.tangent, 2)).epsilon(1e-6));
    CHECK(std::abs(value(study->json().at(0).at("depths").at(0), "nu")) < 1e-6);
    CHECK(study->json().at(1).at("depths").at(0).at("D").at("reason") == "loads do not measure it");
    nlohmann::ordered_json summary{{"results", nlohmann::ordered_json::array()}, {"tensor_response", study->json()}};
    for (auto& depth : summary["tensor_response"][0]["depths"]) depth["eta"] = nullptr;
    const std::string names = list_numbers(summary.dump(), "csv", {.all = true, .only = {}});
    CHECK_FALSE(test::contains(names, "tensor_response/mu-0.3/depths/1/eta,"));
    CHECK(test::contains(names, "tensor_response/mu-0.3-by-loads/depths/1/eta,"));
    const test::TemporaryFolder run;
    const std::string figure = study->figures({}).at(0)(run.path()).id;
    CHECK(test::contains(read_file(run / "figures" / (figure + ".json")), "μ = 0.3, by loads"));
    for (const bool by_loads : {false, true}) {
      // Where only the modes that carry weight are taken, peaks are wider than a bead.
      const auto rows = stresses_of(*study, by_loads ? "loads-mu-0.3" : "mu-0.3");
      REQUIRE(rows.size() > 20);
      for (const auto& row : rows) {
        INFO(angle << " degrees, x = " << row[1]);
        CHECK(row[6] == Approx(std::pow(geometry.tangent, 2) * row[2]).margin(1e-6));
        if (by_loads) continue;
        const double on_ray = std::abs(std::abs(row[1]) - 16.5 * geometry.twice_sine) < 1e-9 ? 0.5 : 0;
        const double side = row[1] > 0 ? 1 : -1;
        CHECK(row[2] == Approx(on_ray).margin(1e-6));
        CHECK(row[4] == Approx(side * on_ray * geometry.tangent).margin(1e-6));
        CHECK(row[8] == Approx(side * on_ray * geometry.cotangent).margin(1e-6));
        CHECK(row[10] == Approx(on_ray).margin(1e-6));
        CHECK(row[12] == Approx(side * on_ray * geometry.tangent).margin(1e-6));
      }
    }
  }
}

// Legs that may pull share weight in the same way whatever they bear, so that the mean obeys the same rule as each
// pile: sigma_xx = (1 - p)/3 sigma_zz, and the mean response is the product of the mean rules.
TEST_CASE("Below three linear legs the stresses are those of the mean rule, within their errors") {
  SamplerSpec sampler;
  sampler.model.name = ModelName::three_leg;
  sampler.mu = 0.3;  // for the name of the file alone
  const double p = sampler.model.three_leg.middle;
  MeasuredEnsemble ensemble;
  ensemble.spec.sampler = sampler;
  ensemble.spec.response.estimator = EstimatorName::fluctuation;
  ensemble.spec.response.samples = 256;
  constexpr int ring = 64;
  ensemble.spec.lattice = {ring, 1};
  ensemble.spec.layers = {8, 9, 16, 17};
  ensemble.spec.lattice.layers = 200;
  ensemble.record = run_ensemble(ensemble.spec, 0, nullptr);
  // The model's horizontal force is in units of tan 30 degrees.
  QuantitySums& propagation = ensemble.record.sums.quantities.at("propagation");
  for (std::size_t i = 0; i < propagation.sum.size(); ++i)
    propagation.sum[i] /= std::array{1.0, 3.0, sqrt3, sqrt3}[i % 4];
  const auto study = tensor_response_study();
  for (const Key& key : study->keys()) {
    if (key.name == "first_lag") key.set(std::int64_t{8});
    if (key.name == "octaves") key.set(std::int64_t{1});
  }
  study->add({}, ensemble);
  const auto result = study->json().at(0);
  INFO(result.dump(1));
  for (const auto& depth : result.at("depths")) {
    const auto& eta = depth.at("eta");
    CHECK(std::abs(eta.at("value").get<double>() - (1 - p) / 3) < 5 * eta.at("stderr").get<double>());
    CHECK(eta.at("stderr").get<double>() < 0.01);
  }
  const int modes = std::ranges::min(fluctuation_plan(ensemble.spec).modes);
  double squares = 0;
  std::size_t count = 0;
  for (const auto& row : stresses_of(*study, "mu-0.3")) {
    const int legs = static_cast<int>(std::lround(row[0] / sqrt3 - 0.5));
    double exact_w = 1.0 / ring, exact_H = 0;
    for (int mode = 1; mode <= modes; ++mode) {
      const double k = 2 * std::numbers::pi * mode / ring;
      std::complex<double> w = 1, H = 0;
      for (int n = 0; n < legs; ++n) {
        const std::complex<double> next = (p + (1 - p) * std::cos(k)) * w - std::complex(0.0, sqrt3 * std::sin(k)) * H;
        H = std::cos(k) * H - std::complex(0.0, (1 - p) / sqrt3 * std::sin(k)) * w;
        w = next;
      }
      const std::complex<double> turn = std::polar(2.0 / ring, k * row[1]);
      exact_w += (w * turn).real();
      exact_H += (H * turn).real();
    }
    for (const auto& [column, exact] :
         {std::pair<std::size_t, double>{2, exact_w}, {4, exact_H}, {6, (1 - p) / 3 * exact_w}}) {
      INFO("z = " << row[0] << ", x = " << row[1] << ", column " << column);
      CHECK(std::abs(row[column] - exact) <= 5.5 * row[column + 1]);
      if (row[column + 1] == 0) continue;  // in the middle, by symmetry
      squares += std::pow((row[column] - exact) / row[column + 1], 2);
      ++count;
    }
  }
  CHECK(count > 100);
  CHECK(squares < 2 * static_cast<double>(count));
}

namespace {

/// sigma_zz, sigma_xz and sigma_xx of contacts.
std::array<double, 3> stresses_at(const Pile& pile, std::size_t at) {
  return {pile.V_R[at] + pile.V_L[at], pile.H_R[at] + pile.H_L[at], (pile.H_R[at] - pile.H_L[at]) / sqrt3};
}

}  // namespace

// Source: piles in which one bead bears a torque, drawn one by one, and nothing but means over them.
TEST_CASE("The stresses below a torque are those of piles with one bead that is turned", "[unsanitized]") {
  for (const double mu : {0.1, 0.3, 0.8}) {
    constexpr int ring = 25, lag = 4, piles = 40'000;
    const auto study = tensor_response_study();
    for (const Key& key : study->keys()) {
      if (key.name == "mu" || key.name == "couple_mu") key.set(std::vector<double>{mu});
      if (key.name == "first_lag") key.set(std::int64_t{lag});
      if (key.name == "octaves") key.set(std::int64_t{0});
      if (key.name == "columns") key.set(std::int64_t{ring});
      if (key.name == "samples") key.set(std::int64_t{2048});
    }
    EnsembleSpec couples;
    for (const StudyEnsemble& one : study->ensembles(MainLine{})) {
      couples = one.spec;
      study->add(one, {one.spec, run_ensemble(one.spec, 2, nullptr)});
    }
    const auto rows = stresses_of(*study, "couples-mu-" + exact(mu));
    REQUIRE(rows.size() >= 9);
    const Lattice lattice(couples.lattice);
    const auto sampler = make_sampler(couples.sampler, lattice);
    couples.sampler.load_offset *= -1;
    const auto opposite = make_sampler(couples.sampler, lattice);
    couples.sampler.load_offset *= -1;
    std::vector<double> load(ring, 1.0);
    load[static_cast<std::size_t>(lattice.middle())] += couples.response.epsilon;
    const double torque = couples.response.epsilon * couples.sampler.load_offset;
    std::vector<std::array<test::RunningMean, 3>> found(ring / 2 + 1);
    Pile pile(lattice), other(lattice);
    for (std::uint64_t sample = 0; sample < piles / 2; ++sample) {
      if (sampler->draw(sample, load, pile) || opposite->draw(sample, load, other)) continue;
      for (std::size_t k = 0; k < lattice.beads(); ++k) {
        for (auto force : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L})
          (pile.*force)[k] = ((pile.*force)[k] - (other.*force)[k]) / 2;
      }
      for (int x = 0; x <= ring / 2; ++x) {
        const auto right = stresses_at(pile, lattice.index(lag, (lattice.middle() + x) % ring));
        const auto left = stresses_at(pile, lattice.index(lag, (lattice.middle() - x + ring) % ring));
        for (std::size_t part = 0; part < 3; ++part)
          found[static_cast<std::size_t>(x)][part].add((right[part] + (part == 1 ? 1 : -1) * left[part]) / 2 / torque);
      }
    }
    double squares = 0, largest = 0, moment = 0;
    int count = 0;
    for (const auto& row : rows) {
      const auto x = static_cast<int>(std::lround(std::abs(row[1])));
      moment += row[1] * row[2];
      for (std::size_t part = 0; part < 3; ++part) {
        const auto brute = found[static_cast<std::size_t>(x)][part].estimate();
        const double sign = part != 1 && row[1] < 0 ? -1 : 1, error = std::hypot(row[3 + 2 * part], brute.error);
        const double away = (row[2 + 2 * part] - sign * brute.value) / error;
        INFO("mu = " << mu << ", x = " << row[1] << ", stress " << part << ": " << row[2 + 2 * part] << " +- "
                     << row[3 + 2 * part] << ", one by one " << sign * brute.value << " +- " << brute.error);
        if (error == 0) continue;
        CHECK(std::abs(away) < 5);
        if (row[1] < 0) continue;  // the mirror image
        squares += away * away, ++count;
        if (std::abs(brute.value) > largest) largest = std::abs(brute.value);
      }
    }
    CAPTURE(mu, squares, count, largest, moment);
    CHECK(squares < 2 * count);
    CHECK(largest > 0.1);
    // Moments about the bead: the first layer has turned the torque round, each even one has it as it was.
    CHECK(std::abs(moment) < 0.5);
  }
}

TEST_CASE("Waves that one ratio closes are told by that ratio, and nothing is missed") {
  const auto one = closed(0.31, 0);
  REQUIRE(one.at("depths").size() == 2);
  CHECK(value(one, "c_thrust_squared") == Approx(0.31).epsilon(1e-9));
  for (const auto& depth : one.at("depths")) {
    INFO(depth.dump());
    CHECK(value(depth, "eta") == Approx(0.31).epsilon(1e-6));
    CHECK(value(depth, "missed") < 1e-5);
    CHECK(value(depth, "missed_horizontal") < 1e-5);
    CHECK(std::abs(value(depth, "nu")) < 1e-6);
    // What the lattice damps: D = (1 - 3 eta)/(2 sqrt(3)) of long waves.
    CHECK(value(depth, "D_from_nu") == Approx(0.07 / (2 * sqrt3)).epsilon(1e-4));
    CHECK(value(depth, "D") == Approx(0.07 / (2 * sqrt3)).epsilon(0.1));
  }
  CHECK(one.at("depths")[0].at("z") == Approx(32.5 * sqrt3 / 2));
}

TEST_CASE("A gradient beside the ratio is found with its coefficient, and is what damps the waves") {
  for (const double nu : {0.05, 0.2}) {
    const auto one = closed(0.3, nu);
    for (const auto& depth : one.at("depths")) {
      INFO(depth.dump());
      CHECK(value(depth, "eta_beside_gradient") == Approx(0.3).epsilon(1e-6));
      CHECK(value(depth, "nu") == Approx(nu).epsilon(1e-5));
      CHECK(value(depth, "missed_beside_gradient") < 1e-4);
      CHECK(value(depth, "missed") > 10 * value(depth, "missed_beside_gradient"));
      CHECK(value(depth, "D") == Approx(value(depth, "D_from_nu")).epsilon(0.1));
    }
  }
}

TEST_CASE("An elastic half plane is closed by no ratio: the best one misses sqrt(4/5) of sigma_xx") {
  const auto one = tensor_json(
      [](double k, int layers) {
        const double kz = k * layers * sqrt3 / 2, decay = std::exp(-kz);
        return Parts{(1 + kz) * decay, (1 - kz) * decay, -kz * decay, -kz * decay};
      },
      3);
  // Deep enough that the modes, of steps 2 pi/240, make up the integral over k: but for a share of some k.
  CHECK(value(one.at("depths")[0], "missed") == Approx(std::sqrt(0.8)).epsilon(0.04));
  CHECK(value(one.at("depths")[0], "missed_beside_gradient") > 0.1);
}

TEST_CASE("The balance that sigma_xx is found by holds in every pile: its contacts say the same") {
  SamplerSpec spec;
  spec.mu = 0.4;
  const Lattice lattice({60, 40});
  std::vector<double> load(60, 1.0);
  load[30] = 2;
  Pile pile(lattice);
  REQUIRE_FALSE(make_sampler(spec, lattice)->draw(7, load, pile));
  using Complex = std::complex<double>;
  const auto mode = [&](int layer, double k, double of_left) {
    Complex sum = 0;
    for (int bead = 0; bead < 60; ++bead) {
      const std::size_t at = static_cast<std::size_t>(layer) * 60 + static_cast<std::size_t>(bead);
      sum += (pile.H_R[at] + of_left * pile.H_L[at]) * std::polar(1.0, -k * lattice.x(layer, bead));
    }
    return sum;
  };
  for (int m = 1; m < 30; ++m) {
    const double k = 2 * std::numbers::pi * m / 60;
    for (int layer = 0; layer < 39; ++layer) {
      const Complex xx = mode(layer, k, -1) / sqrt3;
      const Complex told = std::cos(k / 2) * mode(layer, k, 1) - Complex(0, sqrt3 * std::sin(k / 2)) * xx;
      CHECK(std::abs(mode(layer + 1, k, 1) - told) < 1e-11);
    }
  }
}

TEST_CASE("Stresses of real piles: few beads miss little of the closure, and what is told is plotted") {
  const auto study = few_beads(512);
  for (const Key& key : study->keys()) {
    if (key.name == "loaded_mu" || key.name == "couple_mu") key.set(std::vector<double>{0.3});
  }
  MainLine main;
  REQUIRE_FALSE(study->find_problem(main));
  const auto ensembles = study->ensembles(main);
  REQUIRE(ensembles.size() == 3);
  CHECK(ensembles[0].spec.layers == std::vector<int>{16, 17, 32, 33});
  for (const StudyEnsemble& one : ensembles) study->add(one, {one.spec, run_ensemble(one.spec, 0, nullptr)});
  study->finish();
  const auto json = study->json();
  const auto& depth = json.at(0).at("depths").at(1);
  INFO(json.dump(1));
  const double c2 = value(json.at(0), "c_thrust_squared");
  CHECK(c2 == Approx(0.309).margin(0.002));
  CHECK(std::abs(value(depth, "eta") / c2 - 1) < 0.05);
  CHECK(value(depth, "missed") < 0.4);
  CHECK(value(depth, "missed_beside_gradient") < value(depth, "missed"));
  CHECK(value(depth, "D_from_nu") == Approx(value(depth, "D")).epsilon(0.25));
  const test::TemporaryFolder folder;
  const Figure figure = study->figures({}).at(0)(folder.path());
  CHECK(figure.id == "tensor-response");
  CHECK(figure.failure == "");
  CHECK(test::contains(figure.caption, "A torque (μ = 0.3)"));
  // Each load has its panel, and no dashed curve is without a name, or shares it with another one.
  const auto plot = nlohmann::ordered_json::parse(read_file(folder / "figures/tensor-response.json")).at("plot");
  std::vector<std::string> axes;
  std::map<std::string, std::set<int>> dashes;
  for (const auto& panel : plot.at("panels")) {
    axes.push_back(panel.at("y").at("name"));
    for (const auto& curve : panel.at("curves")) dashes["plotted"].insert(curve.at("dash").get<int>());
  }
  CHECK(axes == std::vector<std::string>{"σ, load along z", "σ, load along x", "σ, torque", "share of σxx missed",
                                         "η / (c₀² κ)"});
  for (const auto& entry : plot.at("key").at("entries")) {
    dashes["named"].insert(entry.at("dash").get<int>());
    CHECK(dashes[fmt::format("{} {}", entry.at("colour").get<std::string>(), entry.at("dash").get<int>())]
              .insert(entry.at("marker").get<int>())
              .second);
  }
  CHECK(dashes["plotted"] == dashes["named"]);
  check_at_widths_of_journals(folder / "figures", figure.id);
}

TEST_CASE("Where nothing is missed but noise, the figure of the stresses is drawn without that share") {
  const auto study = few_beads(256);
  const StudyEnsemble ensemble = study->ensembles(MainLine{}).at(0);
  study->add(ensemble, {ensemble.spec, run_ensemble(ensemble.spec, 0, nullptr)});
  study->finish();
  const auto json = study->json();
  INFO(json.dump(1));
  for (const auto& depth : json.at(0).at("depths")) CHECK(depth.at("missed_beside_gradient").at("value").is_null());
  const test::TemporaryFolder folder;
  CHECK(study->figures({}).at(0)(folder.path()).failure == "");
}
