#pragma once
#include <vector>

#include "experiment/experiment.h"
#include "pipeline/ensemble_stage.h"
#include "pipeline/pipeline.h"

namespace granuscope {

/// Processes that draw together with this one, in a folder that all of them see.
class Crew {
 public:
  Crew() = default;
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;
  virtual ~Crew() = default;

  /// Draws what is not there of these ensembles of the experiment, and returns when all are whole in the folder, or at
  /// least each of their blocks is in its file (block_files.h). Those that are reusable are left alone. What goes wrong
  /// with one of them is thrown here.
  virtual void draw(const Experiment& experiment, const RunOptions& options,
                    const std::vector<PlannedEnsemble>& ensembles) = 0;
};

}  // namespace granuscope
