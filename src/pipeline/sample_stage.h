#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "analysis/precision.h"
#include "analysis/transport.h"
#include "model/sampler_counts.h"
#include "pipeline/ensemble_stage.h"
#include "pipeline/pipeline.h"
#include "report/report_data.h"

namespace granuscope {

/// Obtains the ensembles of one run, one after the other, and keeps account of it in the data of the report.
class SampleStage {
 public:
  /// `earlier`: what each stage took in an earlier run. `drawn` is called whenever an ensemble has been drawn. All must
  /// outlive this object.
  SampleStage(const Experiment& experiment, const RunOptions& options, ReportData& data,
              const std::map<std::string, StageTiming>& earlier, std::function<void()> drawn)
      : experiment_(experiment), options_(options), data_(data), earlier_(earlier), drawn_(std::move(drawn)) {}

  MeasuredEnsemble obtain(PlannedEnsemble& planned);

  /// Lets the crew, if there is one, draw what is not there of these ensembles.
  void draw_by_crew(const std::vector<PlannedEnsemble>& ensembles);

  /// Lets a growing ensemble grow until its c and D are as precise as asked, which is looked at after whole steps only.
  PrecisionOutcome reach_precision(PlannedEnsemble& planned, MeasuredEnsemble& ensemble);

  /// Tells how many ensembles were there already.
  void tell_reuse();

  /// A bead that only rounding puts outside its band is put onto its end; how often is part of the numerics. `counts`:
  /// of the main ensembles.
  void tell_rounding(const SamplerCounts& counts);

 private:
  std::string time_for(const EnsembleSpec& spec, std::uint64_t samples) const;

  const Experiment& experiment_;
  const RunOptions& options_;
  ReportData& data_;
  const std::map<std::string, StageTiming>& earlier_;
  std::function<void()> drawn_;
  std::set<std::filesystem::path> drawn_by_crew_;        ///< in this run: they are there, and yet not reused
  std::size_t obtained_ = 0, reused_ = 0;                ///< ensembles
  double drawn_in_this_run_ = 0, drawn_in_seconds_ = 0;  ///< beads, for the time that is left
};

}  // namespace granuscope
