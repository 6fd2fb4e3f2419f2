// Sources: the counts of a study of tiny piles drawn by other means in tests/sampling/diluted_beads_test.cc; made-up
// responses.
#include <catch2/catch.hpp>
#include <cmath>

#include "ensemble/ensemble_runner.h"
#include "kit/temporary_folder.h"
#include "kit/text_parts.h"
#include "plot/figure_texts.h"
#include "plot/synthetic_analysis.h"
#include "sampling/diluted_beads.h"
#include "studies/dilution.h"
#include "studies/study_page.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using synthetic::known;
using test::contains;
using test::TemporaryFolder;

namespace {

DilutedResponse response(double share, double position, double width, int peaks) {
  DilutedResponse made;
  made.mu = 0.3;
  made.share = share;
  made.columns = 20;
  made.layers = 15;
  made.samples = 512;
  made.z = 9.16;
  made.peaks = peaks;
  made.position = known(position, 0.01 * position);
  made.width = known(width, 0.01 * width);
  made.c = made.D = made.thrust_ratio = known(0.5, 0.01);
  ResponseProfile profile;
  profile.z = made.z;
  for (int x = -10; x < 10; ++x) {
    profile.x.push_back(x);
    profile.pressure.push_back(std::exp(-std::pow((std::abs(x) - position) / width, 2) / 2) / (5 * width));
    profile.standard_error.push_back(0.001);
  }
  made.profile = profile;
  return made;
}

DilutedPiles invented_piles() {
  DilutedPiles all;
  for (const double mu : {0.1, 0.3}) {
    for (const int size : {6, 9}) {
      for (const double share : {0.0, 0.05}) {
        SolvableShare& one = all.solvable.emplace_back();
        one.mu = mu;
        one.size = size;
        one.share = share;
        one.piles = 64;
        one.inside = share > 0 ? 16 : 64;
        one.edge = share > 0 ? 8 : 0;
        one.no_idle_bead = std::pow(1 - share * share, size * (size - 1));
      }
      all.largest.push_back({mu, size, 8, known(mu == 0.1 ? 0.1106 : 0.2163, 0.0023)});
    }
  }
  all.responses = {response(0, 3.9, 2.09, 2), response(0.08, 4.1, 1.84, 2)};
  return all;
}

}  // namespace

TEST_CASE("counts of solvable piles do not depend on threads and agree with piles tried one by one") {
  const auto found = measure_solvable_shares({0.3, 1.0}, {5}, {0.0, 0.06}, 40, 3, 1);
  const auto again = measure_solvable_shares({0.3, 1.0}, {5}, {0.0, 0.06}, 40, 3, 2);
  REQUIRE(found.size() == 4);
  for (std::size_t k = 0; k < found.size(); ++k) {
    CHECK(found[k].inside == again[k].inside);
    CHECK(found[k].edge == again[k].edge);
    if (found[k].share == 0) {
      CHECK(found[k].inside == 40);
      continue;
    }
    CHECK(found[k].no_idle_bead == Approx(std::pow(1 - 0.0036, 20)));
    std::uint64_t inside = 0;
    const Lattice lattice({5, 5});
    for (std::uint64_t pile = 0; pile < 40; ++pile) {
      const LargestSlack one =
          find_largest_slack(ContactBalances(found[k].mu, lattice), open_at_random(lattice, 0.06, RandomKey(3, pile)),
                             std::vector<double>(5, 1.0));
      inside += one.slack > slack_tolerance ? 1 : 0;
    }
    CHECK(found[k].inside == inside);
    CHECK(inside > 4);
    CHECK(inside < 40);
  }
  CHECK(found[1].inside < found[3].inside);  // less friction, fewer solutions
  CHECK(found[1].solvable().standard_error > 0);
  const SolvableShare none{.mu = 1, .size = 5, .share = 0.2, .piles = 99};
  CHECK(none.solvable().value == 0);
  CHECK(none.solvable().standard_error == Approx(std::sqrt(0.005 * 0.995 / 99)));
}

TEST_CASE("one after the other more contacts can be opened than leave most random piles solvable") {
  const auto one = measure_largest_shares({0.3}, {6}, 0.02, 6, 3, 1),
             two = measure_largest_shares({0.3}, {6}, 0.02, 6, 3, 2);
  CHECK(one[0].share.value == two[0].share.value);
  CHECK(one[0].share.value > 0.1);
  CHECK(one[0].share.value < 0.3);  // 6/5 of a quarter: the top layer keeps its contacts
  CHECK(one[0].share.standard_error > 0);
}

