#pragma once
#include <array>
#include <string>
#include <vector>

#include "analysis/jackknife.h"
#include "analysis/results.h"
#include "analysis/transport.h"

namespace granuscope {
/// The power laws of the paper over the friction coefficients inside `window` (inclusive): D = A mu^beta,
/// c0 - c = B mu^gamma, c0 - c = C D^alpha, each a straight line in the logarithms, all points of one weight. Results
/// without scatter and unknown ones take no part. Block b is left out at every mu at once, so that common random
/// numbers between friction coefficients are accounted for. Unknown, with the reason, below three points.
ScalingFits fit_scaling(const std::vector<MeasuredTransport>& results, std::array<double, 2> window);

/// The same with the systematic error of each exponent: its spread (systematic_spread) over the windows of depth and
/// the weights beside those of the fit (MeasuredTransport::variations; all friction coefficients at once, those without
/// such a variation keeping theirs) and over `window` without its lowest or highest friction coefficient, if three are
/// left.
struct ScalingWithVariations {
  ScalingFits fits;
  std::vector<ScalingVariation> variations;
};
ScalingWithVariations fit_scaling_with_variations(const std::vector<MeasuredTransport>& results,
                                                  std::array<double, 2> window);

/// Fewest points from which an exponent is taken.
inline constexpr int min_power_law_points = 3;

/// A fitted power law with the replicates of its exponent; they are empty where it is unknown.
struct ReplicatedPowerLaw {
  ScalingFit fit;
  Replicated exponent;
};

/// ln y = intercept + exponent ln x through points with errors on both axes, given as logarithms with replicates over
/// the same blocks, all of one weight. `window` of mu is only noted. Unknown, with the reason, below three
/// points or where a logarithm is undefined.
ScalingFit fit_power_law(const std::vector<Replicated>& log_x, const std::vector<Replicated>& log_y,
                         std::array<double, 2> window);

/// The same with the replicates that are needed to compare exponents. `missing` ends the reason where points are too
/// few.
ReplicatedPowerLaw fit_replicated_power_law(const std::vector<Replicated>& log_x, const std::vector<Replicated>& log_y,
                                            std::array<double, 2> window, const std::string& missing = "");

/// c and D of one ensemble, however they were read.
struct Coefficients {
  double scanned = 0;
  Replicated c, D;
  double c0 = tan30;
};

struct ReplicatedFits {
  ReplicatedPowerLaw beta, gamma, alpha;
  ScalingFits shown() const { return {beta.fit, gamma.fit, alpha.fit}; }
};

/// The power laws of fit_scaling through c and D that were read in whatever way.
ReplicatedFits fit_coefficients(const std::vector<Coefficients>& coefficients, std::array<double, 2> window);

/// The exponents of `moved` less those of `from`.
ScalingVariation variation_of(const ReplicatedFits& from, const std::string& change, const ReplicatedFits& moved);

/// "from 2.07(4) at μ = 0.014 to 1.94(1) at 0.1"; `of`: what the power is one of.
std::string in_words(const RunningExponent& running, const char* of);

/// Each exponent, averaged over the friction coefficients where it is known, with weights 1/(s^2 + tolerance^2): the
/// most precise one must not outvote the others beyond what the power law is trusted to hold
/// (ClaimSpec::exponent_tolerance). Block b is left out at every mu at once.
Exponents average_exponents(const std::vector<MeasuredTransport>& results, double tolerance);

/// The offset x_0 of x_p = x_0 + c z, averaged likewise with weights 1/s^2.
Estimate average_position_offset(const std::vector<MeasuredTransport>& results);

/// Do the pairs of the estimator paired measure the response of the law?
///
/// A bead of the second pile keeps the number of its *final* state in the first one, and that number has been chosen:
/// where the bead had failed it was drawn until neighbours fitted, elsewhere it was left because they did. Piles solved
/// from chosen numbers no longer follow the law of the first ones. Wherever the overload has changed anything they
/// differ in the mean, by an amount that does not depend on the overload, so that the difference over the overload is
///   P(x) = response + (change of the law)/overload.
/// What has one law tells itself by an identity: the total thrust is homogeneous of degree one in the loads and the
/// mean pile invariant under translation, so that the thrust of the linear response is the thrust ratio kappa of the
/// piles. "response_thrust" - "thrust" is therefore 0, or the second piles follow another law.
///
/// Why c and D of such pairs mean nothing, or nothing if they may: response_thrust differs from kappa by more than
/// coupling_bias_errors standard errors of the difference. Both from the same ensemble, means over the same layers.
std::string reason_against_pairs(const Replicated& response_thrust, const Replicated& thrust);

inline constexpr double coupling_bias_errors = 3;
/// Where nothing scatters (mu = 0) rounding is no difference.
inline constexpr double coupling_bias_rounding = 1e-9;

}  // namespace granuscope
