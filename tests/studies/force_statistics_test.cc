#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>

#include "ensemble/ensemble_runner.h"
#include "ensemble/force_counts.h"
#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/figure_texts.h"
#include "studies/made_up_ensemble.h"
#include "studies/study_page.h"
#include "support/files.h"

namespace granuscope {

std::unique_ptr<Study> force_statistics_study();  // NOLINT(readability-redundant-declaration)

namespace {

using Json = nlohmann::ordered_json;

std::unique_ptr<Study> study_of(const std::vector<double>& mu, double samples, bool q_model) {
  auto study = force_statistics_study();
  for (const Key& key : study->keys()) {
    if (key.name == "mu") key.set(mu);
    if (key.name == "bands") key.set(std::vector<std::int64_t>{40});
    if (key.name == "samples") key.set(static_cast<std::int64_t>(samples));
    if (key.name == "columns") key.set(std::int64_t{200});
    if (key.name == "q_model") key.set(q_model);
  }
  return study;
}

/// Tails of piles whose forces have the density exp(-(w/scale)^k), counted with the noise of independent numbers.
Json tails_of(double scale, double k) {
  const auto study = study_of({0.1}, 256, false);
  const StudyEnsemble one = study->ensembles(MainLine{}).at(0);
  MeasuredEnsemble made = made_up::ensemble_of(0.1, one.spec.lattice, one.spec.layers);
  constexpr double piles_of_block = 32;  // so many that a wrong form is refused by a wide margin
  std::mt19937_64 random(3);
  double all = 0;
  const auto density = [&](std::size_t i) {
    return std::exp(-std::pow((static_cast<double>(i) + 0.5) / force_bins::per_unit / scale, k));
  };
  for (std::size_t i = 0; i < force_bins::values; ++i) all += density(i);
  made_up::add_quantity(made.record.sums, "force_counts", static_cast<int>(force_bins::width), [&](int, int, int bin) {
    const auto i = static_cast<std::size_t>(bin);
    if (i >= force_bins::mobilisation) return 0.0;
    const bool is_w = i < force_bins::normal;
    const double expected = piles_of_block * 200 * (is_w ? 1 : 2) * density(i % force_bins::values) / all;
    return std::poisson_distribution<int>(expected)(random) / piles_of_block;
  });
  made_up::add_quantity(made.record.sums, "force_moments", static_cast<int>(ForceMoment::count),
                        [](int, int, int) { return 0; });
  study->add(one, made);
  return study->json()["tails"];
}

}  // namespace

TEST_CASE("The forms of tails are found, and chi squared refuses the others") {
  struct Case {
    double k, scale;
    const char *right, *wrong;
  };
  for (const Case& one : {Case{1, 0.5, "exponential", "Gaussian"}, Case{2, 1.1, "Gaussian", "exponential"}}) {
    CAPTURE(one.right);
    const Json tails = tails_of(one.scale, one.k);
    REQUIRE(tails.size() == 2);
    for (const Json& tail : tails) {
      // In means, which are 1 of w and 1/sqrt 3 of N.
      const double mean = tail["force"] == "w" ? 1 : tan30, scale = tail[one.right]["scale"]["value"];
      const Json& power = tail["stretched"]["power"];
      INFO(tail.dump());
      CHECK(tail["points"] == 10);
      CHECK_FALSE(tail[one.right]["refused"]);
      CHECK_FALSE(tail["stretched"]["refused"]);
      CHECK(tail[one.wrong]["refused"]);
      CHECK(std::abs(scale - one.scale / mean) < 5 * tail[one.right]["scale"]["stderr"].get<double>());
      CHECK(std::abs(power["value"].get<double>() - one.k) < 5 * power["stderr"].get<double>());
      CHECK(power["stderr"] < 0.15);
      CHECK(tail["exponential"]["degrees_of_freedom"] == 8);
      CHECK(tail["stretched"]["degrees_of_freedom"] == 7);
    }
  }
}

TEST_CASE("Forces of sampled piles: moments, tails, a page and a figure") {
  const auto study = study_of({0.1, 0.3}, 1024, true);
  CHECK(study->asked());
  CHECK_FALSE(force_statistics_study()->asked());
  REQUIRE_FALSE(study->find_problem(MainLine{}));
  for (const StudyEnsemble& one : study->ensembles(MainLine{}))
    study->add(one, {one.spec, run_ensemble(one.spec, 0, nullptr)});
  study->finish();
  const Json json = study->json();
  REQUIRE(json["bands"].size() == 3);
  for (const Json& band : json["bands"]) {
    INFO(band.dump());
    // What every layer bears is the load.
    CHECK(band["weight_mean"]["value"].get<double>() == Approx(1).margin(1e-12));
    CHECK(band["weight_variance"]["stderr"] < 0.05 * band["weight_variance"]["value"].get<double>());
  }
  CHECK(json["bands"][0]["first_layer"] == 40);
  CHECK(json["bands"][0]["last_layer"] == 47);
  const Json q_tail = json["tails"].back();
  INFO(q_tail.dump());
  // 4 w exp(-2 w) has k = 1.19 over such a range; 44 layers down the largest weights are still missing. Half a million
  // such rows from a few lines of NumPy have the variance 0.436 there, on its way to 1/2.
  const double k = q_tail["stretched"]["power"]["value"];
  CHECK((k > 1.3 && k < 1.9));
  CHECK(json["bands"][2]["weight_variance"]["value"].get<double>() == Approx(0.4364).margin(0.005));
  CHECK(q_tail["Gaussian"]["refused"]);
  for (const int at : {1, 3}) {
    INFO(json["tails"][static_cast<std::size_t>(at)].dump());
    CHECK(json["tails"][static_cast<std::size_t>(at)]["exponential"]["refused"]);
  }
  const Page page = study_page(*study);
  CHECK(test::contains(page.texts.at("/studies/force_statistics/bands/0/weight_variance"), "("));
  const test::TemporaryFolder run;
  const Analysis main;
  const Figure figure = study->figures(main).at(0)(run.path());
  check_at_widths_of_journals(run / "figures", figure.id);
  CHECK(test::contains(figure.details, "(μ = 0.3)"));
  for (const char* file : {"mu-0.1-map", "q-model-weights"})
    CHECK(std::filesystem::exists(run.path() / "figures" / fmt::format("force-statistics-{}.csv", file)));
  // The last of the bins of 1/8 mean weight counts all larger forces, too.
  const std::string map = read_file(run / "figures" / "force-statistics-mu-0.1-map.csv");
  CHECK(test::contains(map, "\n2.8125,"));
  CHECK_FALSE(test::contains(map, "\n2.9375,"));
}

TEST_CASE("Bands of force statistics stay apart") {
  auto study = study_of({0.1}, 256, false);
  for (const Key& key : study->keys()) {
    if (key.name == "bands") key.set(std::vector<std::int64_t>{40, 44});
  }
  const Problem found = study->find_problem(MainLine{});
  REQUIRE(found);
  CHECK(found->key == "studies.force_statistics.bands");
}

}  // namespace granuscope
