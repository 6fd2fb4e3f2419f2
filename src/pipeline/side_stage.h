#pragma once
#include <filesystem>
#include <vector>

#include "analysis/side_measurements.h"
#include "experiment/experiment.h"
#include "pipeline/ensemble_stage.h"

namespace granuscope {

/// What a side measurement is for.
enum class SideKind { law_comparison, law_response, exact_thrust, law_cost };

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
  SideMeasurer(int threads) : threads_(threads) {}
  /// `seconds`: what drawing the ensemble took, NaN if unknown.
  void add(const SideEnsemble& side, const MeasuredEnsemble& ensemble, double seconds);
  /// For each of the laws on piles.
  const std::vector<double>& law_seconds() const { return law_seconds_; }
  SideMeasurements finish();

 private:
  SideMeasurements measured_;
  int threads_;
  std::vector<double> law_seconds_;
};

}  // namespace granuscope
