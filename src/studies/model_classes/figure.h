#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "measure.h"
#include "plot/figure.h"

namespace granuscope {

/// Those that are scanned together, with the power law of c0 - c against D.
struct ModelSeries {
  std::string name;
  std::vector<ModelResponse> responses;
  ScalingFit alpha;
};

/// The figure: c0 - c against D of all series with two peaks, and the response of the last of each series at the
/// deepest layer. Throws InputError where nothing was measured.
Figure plot_models(const std::vector<ModelSeries>& series, const std::string& study,
                   const std::filesystem::path& run_folder);

}  // namespace granuscope
