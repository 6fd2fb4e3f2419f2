#include "history/comparison.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "pipeline/quiet_run.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using test::TemporaryFolder;
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

/// With the one figure whose layers are fitted for it.
Experiment plain_experiment() {
  Experiment small = unplotted(small_experiment());
  small.figures.response_profiles = true;
  return small;
}

/// One run for all cases, which only look at copies of it.
const fs::path& a_run() {
  static const TemporaryFolder folder;
  static const fs::path path = [] {
    run_experiment(plain_experiment(), quiet(folder.path() / "run"));
    return folder.path() / "run";
  }();
  return path;
}

void change(const fs::path& file, const std::function<void(Json&)>& edit) {
  Json json = Json::parse(read_file(file));
  edit(json);
  json.erase("digest");
  write_file(file, json.dump(2));
}

struct Copy {
  TemporaryFolder scratch;
  fs::path path = scratch.path() / "run";
  Copy() { fs::copy(a_run(), path, fs::copy_options::recursive); }
};

std::string answer(const Comparison& comparison) { return describe(comparison).front(); }

}  // namespace

TEST_CASE("A run compares as the same with itself, as folder and as summary alone, whatever its captions say") {
  const Copy copy;
  change(copy.path / "summary.json", [](Json& summary) { summary["figures"][0]["caption"] = "other words"; });
  for (const fs::path& other : {copy.path, copy.path / "summary.json"}) {
    const Comparison comparison = compare_runs(a_run(), other);
    CHECK(comparison.likeness == Likeness::same);
    CHECK_FALSE(comparison.alarms());
    CHECK(comparison.hash_before == comparison.hash_after);
  }
}

TEST_CASE("Other numbers of the same experiment: where, by how much, and why") {
  const Copy copy;
  const auto set_c = [&](double change_in_errors) {
    change(copy.path / "summary.json", [&](Json& summary) {
      Json& c = summary["results"][2]["c"];
      c["value"] = Json::parse(read_file(a_run() / "summary.json"))["results"][2]["c"]["value"].get<double>() +
                   change_in_errors * c["stderr"].get<double>();
    });
  };
  set_c(0.5);
  Comparison comparison = compare_runs(a_run(), copy.path);
  CHECK(comparison.likeness == Likeness::other_numbers);
  CHECK(comparison.where == FirstDifference::analysis);
  CHECK(comparison.place == "/results/2/c/value");
  CHECK(comparison.largest == Approx(0.5));
  CHECK(comparison.alarms());
  CHECK_THAT(describe(comparison).back(), Contains("summary.json: changed or damaged since its run"));
  // A run that came to other numbers itself has their digest.
  change(copy.path / "manifest.json", [&](Json& manifest) {
    std::erase_if(manifest["files"].get_ref<Json::array_t&>(),
                  [](const Json& file) { return file["path"] == "summary.json"; });
  });
  comparison = compare_runs(a_run(), copy.path);
  CHECK(comparison.causes.empty());
  CHECK_THAT(describe(comparison).back(), Contains("not reproducible"));
  set_c(1e-10);  // the same processor may be told to do without FMA
  CHECK_THAT(describe(compare_runs(a_run(), copy.path)).back(), Contains(": rounding, as by a C library without FMA"));

  // Another library, as loaded.
  change(copy.path / "manifest.json", [](Json& manifest) { manifest["provenance"]["libraries"]["GSL"] = "9.9"; });
  comparison = compare_runs(a_run(), copy.path);
  REQUIRE(comparison.causes.size() == 1);
  CHECK_THAT(comparison.causes[0], Contains("library GSL: 9.9"));
  CHECK_THAT(json_text(comparison), Contains("library GSL: 9.9"));

  set_c(1e-7);
  comparison = compare_runs(a_run(), copy.path);
  CHECK(comparison.is_rounding());
  CHECK_FALSE(comparison.alarms());
  CHECK_THAT(describe(comparison)[1], Contains("rounding"));

  // Of summaries alone nobody knows why.
  set_c(2);
  CHECK_THAT(describe(compare_runs(a_run() / "summary.json", copy.path / "summary.json")).back(),
             Contains("why is not known"));
}

TEST_CASE("Sums that differ are told as sampling, figures that differ as plotting") {
  const Copy copy;
  const auto spoil = [&](const std::string& path) {
    change(copy.path / "manifest.json", [&](Json& manifest) {
      for (Json& file : manifest["files"]) {
        if (file["path"] == path) file["sha256"] = "other";
      }
    });
  };
  spoil("figures/response-profiles.svg");
  Comparison comparison = compare_runs(a_run(), copy.path);
  CHECK(comparison.where == FirstDifference::plotting);
  CHECK_THAT(answer(comparison), Contains("figures/response-profiles.svg") && Contains("plotting"));
  // The same sums in other bytes are the same.
  spoil("ensembles/mu-0.3.h5");
  CHECK(compare_runs(a_run(), copy.path).where == FirstDifference::plotting);
  fs::copy_file(copy.path / "ensembles/mu-0.2.h5", copy.path / "ensembles/mu-0.3.h5",
                fs::copy_options::overwrite_existing);
  comparison = compare_runs(a_run(), copy.path);
  CHECK(comparison.where == FirstDifference::sampling);
  CHECK(comparison.place == "ensembles/mu-0.3.h5");
  CHECK(comparison.alarms());
}

