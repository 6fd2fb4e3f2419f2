#pragma once
#include <string>
#include <vector>

#include "analysis/results.h"

namespace granuscope {

inline constexpr const char* reproduced = "reproduced";
inline constexpr const char* not_reproduced = "not reproduced";
inline constexpr const char* undetermined = "undetermined";

/// Standard deviations up to which two numbers agree.
inline constexpr double agreement = 3;
/// Share of the paper's number that a measurement must be able to tell from it.
inline constexpr double deviation_to_detect = 0.2;

/// A number of the paper held against a measured one.
struct NumberVerdict {
  std::string verdict;
  double z_score = 0;  ///< NaN where the measurement is unknown
};

/// The rule for claims with a number: z = (m - p)/sqrt(s^2 + s_p^2), s_p being the paper's error where it gives one,
/// half a unit of its last digit otherwise and 0 for a law stated as exact. "not reproduced" if |z| > 3; else
/// "undetermined" if the measurement is unknown or s so large that a deviation of 20 % of p would not reach |z| > 3,
/// else "reproduced". Where s_p alone already hides 20 % of p, a measurement more precise than the paper's number (s <=
/// s_p) decides.
NumberVerdict judge_number(const Estimate& measured, double paper, double paper_error);

/// A claim without a verdict yet: no number of the paper, no z-score.
Claim open_claim(const std::string& id, const std::string& statement, const std::string& quantity);

/// Sets a claim to "undetermined" for want of a measurement: `reason` is a clause without a full stop.
void leave_open(Claim& claim, const std::string& reason);

/// Sets verdict, numbers and a sentence about `what` by judge_number.
void judge_by_number(Claim& claim, const Estimate& measured, double paper, double paper_error, const std::string& what);

/// The first sentence added explains the verdict, further ones are remarks. An empty one adds nothing.
void add_sentence(Claim& claim, const std::string& sentence);

/// How many times as many piles would make a standard error small enough for a verdict: a clause such as "about 3 times
/// as many piles would decide it", or an empty one where more piles are not what is missing.
std::string cost_of_deciding(const Estimate& measured, double paper, double paper_error);

/// "about 3 times as many piles would decide it", for a factor above 1.
std::string more_piles(double factor);

/// "μ = 0.1", "μ = 0.1, 0.2 and 0.3", "14 values of μ from 0.1 to 1.7".
std::string list_of_mu(const std::vector<double>& mu);

/// What holds at these: "at μ = 0.1", "over μ = 0.1 and 0.3", "over 14 values of μ from 0.1 to 1.7".
std::string over_all_mu(const std::vector<double>& mu);

}  // namespace granuscope
