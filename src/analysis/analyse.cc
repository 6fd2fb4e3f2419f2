#include "analysis/analyse.h"

#include <algorithm>

#include "analysis/claims.h"
#include "analysis/scaling.h"

namespace granuscope {

Analysis analyse(const std::vector<MeasuredEnsemble>& ensembles, const FitSpec& spec,
                 const std::vector<int>& profile_layers, const std::map<std::string, std::string>& expected_verdicts,
                 int threads) {
  std::vector<MeasuredTransport> measured;
  for (const MeasuredEnsemble& ensemble : ensembles) {
    measured.push_back(measure_transport(ensemble, spec, profile_layers, threads));
  }
  std::sort(measured.begin(), measured.end(),
            [](const MeasuredTransport& a, const MeasuredTransport& b) { return a.transport.mu < b.transport.mu; });
  Analysis analysis;
  for (const MeasuredTransport& result : measured) analysis.results.push_back(result.transport);
  analysis.scaling = fit_scaling(measured, spec.scaling_window);
  for (const auto& window : spec.other_scaling_windows) analysis.other_windows.push_back(fit_scaling(measured, window));
  analysis.claims = judge_claims(analysis.results, analysis.scaling, expected_verdicts);
  return analysis;
}

}  // namespace granuscope
