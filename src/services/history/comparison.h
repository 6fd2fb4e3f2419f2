#pragma once
#include <nlohmann/json.hpp>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plot/figure_captions.h"

namespace granuscope {
/// What a run left, as far as it is there: a run's folder has all of it, a summary.json alone only that.
struct RunRecord {               // NOLINT(bugprone-exception-escape): ordered_json has a move that may throw
  std::filesystem::path path;    ///< as named by the user
  std::filesystem::path folder;  ///< empty: only a summary
  Json summary;
  std::optional<Json> manifest;
  std::map<std::string, std::string> keys;  ///< measuring_keys of its experiment; empty if it is not there
  int blocks = 32;                          ///< of the jackknife
};

/// Reads a run's folder or a summary.json. Throws InputError.
RunRecord read_run(const std::filesystem::path& path);

/// The measuring_keys of a resolved experiment with the defaults of this program, where it can still read it: a key
/// that came later is none that differs.
std::map<std::string, std::string> keys_of_experiment(const std::string& resolved);

/// Every number of a summary with its place: captions, explanations and other words are left out.
std::map<std::string, double> numbers_of(const Json& summary);

/// What numbers may depend on beside the experiment: program, commit, version of the sampling, libraries as loaded,
/// processor, programs that were run, by name.
std::map<std::string, std::string> environment_of(const Json& manifest);

/// A key that two experiments have different values for; "" where one does not have it.
struct ChangedKey {
  std::string key, before, after;
};

std::vector<ChangedKey> changed_keys(const std::map<std::string, std::string>& before,
                                     const std::map<std::string, std::string>& after);

/// "response.samples = 512 where 256 was, ...", the first few.
std::string in_words(const std::vector<ChangedKey>& changed);

struct Analysis;

/// One number of a summary that nights are judged by.
struct KnownNumber {
  std::string name;  ///< "c at mu = 0.3", "beta"
  double value = 0;
  double standard_error = 0;  ///< 0: exact
};

/// The numbers that a change of the law would move, and few enough that a correction for their number costs little:
/// c, D and c_thrust at each friction coefficient, and the exponents. Unknown ones are left out.
std::vector<KnownNumber> primary_numbers(const Json& summary);

std::vector<KnownNumber> primary_numbers_of(const Analysis& analysis);

/// The numbers of single depths: not judged, there are hundreds of them.
std::vector<KnownNumber> depth_numbers(const Json& summary);

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
