#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "analysis/dispersion.h"
#include "analysis/jackknife.h"
#include "analysis/measured_ensemble.h"
#include "studies/study.h"

namespace granuscope {

/// The response over one lag, or in one layer below loads.
struct LagResponse {
  int lag = 0;
  double z = 0;            ///< its vertical distance, bead diameters; that of the layer from the top where loads act
  Estimate peak_position;  ///< x_p
  Estimate width_squared;  ///< W^2
  double chi2_per_dof = 0;
  double misfit = 0;  ///< share of the response that two Gaussians miss
};

/// What changes from one lag to the next, twice as long.
struct OctaveOfDepth {
  double from = 0, to = 0;  ///< z of the two lags
  Estimate exponent;        ///< p of W^2 proportional to z^p: log2 of the ratio of W^2
  Estimate c, D;            ///< slopes of x_p and W^2
  double misfit = 0;        ///< the larger one of the two lags
};

/// The power of z in W^2 from one recorded lag to another.
struct PowerOfDepth {
  double from = 0, to = 0;  ///< z
  Estimate exponent;
};

/// The measurement, or how it is made once more as a check.
enum class DeepMeasurement {
  fluctuations,  ///< of uniformly loaded, saturated piles
  wide,          ///< the same with twice the columns
  loads,         ///< the response to loads (multiplexed), from the surface on
};

/// The response over depths that double, at one friction coefficient.
struct DeepResponse {
  DeepMeasurement by = DeepMeasurement::fluctuations;
  EnsembleSpec spec;
  std::uint64_t samples = 0;
  std::vector<LagResponse> lags;
  std::vector<OctaveOfDepth> octaves;  ///< one less than lags
  std::vector<BandOfModes> bands;      ///< ascending in k, each over the octave that suits its decay; none by loads
  PowerOfDepth shallow;                ///< at depths that the paper's piles have, z = 55 to 111
  PowerOfDepth deep;                   ///< from the third lag before the last one to the last, at least z = 111
  Estimate c_thrust;                   ///< of the same layers
};

/// From an ensemble with such lags or layers.
DeepResponse measure_deep_response(const MeasuredEnsemble& ensemble, DeepMeasurement by, int threads);

/// Whether W^2 is proportional to z where the paper looked, and deeper; checks do not count.
std::vector<Claim> judge_spreading(const std::vector<DeepResponse>& measured, const ClaimSpec& spec);

/// Exponents against depth. Throws InputError where none is known.
Figure plot_deep_response(const std::vector<DeepResponse>& measured, const std::filesystem::path& run_folder);

/// c and D against the wave number. Throws InputError where none is known.
Figure plot_dispersion(const std::vector<DeepResponse>& measured, const std::filesystem::path& run_folder);

/// How the peaks move and spread far below where the main line looks: whether W^2 stays proportional to z.
std::unique_ptr<Study> deep_response_study();

}  // namespace granuscope