TEST_CASE("Another seed is held against by its primary numbers, another law not at all") {
  const TemporaryFolder scratch;
  Experiment other = plain_experiment();
  other.sampling.seed = 12;
  run_experiment(other, quiet(scratch / "seed"));
  const Comparison seeds = compare_runs(a_run(), scratch / "seed");
  CHECK(seeds.likeness == Likeness::other_samples);
  CHECK_THAT(answer(seeds), Contains("sampling.seed = 12 where 11 was") && Contains("0 of "));
  CHECK(seeds.numbers.size() >= 9);  // of three friction coefficients and the frictionless pile
  CHECK_FALSE(seeds.alarms());
  CHECK(seeds.depths.size() > 20);
  // The same of the summaries alone.
  const Comparison summaries = compare_runs(a_run() / "summary.json", scratch / "seed/summary.json");
  CHECK(summaries.likeness == Likeness::other_samples);
  CHECK(summaries.numbers.size() == seeds.numbers.size());

  // A number that moved by more than chance allows.
  change(scratch / "seed/summary.json", [](Json& summary) {
    Json& c = summary["results"][2]["c"];
    c["value"] = c["value"].get<double>() + 20 * c["stderr"].get<double>();
  });
  const Comparison moved = compare_runs(a_run(), scratch / "seed");
  CHECK(moved.alarms());
  CHECK_THAT(describe(moved)[1], Contains("moved: c at mu = 0.3"));
  CHECK_THAT(moved.causes.at(0), Contains("seed/summary.json: changed or damaged since its run"));

  Experiment dealt = plain_experiment();
  dealt.response.blocks = dealt.response.blocks == 8 ? 16 : 8;
  run_experiment(dealt, quiet(scratch / "blocks"));
  CHECK(compare_runs(a_run(), scratch / "blocks").likeness == Likeness::other_samples);

  const std::string text = read_file(a_run() / "experiment.toml");
  const Copy copy;
  std::string edited = text;
  edited.replace(edited.find("columns = 120"), 13, "columns = 124");
  write_file(copy.path / "experiment.toml", edited);
  const Comparison different = compare_runs(a_run(), copy.path);
  CHECK(different.likeness == Likeness::other_experiment);
  CHECK_THAT(answer(different), Contains("lattice.columns = 124 where 120 was"));
  CHECK_THAT(describe(different).back(), Contains("experiment.toml: changed or damaged since its run"));
  // What the other keys follow from comes first.
  const auto changed = changed_keys({{"fit.last_layer", "9"}, {"model.name", "a"}, {"sampling.seed", "1"}},
                                    {{"fit.last_layer", "8"}, {"model.name", "b"}, {"sampling.seed", "2"}});
  REQUIRE(changed.size() == 3);
  CHECK(changed[0].key == "model.name");
  CHECK(changed[1].key == "fit.last_layer");
  // What is only told changes no experiment.
  edited = text;
  edited.replace(edited.find("name = \"small\""), 14, "name = \"other\"");
  write_file(copy.path / "experiment.toml", edited);
  CHECK(compare_runs(a_run(), copy.path).likeness == Likeness::same);
}

TEST_CASE("A summary that an earlier run left beside another experiment is compared with nothing") {
  const Copy copy;
  Experiment other = plain_experiment();
  other.sampling.seed = 12;
  run_experiment(other, quiet(copy.path, {Stage::sample}));
  CHECK(fs::exists(copy.path / "earlier-summary.json"));
  CHECK_THROWS_WITH(compare_runs(a_run(), copy.path), Contains("did not come to its report"));
  CHECK_THROWS_AS(compare_runs(copy.path, a_run()), InputError);
}

TEST_CASE("What is no run is refused with the reason") {
  const TemporaryFolder scratch;
  CHECK_THROWS_WITH(compare_runs(a_run(), scratch / "nothing"), Contains("neither a run nor a summary"));
  CHECK_THROWS_WITH(compare_runs(a_run(), scratch.path()), Contains("no summary.json"));
  write_file(scratch / "a.json", "{");
  CHECK_THROWS_WITH(compare_runs(a_run(), scratch / "a.json"), Contains("this is no JSON"));
  write_file(scratch / "b.json", "{}");
  CHECK_THROWS_AS(compare_runs(scratch / "b.json", a_run()), InputError);
  write_file(scratch / "c.json", "[1, 2]");
  CHECK_THROWS_AS(compare_runs(scratch / "c.json", a_run()), InputError);
}
