// Exponents of made-up responses: two mirror Gaussians sampled at the bead centres, with c = x_p/z and D = W^2/z known.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>

#include "studies/made_up_ensemble.h"
#include "studies/study.h"

namespace granuscope {
std::unique_ptr<Study> literal_reading_study();  // as src/studies/study.cc declares it
}

using namespace granuscope;
using namespace granuscope::made_up;

namespace {

constexpr LatticeSpec size{240, 120};
const std::vector<int> depths{20, 60, 61, 62, 90};

/// Piles whose response at depth z is sampled at the bead centres, with x_p = `c` z + `offset` and W^2 = `D` z.
MeasuredEnsemble piles(double mu, double c, double D, double offset = 0) {
  MeasuredEnsemble ensemble = ensemble_of(mu, size, depths);
  const Lattice lattice(size);
  const auto gaussian = [](double u, double width) {
    return std::exp(-u * u / 2 / width / width) / (std::sqrt(2 * std::numbers::pi) * width);
  };
  add_quantity(ensemble.record.sums, "weight", size.columns, [&](int block, int row, int bead) {
    const int layer = depths[static_cast<std::size_t>(row)];
    const double z = Lattice::depth(layer), x = lattice.x(layer, bead), scatter = 1 + 1e-6 * ((block % 5) - 2);
    const double peak = (c * z + offset) * scatter, width = std::sqrt(D * z) * scatter;
    return 1 + (gaussian(x - peak, width) + gaussian(x + peak, width)) / 2;
  });
  return ensemble;
}

/// The study of the friction coefficients 0.1 to 0.3 with c0 - c = 0.06 mu^gamma and D = `prefactor` mu^beta.
std::unique_ptr<Study> reading_of(double gamma, double beta, double prefactor = 6) {
  auto study = literal_reading_study();
  MainLine main;
  main.fit.shallow_layer = 10;
  main.fit.scaling_window = {0.1, 0.3};
  for (const double mu : {0.1, 0.15, 0.2, 0.3}) {
    study->add_main(main, piles(mu, tan30 - 0.06 * std::pow(mu, gamma), prefactor * std::pow(mu, beta)));
  }
  study->begin(main, 1);
  study->finish();
  return study;
}

nlohmann::ordered_json read(double gamma, double beta, double prefactor = 6) {
  return reading_of(gamma, beta, prefactor)->json();
}

/// The claim of a study that is asked for.
Claim claim_of(double gamma, double beta) {
  const auto study = reading_of(gamma, beta);
  for (const Key& key : study->keys()) key.set(true);
  return study->claims({}).at(0);
}

}  // namespace

TEST_CASE("Read literally, made-up responses have the exponents that they were made with, at every depth") {
  const auto results = read(1, 2.5);
  REQUIRE(results["depths"].size() == depths.size());
  for (const auto& depth : results["depths"]) {
    INFO(depth.dump());
    CHECK(depth["gamma"]["value"].get<double>() == Approx(1).margin(1e-3));
    CHECK(depth["beta"]["value"].get<double>() == Approx(2.5).margin(1e-4));
    CHECK(depth["alpha"]["value"].get<double>() == Approx(0.4).margin(1e-3));
    CHECK(depth["gamma"]["stderr"].get<double>() > 0);
    CHECK(depth["meets_the_paper"].get<bool>());
  }
  CHECK(results["met"]["depths"] == depths.size());
  const auto& points = results["best"]["points"];
  REQUIRE(points.size() == 4);
  CHECK(points[3]["mu"] == 0.3);
  CHECK(points[3]["c"]["value"].get<double>() == Approx(tan30 - 0.06 * 0.3).margin(1e-5));
  CHECK(points[3]["D"]["value"].get<double>() == Approx(6 * std::pow(0.3, 2.5)).epsilon(1e-4));
  CHECK(points[3]["D"]["stderr"].get<double>() > 0);
  const auto other = read(1.67, 2.4);
  for (const auto& depth : other["depths"]) {
    CHECK(depth["gamma"]["value"].get<double>() == Approx(1.67).margin(2e-3));
    CHECK(depth["alpha"]["value"].get<double>() == Approx(1.67 / 2.4).margin(2e-3));
    CHECK_FALSE(depth["meets_the_paper"].get<bool>());
  }
  CHECK(other["met"]["depths"] == 0);
}

TEST_CASE("A shape integrated over a bead takes 1/12 off the squared width, and more of it where friction is small") {
  // Peaks much wider than a bead, so that 1/12 is all that matters: the exponent of W^2 - 1/12 follows by hand.
  const auto results = read(1, 2.5, 24);
  const double z = results["best"]["z"];
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const double mu : {0.1, 0.15, 0.2, 0.3}) {
    const double x = std::log(mu), y = std::log(24 * std::pow(mu, 2.5) - 1 / (12 * z));
    sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const double expected = (4 * sxy - sx * sy) / (4 * sxx - sx * sx);
  CHECK(expected > 2.51);
  for (const auto& reading : results["readings"]) {
    if (reading["change"] != "integrated_over_a_bead") continue;
    CHECK(reading["beta"]["value"].get<double>() == Approx(expected).margin(0.001));
    CHECK(reading["beta_shift"]["value"].get<double>() == Approx(expected - 2.5).margin(0.001));
    return;
  }
  FAIL("that reading is missing");
}

TEST_CASE("A depth that starts half a bead deeper is told from one that starts at the surface") {
  // Peaks that start at the load, x_p = c (z - 1/2): the ratio to z - 1/2 is c, and the one to z lies lower.
  const auto study = literal_reading_study();
  MainLine main;
  main.fit.shallow_layer = 10;
  for (const double mu : {0.1, 0.15, 0.2, 0.3}) {
    const double c = tan30 - 0.06 * mu;
    study->add_main(main, piles(mu, c, 6 * std::pow(mu, 2.5), -c / 2));
  }
  study->begin(main, 1);
  study->finish();
  const auto json = study->json();
  for (const auto& depth : json["depths"]) {
    CHECK(depth["from_load"]["gamma"]["value"].get<double>() == Approx(1).margin(1e-3));
    CHECK(depth["gamma"]["value"].get<double>() < 0.95);
  }
}

TEST_CASE("The exponents read at one depth are judged together, and the one that decides is shown") {
  const Claim met = claim_of(1, 2.5);
  CHECK(met.verdict == "reproduced");
  const Claim missed = claim_of(1, 1.8);
  CHECK(missed.verdict == "not reproduced");
  CHECK(missed.quantity.starts_with("α"));
  CHECK(missed.measured.value == Approx(1 / 1.8).margin(0.01));
  const auto readings = reading_of(1, 2.5)->readings();
  REQUIRE(readings.size() == 1);
  CHECK(readings[0].points.size() == 4);
  CHECK(readings[0].fits.gamma.exponent.value == Approx(1).margin(1e-3));
}
