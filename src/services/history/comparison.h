#pragma once
#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>
#include <vector>

#include "history/run_record.h"

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

struct RunRecord;

/// How two runs compare: the first line that holds.
enum class Likeness {
  same,              ///< every value and error is equal, and so are the data of the figures (of one build: the figures)
  other_numbers,     ///< the same experiment, and other numbers: of another program or library, or not reproducible
  other_samples,     ///< the same experiment but for seed or samples: the numbers must agree within their errors
  other_experiment,  ///< nothing to judge: the numbers of what both measured stand side by side
};

std::string name_of(Likeness likeness);

/// Where two runs of the same experiment differ first.
enum class FirstDifference { none, sampling, analysis, plotting };

std::string name_of(FirstDifference where);

/// Differences below this, in standard errors, are rounding.
inline constexpr double rounding = 1e-6;

struct Comparison {
  Likeness likeness = Likeness::same;
  FirstDifference where = FirstDifference::none;  ///< other_numbers: at what stage,
  std::string place;                              ///< the file or number that differs first,
  double largest = 0;  ///< the largest difference in standard errors; infinite where an exact number differs
  std::vector<std::string> causes;  ///< and what else differs: program, libraries, processor; none: not reproducible
  bool causes_known = false;        ///< whether both runs tell what made them
  std::vector<MovedNumber>
      numbers;  ///< other_samples: the primary numbers; other_experiment: those of what both measured
  std::vector<MovedNumber> depths;    ///< and, not judged, those of single depths
  std::vector<ChangedKey> keys;       ///< the keys that differ
  std::vector<std::string> verdicts;  ///< "c-of-mu: reproduced where it was not decided"
  std::string hash_before, hash_after;

  bool is_rounding() const { return where == FirstDifference::analysis && largest < rounding; }
  /// Whether something is to be looked at: other numbers beyond rounding, or a number that moved.
  bool alarms() const;
};

/// `after` is held against `before`.
Comparison compare_runs(const RunRecord& before, const RunRecord& after);
/// The same of folders of runs or files summary.json. Throws InputError.
Comparison compare_runs(const std::filesystem::path& before, const std::filesystem::path& after);

/// The answer in lines for people, the first of which says it all.
std::vector<std::string> describe(const Comparison& comparison);

/// The same as JSON, for programs.
std::string json_text(const Comparison& comparison);

}  // namespace granuscope
