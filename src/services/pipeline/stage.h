#pragma once
#include <chrono>
#include <set>
#include <string>
#include <vector>

#include "report/report_data.h"
#include "support/progress.h"

namespace granuscope {
/// The stages of a run and what each needs: analyse needs sample, plot needs analyse, report needs analyse, plot and
/// render.
enum class Stage {
  sample,   ///< ensembles/*.h5
  analyse,  ///< fits, slopes, exponents, claims (kept in memory)
  render,   ///< piles/*.h5 and figures/force-chains.png
  plot,     ///< figures/*.svg, *.pdf with scripts and data
  report,   ///< summary.json, claims.xml, summary.md, report.html, report.pdf
};

std::string name_of(Stage stage);
std::set<std::string> names_of(const std::set<Stage>& stages);
/// Throws InputError naming the stages.
Stage stage_named(const std::string& name);

/// The stages asked for with all that they need; everything if none is asked for.
std::set<Stage> stages_needed(const std::vector<Stage>& asked_for);

/// Does a piece of work and adds its wall time to the line of a stage; a new line if there is none. Throws Interrupted
/// instead if that was asked for.
template <typename Work>
void timed(std::vector<StageTiming>& timings, const std::string& stage, Work work) {
  throw_if_interrupted();
  const auto start = std::chrono::steady_clock::now();
  work();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  for (StageTiming& timing : timings) {
    if (timing.stage == stage) {
      timing.seconds += elapsed.count();
      return;
    }
  }
  timings.push_back({stage, elapsed.count(), false});
}

}  // namespace granuscope
