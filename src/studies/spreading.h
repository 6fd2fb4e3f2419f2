#pragma once
#include <nlohmann/json_fwd.hpp>

#include "analysis/dispersion.h"
#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
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
  /// From fits of the cosines with a background spread evenly between the peaks (analysis/shape_fit.h).
  Estimate between = {};           ///< its share of the response
  double chi2_beside_per_dof = 0;  ///< with it
};

/// What changes from one lag to the next, twice as long.
struct OctaveOfDepth {
  double from = 0, to = 0;  ///< z of the two lags
  Estimate exponent;        ///< p of W^2 proportional to z^p: log2 of the ratio of W^2
  Estimate c, D;            ///< slopes of x_p and W^2
  double misfit = 0;        ///< the larger one of the two lags
  Estimate c_minus_c_thrust = {};
  Estimate between = {};                  ///< of the deeper lag
  Estimate c_beside = {}, D_beside = {};  ///< slopes beside a background between the peaks
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
  std::vector<OctaveOfDepth> octaves;       ///< one less than lags
  std::vector<Replicated> slopes_of_width;  ///< their D, empty where that is unknown
  std::vector<BandOfModes> bands;   ///< ascending in k, each over the octave that suits its decay; none by loads
  PowerOfDepth shallow;             ///< at depths that the paper's piles have, z = 55 to 111
  PowerOfDepth deep;                ///< from the third lag before the last one to the last, at least z = 111
  Estimate c_thrust;                ///< of the same layers
  Estimate effective_samples = {};  ///< of chains, from the same layers (analysis/jackknife.h)
  FlatTest flat = {};               ///< likewise
};

/// Longer than the usual reference lag: modes that only shorter ones have are drowned in noise.
inline constexpr int usual_first_lag = 32;
/// The key of the depth from which depths double.
Key first_lag_key(const std::string& table, int& first_lag);
/// The key of how many neighbouring loads are varied alike, and what is wrong with a number of them.
Key loaded_run_key(const std::string& table, int& run);
Problem find_run_problem(const std::string& key, int run, int columns);

/// Piles whose fluctuations are followed over lags that double `octaves` times from `first_lag` on, from those of one
/// friction coefficient and size: as many bases as the deepest lag has layers, half of each pile.
EnsembleSpec spec_of_lags(EnsembleSpec spec, int first_lag, int octaves);

/// Whether the two peaks are apart on a ring at each of these lags, however often they have met on the way there; the
/// number of columns that is offered suits all of `mu`.
Problem find_ring_problem(const std::string& columns_key, int columns, const std::vector<double>& mu,
                          const std::vector<int>& lags);

/// The piles of a check, from those that are measured by fluctuations. `epsilon` and `run`: of its loads, and how many
/// neighbours are varied alike.
EnsembleSpec spec_of_check(EnsembleSpec spec, DeepMeasurement by, double epsilon, int run = 1);

/// From an ensemble whose lags (of fluctuations) or layers (below loads) double, behind the one they are referred to.
DeepResponse measure_spreading(const MeasuredEnsemble& ensemble, DeepMeasurement by, int threads);

/// As it stands in summary.json.
void to_json(Json& json, const DeepResponse& one);

/// Whether W^2 is proportional to z where the paper looked, and deeper; checks do not count.
std::vector<Claim> judge_spreading(const std::vector<DeepResponse>& measured, const ClaimSpec& spec);

/// What sentences about these results need beside them, which stand at `pointer` of summary.json: each friction by the
/// rule of the deep claim; null where no exponent is known.
Json spreading_page_1(const std::vector<DeepResponse>& measured, const ClaimSpec& spec, const std::string& pointer);

/// Exponents against depth. Throws InputError where none is known.
Figure plot_deep_response(const std::vector<DeepResponse>& measured, const std::filesystem::path& run_folder);

/// c and D against the wave number. Throws InputError where none is known.
Figure plot_dispersion(const std::vector<DeepResponse>& measured, const std::filesystem::path& run_folder);

/// How the peaks move and spread far below where the main line looks: whether W^2 stays proportional to z.
std::unique_ptr<Study> deep_response_study();

}  // namespace granuscope
