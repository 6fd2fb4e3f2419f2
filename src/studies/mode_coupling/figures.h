#pragma once
#include <filesystem>
#include <vector>

#include "plot/figure_captions.h"
#include "studies/mode_coupling/measure.h"

namespace granuscope {

/// W^2/z against z, measured and predicted. Throws InputError where nothing is predicted.
Figure plot_predicted_width(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder);

/// What the coupling is made of: the thrust under leaning loads, and the fluctuations of layers at several depths.
Figure plot_coupling(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder);

/// The fluctuations of w and H against wave number in layers that deepen, beside the law by which they saturate; and
/// the D(k) of that law, measured and predicted. Throws InputError where nothing is predicted.
Figure plot_spectra(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder);

/// The right peak at several depths, each scaled by its own width, beside a Gaussian and the shape of the class.
/// Throws InputError where no shape is known.
Figure plot_peak_shape(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder);

}  // namespace granuscope
