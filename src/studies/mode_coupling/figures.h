#pragma once
#include <filesystem>
#include <vector>

#include "plot/figure_captions.h"
#include "studies/mode_coupling/fields.h"

namespace granuscope {

/// W^2/z against z, measured and predicted. Throws InputError where nothing is predicted.
Figure plot_predicted_width(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder);

/// D(k) and c(k) - c_thrust of waves, beside the form. Throws InputError where nothing is known of waves.
Figure plot_waves(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder);

/// The right peak at several depths, each scaled by its own width, beside a Gaussian, the shape of the class and the
/// form. Throws InputError where no shape is known.
Figure plot_peak_shape(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder);

}  // namespace granuscope
