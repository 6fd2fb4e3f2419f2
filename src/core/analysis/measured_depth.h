#pragma once
#include <cstddef>
#include <optional>

#include "analysis/fit_spec.h"
#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "analysis/results.h"
#include "analysis/shape_diagnostics.h"

namespace granuscope {

/// Why a fit of shape_diagnostics.h is not known.
inline constexpr const char* no_extended_fit = "the fit with one parameter more did not converge";

/// The response at one layer with its replicates.
struct MeasuredDepth {
  DepthFit fit;
  bool other_shape = false;  ///< why it is not identifiable
  Replicated peak, width, width_squared, thrust;
  Replicated peak_by_equal, width_squared_by_equal;  ///< from ModeWeights::equal
  /// What is measured of two peaks inside the window; nothing if not identifiable or exact.
  struct Inside {
    Replicated height;
    ShapeDiagnostics diagnostics;
    ResidualNoise noise;
  };
  std::optional<Inside> inside;
};

/// The response at recorded layer number `row`: by a fit of two Gaussians, or where there is no scatter by its moments.
/// The verdict on the shape is chi^2 by the noise of this layer; x_p and W go by weights that do not look at it
/// (shape_fit.h).
MeasuredDepth measure_depth(const MeasuredEnsemble& ensemble, const FitSpec& spec, std::size_t row);

/// x_p and W^2 of it alone, without replicates.
MeasuredDepth measure_depth_values(const MeasuredEnsemble& ensemble, const FitSpec& spec, std::size_t row);

}  // namespace granuscope
