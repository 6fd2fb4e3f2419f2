#pragma once
#include <filesystem>
#include <vector>

#include "analysis/nonlinearity.h"
#include "analysis/side_measurements.h"
#include "analysis/small_friction.h"
#include "experiment/experiment.h"
#include "pipeline/ensemble_stage.h"

namespace granuscope {

/// What a side measurement is for.
enum class SideKind {
  redrawn_beads,
  counted_work,
  small_friction,
  chain_share,
  law_comparison,
  law_cost,
  nonlinearity
};

/// One small ensemble beside the main ones.
struct SideEnsemble {
  SideKind kind;
  PlannedEnsemble planned;
};

/// All that the experiment's tables [figures.*] ask for, in the order in which they are drawn.
std::vector<SideEnsemble> plan_side_ensembles(const Experiment& experiment, const std::filesystem::path& run_folder);

/// Collects side measurements, one ensemble after the other, so that few ensembles need to be in memory
/// at once.
class SideMeasurer {
 public:
  SideMeasurer(const Experiment& experiment, int threads)
      : nonlinearity_(experiment.fit, experiment.response.epsilon, threads) {}
  void add(const SideEnsemble& side, const MeasuredEnsemble& ensemble);
  SideMeasurements finish();

 private:
  SideMeasurements measured_;
  std::vector<MeasuredSmallFriction> small_friction_;
  NonlinearityMeasurer nonlinearity_;
};

}  // namespace granuscope