TEST_CASE("an ensemble of diluted piles has the same sums for every number of threads, and a mean response of 1") {
  EnsembleSpec spec;
  spec.sampler.mu = 0.5;
  spec.sampler.model.name = ModelName::diluted_beads;
  spec.sampler.model.diluted_beads.share = 0.06;
  spec.lattice = {10, 9};
  spec.response = multiplexed_response(0.2, true);
  spec.response.blocks = 8;
  spec.response.samples = 64;
  const EnsembleRecord one = run_ensemble(spec, 1, nullptr), two = run_ensemble(spec, 2, nullptr);
  CHECK(one.failed.empty());
  CHECK(one.sums.quantities.at("correlation").sum == two.sums.quantities.at("correlation").sum);
  FitSpec fit;
  fit.first_layer = fit.shallow_layer = 3;
  fit.last_layer = 6;
  fit.layer_step = 1;
  const DilutedResponse found = measure_diluted_response({spec, one}, fit, 1);
  CHECK(found.samples == 64);
  REQUIRE(found.profile);
  double sum = 0;
  for (const double one_bead : found.profile->pressure) sum += one_bead;
  CHECK(sum == Approx(1).epsilon(1e-9));
}

TEST_CASE("the report of opened contacts says whether the peaks merge, with tables and two figures") {
  DilutedPiles all = invented_piles();
  const std::string page = study_page(*dilution_study(all)).html;
  for (const char* text : {"do not merge", "0.2163(23)", "0.1106(23)", "0.250(54)", "4.100(41)"}) {
    INFO(text);
    CHECK(contains(page, text));
  }
  const TemporaryFolder run;
  const Figure solvable = plot_solvable_shares(all, run.path()), responses = plot_diluted_responses(all, run.path());
  check_at_widths_of_journals(run / "figures", solvable.id);
  check_at_widths_of_journals(run / "figures", responses.id);
  CHECK(contains(read_file(run.path() / "figures/solvable-piles-mu-0.3-size-9.csv"), "\n0.05,0.25,"));
  CHECK(contains(read_file(run.path() / "figures/diluted-response-mu-0.3.csv"), "\n0.08,4.1,"));
  // Colour and marker of W are those of a response, too: its points are told to be its own.
  CHECK(contains(read_file(run.path() / "figures/diluted-response.json"), "\"W, μ = 0.3\""));
  all.responses[1].peaks = 1;
  CHECK(contains(study_page(*dilution_study(all)).html, "merge the two peaks"));
  CHECK_THROWS_AS(plot_solvable_shares({}, run.path()), InputError);
  CHECK_THROWS_AS(plot_diluted_responses({}, run.path()), InputError);
}

TEST_CASE("a study of opened contacts refuses what cannot be measured") {
  const MainLine main;
  const auto with = [&](const std::vector<std::pair<std::string, KeyValue>>& values) {
    const auto study = dilution_study();
    for (Key& key : study->keys()) {
      for (const auto& [name, value] : values) {
        if (key.name == name) key.set(value);
      }
    }
    return study->find_problem(main);
  };
  using Numbers = std::vector<double>;
  using Integers = std::vector<std::int64_t>;
  CHECK_FALSE(with({{"mu", Numbers{0.3}}, {"sizes", Integers{6}}}));
  CHECK(with({{"mu", Numbers{0.3}}})->key == "studies.dilution.sizes");
  CHECK_FALSE(with({{"response_mu", Numbers{0.3}}}));
  CHECK(with({{"response_mu", Numbers{0.3}}, {"response_shares", Numbers{}}})->key ==
        "studies.dilution.response_shares");
  CHECK(with({{"response_mu", Numbers{0.3}}, {"columns", std::int64_t{10}}})->key == "studies.dilution.columns");
  CHECK(with({{"response_mu", Numbers{0.3}}, {"columns", std::int64_t{64}}, {"layers", std::int64_t{64}}})->key ==
        "studies.dilution.columns");
  CHECK(with({{"response_mu", Numbers{0.3}}, {"samples", std::int64_t{8}}})->key == "studies.dilution.samples");
}
