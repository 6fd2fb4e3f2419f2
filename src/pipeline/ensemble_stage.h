#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"
#include "experiment/experiment.h"

namespace granuscope {

/// One ensemble: what it is, what for, and where it is kept.
struct PlannedEnsemble {
  std::string label;  ///< "mu = 0.3", in messages and timings
  EnsembleSpec spec;
  std::string estimator;       ///< what its numbers mean
  std::filesystem::path file;  ///< relative to the run's folder
  bool reusable = false;       ///< the file is there and holds exactly this ensemble
  std::string replaces = {};   ///< why a file that is there cannot be used: it will be replaced
};

/// Finds out whether the run's folder holds exactly this ensemble already, or something that it will replace.
void look_for(PlannedEnsemble& planned, const std::filesystem::path& run_folder);

/// One ensemble for each friction coefficient of the experiment. Without friction every pile is the same, so that one
/// group of samples for each block is enough. Only the layers that the fits and figures need are recorded.
std::vector<PlannedEnsemble> plan_ensembles(const Experiment& experiment, const std::filesystem::path& run_folder);

/// Reads the ensemble if it can be reused, otherwise draws it and keeps it: a finished ensemble survives whatever
/// happens later, and the next run goes on from there. One that turns out to be damaged is drawn again, and
/// planned.reusable becomes false.
MeasuredEnsemble obtain_ensemble(PlannedEnsemble& planned, const std::filesystem::path& run_folder, int threads,
                                 ProgressStyle progress);

}  // namespace granuscope
