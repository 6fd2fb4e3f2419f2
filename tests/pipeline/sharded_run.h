#pragma once
#include <filesystem>
#include <map>
#include <string>

#include "kit/small_experiment.h"
#include "pipeline/shards.h"
#include "quiet_run.h"
#include "support/files.h"

namespace granuscope {

/// Three friction coefficients and a study on tiny piles, with several ensembles of several kinds.
inline Experiment sharded_experiment(const std::string& estimator = "point") {
  const std::string layers = estimator == "fluctuation" ? "200" : "50";
  return parse_experiment(
      "[experiment]\nname = \"shards\"\n[lattice]\ncolumns = 60\nlayers = " + layers +
          "\n[friction]\nmu = [0.0, 0.3, 0.5]\n[sampling]\nseed = 5\n[response]\nestimator = \"" + estimator +
          "\"\nsamples = 100\nblocks = 9\n[fit]\nfirst_layer = 8\nlast_layer = 26\nlayer_step = 2\n"
          "shallow_layer = 4\nscaling_window = [0.2, 0.6]\n[figures.response_profiles]\nmu = 0.3\n"
          "layers = [10, 20]\n[scenes.force_chains]\nmu = 0.3\n[studies.redrawn_beads]\nmu = [0.3]\n"
          "samples = 80\n[studies.chain_share]\nsamples = 80\n",
      "shards.toml");
}

/// Every file below ensembles/, by its name.
inline std::map<std::string, std::string> ensembles_in(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "ensembles")) {
    if (!entry.is_regular_file()) continue;
    files[std::filesystem::relative(entry.path(), folder).string()] = read_file(entry.path());
  }
  return files;
}

inline std::map<std::string, std::string> undivided(const Experiment& experiment, const std::filesystem::path& folder) {
  run_experiment(experiment, quiet(folder, {Stage::sample}));
  return ensembles_in(folder);
}

}  // namespace granuscope
