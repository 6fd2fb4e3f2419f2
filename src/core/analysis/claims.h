#pragma once
#include <fmt/core.h>

#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/results.h"
#include "analysis/shape_fit.h"
#include "analysis/transport.h"

namespace granuscope {
/// Decides the claims of the paper about the main line from what was measured (all of `analysis` but its claims).
std::vector<Claim> judge_claims(const Analysis& analysis, const FitSpec& fit, const ClaimSpec& spec);

/// Adds to the claim against the stochastic theory what readings below the window have, once the studies gave them.
void tell_smaller_friction(Analysis& analysis);

/// Notes with each claim the verdict that the experiment expects of it; `expected` maps claim ids to verdicts.
void expect_verdicts(std::vector<Claim>& claims, const std::map<std::string, std::string>& expected);

/// What came out otherwise than the experiment asks, a sentence each: verdicts, and a precision that was not reached.
std::vector<std::string> unexpected_results(const Analysis& analysis);

/// Ids of all claims that judge_claims decides, in its order.
std::vector<std::string> claim_ids();

inline constexpr const char* reproduced = "reproduced";
inline constexpr const char* not_reproduced = "not reproduced";
inline constexpr const char* not_decided = "not decided";  ///< measured, too uncertainly
inline constexpr const char* not_tested = "not tested";    ///< not measured in this run

/// All of them, in this order.
inline constexpr std::array<const char*, 4> all_verdicts{reproduced, not_reproduced, not_decided, not_tested};

/// Standard errors up to which two numbers agree.
inline constexpr double agreement = 3;
/// How far from the paper's number the rival lies where no theory names one, as a share of that number.
inline constexpr double deviation_to_detect = 0.2;

/// A number as the paper states it.
struct PaperNumber {
  double value = 0;
  double error =
      0;  ///< the paper's where it gives one, half a unit of its last digit otherwise, 0 for a proportionality
  double tolerance = 0;  ///< granted by the experiment, since the paper's value is a limit
};

/// The value that another theory predicts.
struct Rival {
  double value = 0;
  std::string name;
};

inline constexpr PaperNumber paper_gamma{.value = 1};                   ///< stated as a proportionality: exact
inline constexpr PaperNumber paper_beta{.value = 2.5, .error = 0.05};   ///< "about 2.5": half a unit of its last digit
inline constexpr PaperNumber paper_alpha{.value = 0.4, .error = 0.01};  ///< given with its error
/// c0 - c in proportion to the variance of the disorder, as D, which grows as mu^2.
inline const Rival second_order{2, "second order in μ"}, linear_in_D{1, "stochastic theory"};

/// A number of the paper held against a measured one.
struct NumberVerdict {
  std::string verdict;
  double z_score = 0;  ///< NaN where the measurement is unknown
  Rival rival;
  double rival_distance = 0;  ///< standard errors; NaN where the measurement is unknown
};

/// The rule for claims with a number: the pull, (m - p)/sqrt(s^2 + s_sys^2 + s_p^2 + t^2), with the statistical and
/// the systematic error of the measured m, the paper's error and the tolerance. "not reproduced" beyond +-3; else
/// "reproduced" if the rival lies more than 3 sqrt(s^2 + s_sys^2 + t^2) from m; else "not decided". Without a rival of
/// a theory it is p (1 +- 0.2), the nearer of the two. "not tested" if m is unknown.
NumberVerdict judge_number(const Estimate& measured, const PaperNumber& paper, const std::optional<Rival>& rival = {});

/// Statistical and systematic error in quadrature.
double total_error(const Estimate& measured);

/// A claim without a verdict yet: no number of the paper, no pull, no rival.
Claim open_claim(const std::string& id, const std::string& statement, const std::string& quantity);

/// Sets a claim to "not tested" for want of a measurement: `reason` is a clause without a full stop.
void leave_open(Claim& claim, const std::string& reason);
template <class First, class... Rest>
void leave_open(Claim& claim, fmt::format_string<First, Rest...> reason, First&& first, Rest&&... rest) {
  leave_open(claim, fmt::format(reason, std::forward<First>(first), std::forward<Rest>(rest)...));
}

/// Sets verdict, numbers and a sentence about `what` by judge_number.
void judge_by_number(Claim& claim, const Estimate& measured, const PaperNumber& paper,
                     const std::optional<Rival>& rival, const std::string& what);

/// For a claim that `measured` is not what another theory says, `paper` being what the paper has instead: reproduced if
/// the rival lies more than three errors off, not reproduced if it does not and the paper's value does, else not
/// decided.
void judge_by_exclusion(Claim& claim, const Estimate& measured, const PaperNumber& paper, const Rival& rival,
                        const std::string& what);

/// The first sentence added explains the verdict, further ones are remarks. An empty one adds nothing.
void add_sentence(Claim& claim, const std::string& sentence);
template <class First, class... Rest>
void add_sentence(Claim& claim, fmt::format_string<First, Rest...> sentence, First&& first, Rest&&... rest) {
  add_sentence(claim, fmt::format(sentence, std::forward<First>(first), std::forward<Rest>(rest)...));
}

/// That the points of an exponent keep to no single power of what `of` names, and which changing one they keep to;
/// empty where they do not say so.
std::string misfit_sentence(const ScalingFit& fit, const char* of);

/// How many times as many piles would set the paper's value apart from the rival: a clause such as "about 3 times as
/// many piles would decide it", or one that says that more piles do not help.
std::string cost_of_deciding(const Estimate& measured, const PaperNumber& paper, double rival);

/// "about 3 times as many piles would decide it".
std::string more_piles(double factor);

/// "μ = 0.1", "μ = 0.1, 0.2 and 0.3", "14 values of μ from 0.1 to 1.7".
std::string list_of_values(const std::vector<double>& values, const std::string& symbol = "μ");

/// What holds at these: "at μ = 0.1", "over μ = 0.1 and 0.3", "over 14 values of μ from 0.1 to 1.7".
std::string over_all_values(const std::vector<double>& values, const std::string& symbol = "μ");

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

/// From the measured ensembles, all of one scan, to exponents and claims. Results come out ascending in its parameter.
Analysis analyse(std::vector<MeasuredTransport> measured, const FitSpec& fit, const ClaimSpec& claims);

}  // namespace granuscope
