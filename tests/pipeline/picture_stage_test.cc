#include "pipeline/picture_stage.h"

#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <vector>

#include "kit/png_image.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "support/files.h"

namespace granuscope {
namespace {

using Catch::Contains;
using test::TemporaryFolder;

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
  CHECK_THAT(scene_in(pictures / "force-chains.png"), Contains("900 px: forces; x -20 to 20"));
  CHECK_THAT(scene_in(pictures / "mobilised-friction.png"),
             Contains("900 px: friction; x -20 to 20") && Contains("|T| / (μN) from 0 to 1") && Contains("viridis"));
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
  REQUIRE(drawn.size() >= 4);
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
}  // namespace granuscope
