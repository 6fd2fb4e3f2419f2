#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace granuscope {

struct Analysis;

/// One number of a summary that nights are judged by.
struct KnownNumber {
  std::string name;  ///< "c at mu = 0.3", "beta"
  double value = 0;
  double standard_error = 0;  ///< 0: exact
};

/// The numbers that a change of the law would move, and few enough that a correction for their number costs little:
/// c, D and c_thrust at each friction coefficient, and the exponents. Unknown ones are left out.
std::vector<KnownNumber> primary_numbers(const nlohmann::ordered_json& summary);

std::vector<KnownNumber> primary_numbers_of(const Analysis& analysis);

/// The numbers of single depths: not judged, there are hundreds of them.
std::vector<KnownNumber> depth_numbers(const nlohmann::ordered_json& summary);

/// A number of two independent measurements.
struct MovedNumber {
  std::string name;
  KnownNumber before, after;
  double z = 0;        ///< their difference in standard errors of it; infinite where exact numbers differ
  double p = 1;        ///< chance of so large a difference if nothing changed, by Student's t
  bool moved = false;  ///< significant among all of them (Holm)
};

/// Chance that the errors of a night call a number moved although nothing changed, for all its numbers together.
inline constexpr double false_alarm_rate = 1e-3;

/// Holds the numbers of both against each other, by name. Errors come from a jackknife over so many blocks each, so
/// that the difference follows Student's t with the degrees of freedom after Welch, not a Gaussian.
std::vector<MovedNumber> hold_against(const std::vector<KnownNumber>& before, int blocks_before,
                                      const std::vector<KnownNumber>& after, int blocks_after);

/// Two-sided chance of |t| under Student's t.
double chance_of(double t, double degrees_of_freedom);

}  // namespace granuscope
