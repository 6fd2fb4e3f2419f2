#pragma once
#include "analysis/claim_spec.h"
#include "analysis/fit_spec.h"
#include "analysis/results.h"

namespace granuscope {

/// One function for each claim of the paper. Each returns the claim with verdict, numbers and a sentence; none looks at
/// the verdict the experiment expects. What decides a claim stands beside its function's definition.

Claim judge_frictionless(const Analysis& analysis);
Claim judge_double_peak(const Analysis& analysis, const FitSpec& fit, const ClaimSpec& spec);
Claim judge_linear_position(const Analysis& analysis, const ClaimSpec& spec);
Claim judge_diffusive_width(const Analysis& analysis, const ClaimSpec& spec);
Claim judge_amplitude(const Analysis& analysis, const ClaimSpec& spec);
Claim judge_c_of_mu(const Analysis& analysis);
Claim judge_D_of_mu(const Analysis& analysis);
Claim judge_c_of_D(const Analysis& analysis);
Claim judge_no_elastic_scaling(const Analysis& analysis, const ClaimSpec& spec);
Claim judge_differs_from_theory(const Analysis& analysis);
Claim judge_two_gaussians(const Analysis& analysis, const FitSpec& fit, const ClaimSpec& spec);
Claim judge_closer_and_wider(const Analysis& analysis, const FitSpec& fit);
Claim judge_noise(const Analysis& analysis, const ClaimSpec& spec);

}  // namespace granuscope
