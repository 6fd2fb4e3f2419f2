#pragma once
#include <string>

#include "analysis/estimate.h"
#include "analysis/jackknife.h"

namespace granuscope {

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
