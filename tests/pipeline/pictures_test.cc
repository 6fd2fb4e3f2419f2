// Pictures and figures of a run.
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "kit/png_image.h"
#include "kit/search_path.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "pipeline/pipeline.h"
#include "quiet_run.h"
#include "support/files.h"
#include "support/process.h"

namespace granuscope {
namespace {

using Catch::Contains;
using Catch::Matchers::Contains;
using test::TemporaryFolder;
namespace fs = std::filesystem;

/// Width and what the picture says of its scene.
std::string scene_in(const std::filesystem::path& picture) {
  return std::to_string(test::read_png(picture).width) + " px: " + test::png_text(picture, "Scene");
}

TEST_CASE("the picture of the friction and those with names of their own are rendered of one pile, each as asked for") {
  const TemporaryFolder folder;
  Experiment experiment = small_experiment();
  experiment.force_chains.weight = experiment.force_chains.response = false;
  experiment.force_chains.friction = true;
  PictureSpec part;
  part.scene = "weight";
  part.window = {-6, 8, 2, 11};
  part.range = {0, 2.5};
  part.colour_map = "cividis";
  part.width_px = 700;
  experiment.pictures["part"] = part;
  experiment.pictures["change"].scene = "response";

  std::map<std::string, Figure> figures;
  for (const PictureOutcome& drawn : render_pile_pictures(experiment, folder.path(), Provenance{})) {
    figures[drawn.figure.id] = drawn.figure;
  }
  REQUIRE(figures.size() == 4);
  const std::filesystem::path pictures = folder / "figures";
  CHECK_THAT(scene_in(pictures / "force-chains.png"), Contains("1580 px: forces; x -20 to 20"));
  // A wide one has another for phones, where its text would be too small.
  CHECK_THAT(scene_in(folder.path() / figures.at("force-chains").narrow), Contains("661 px: forces; x -20 to 20"));
  CHECK(figures.at("mobilised-friction").narrow.empty());
  CHECK_THAT(scene_in(pictures / "mobilised-friction.png"),
             Contains("675 px: friction; x -20 to 20") && Contains("|T| / (μN) from 0 to 1") && Contains("viridis"));
  CHECK_THAT(scene_in(pictures / "picture-part.png"),
             Contains("700 px: weight; x -6 to 8, z 1.73") && Contains("from 0 to 2.5") && Contains("cividis"));
  CHECK_THAT(scene_in(pictures / "picture-change.png"),
             Contains("900 px: response; x -20 to 20") && Contains("diverging"));

  // What is said of them, and that the commands name what was asked for.
  CHECK_THAT(figures.at("mobilised-friction").details, Contains("|T| / (μN)") && Contains("40 × 20 beads"));
  CHECK_THAT(figures.at("mobilised-friction").redraw, Contains("--scene friction"));
  CHECK(figures.at("picture-part").title == "part: weight / top load");
  CHECK_THAT(figures.at("picture-part").details, Contains("6 to 8 in the layers 2 to 11"));
  CHECK_THAT(figures.at("picture-part").redraw, Contains("--window=-6") && Contains("--range=0") &&
                                                    Contains("--scene weight") && Contains("--colour-map cividis"));
}

TEST_CASE("pictures that cannot be written say why, and what is said of them is the same") {
  const TemporaryFolder whole, lacking;
  Experiment experiment = small_experiment();
  experiment.pictures["part"].scene = "weight";
  const std::vector<PictureOutcome> drawn = render_pile_pictures(experiment, whole.path(), Provenance{});
  write_file(lacking / "figures", "no folder");
  write_file(lacking / "piles", "no folder");
  const std::vector<PictureOutcome> failed = render_pile_pictures(experiment, lacking.path(), Provenance{});
  REQUIRE(failed.size() == drawn.size());
  REQUIRE(drawn.size() >= 3);
  for (std::size_t k = 0; k < drawn.size(); ++k) {
    INFO(drawn[k].figure.id);
    CHECK(drawn[k].figure.failure.empty());
    CHECK(drawn[k].figure.is_there());
    CHECK_THAT(failed[k].figure.failure, Contains("figures"));
    CHECK_FALSE(failed[k].figure.is_there());
    CHECK(failed[k].figure.id == drawn[k].figure.id);
    CHECK(failed[k].figure.title == drawn[k].figure.title);
    CHECK(failed[k].figure.caption == drawn[k].figure.caption);
  }
  CHECK(drawn.front().not_kept.empty());
  CHECK(failed.front().not_kept.size() == 3);  // the pile itself, and the pair under both loads
}

}  // namespace

// A figure that cannot be made costs nothing but itself.

namespace {

/// Script of a gnuplot that complains about scripts of this name, and else plots as always.
std::string fussy_gnuplot(const std::string& script) {
  const auto real = find_program("gnuplot");
  REQUIRE(real);
  return "case \"$2\" in " + script + ") echo '\"a.gp\" line 1: a warning' >&2;; esac\nexec " + real->string() +
         " \"$@\"";
}

Experiment experiment_with_few_figures() {
  Experiment experiment = small_experiment();
  experiment.mu = {0.0, 0.3};
  experiment.figures.propagation_against_diffusion = false;
  experiment.figures.scaling_with_friction = false;
  experiment.force_chains.show = false;
  experiment.report.pdf = false;
  return experiment;
}

std::string report_in(const fs::path& folder) { return read_file(folder / "report.html"); }

TEST_CASE("a figure that gnuplot does not draw is named in its place, and all else is made") {
  const TemporaryFolder whole, lacking;
  const Experiment experiment = experiment_with_few_figures();
  CHECK(run_experiment(experiment, quiet(whole.path())).failure.empty());
  CHECK(report_in(whole.path()).find("Not made.") == std::string::npos);

  {
    const test::FakePrograms programs(lacking / "programs");
    programs.only("gnuplot", fussy_gnuplot("response-profiles*"));
    const RunResult result = run_experiment(experiment, quiet(lacking.path()));
    CHECK_THAT(result.failure, Contains("figure response-profiles could not be made") && Contains("a warning"));
  }
  for (const char* file : {"summary.json", "summary.md", "claims.xml", "figures/transport-with-depth.svg"}) {
    INFO(file);
    CHECK(read_file(lacking / file) == read_file(whole / file));
  }
  CHECK_FALSE(fs::exists(lacking / "figures/response-profiles.svg"));
  const std::string report = report_in(lacking.path());
  const std::size_t title = report.find("id=\"fig-response-profiles\""), next = report.find("id=\"fig-", title + 1),
                    reason = report.find("a warning");
  REQUIRE(title != std::string::npos);
  CHECK(reason > title);
  CHECK(reason < next);
  CHECK(report.find("fonts-dejavu-core are as expected. Files of its name", reason) < next);
  CHECK(report.find("src=\"\"") == std::string::npos);  // no picture without contents
  const auto manifest = nlohmann::json::parse(read_file(lacking / "manifest.json"));
  CHECK(manifest["status"] == "failed");
  CHECK(manifest["exit_code"] == 3);
  CHECK_THAT(manifest["error"].get<std::string>(), Contains("response-profiles"));
  CHECK(manifest["files"].size() > 5);

  // The next run, with a gnuplot that works, has nothing left to sample and makes it whole.
  CHECK(run_experiment(experiment, quiet(lacking.path())).failure.empty());
  CHECK(read_file(lacking / "figures/response-profiles.svg") == read_file(whole / "figures/response-profiles.svg"));
  CHECK(nlohmann::json::parse(read_file(lacking / "manifest.json"))["status"] == "done");
}

TEST_CASE("a drawing of an earlier run stands for one that fails only if script and data are the same") {
  const TemporaryFolder folder;
  Experiment experiment = experiment_with_few_figures();
  run_experiment(experiment, quiet(folder.path()));
  const test::FakePrograms programs(folder / "programs");
  programs.only("gnuplot", fussy_gnuplot("*"));
  CHECK_THAT(run_experiment(experiment, quiet(folder.path())).failure, Contains("could not be made"));
  const std::string same = report_in(folder.path());
  CHECK(same.find("made from the same script and data by an earlier run") != std::string::npos);
  CHECK(same.find("data:image/svg+xml") != std::string::npos);

  experiment.sampling.seed = 12;
  CHECK_THAT(run_experiment(experiment, quiet(folder.path())).failure, Contains("could not be made"));
  CHECK(report_in(folder.path()).find("data:image/svg+xml") == std::string::npos);
}

}  // namespace

}  // namespace granuscope
