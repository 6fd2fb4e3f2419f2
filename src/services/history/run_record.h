#pragma once
#include <nlohmann/json.hpp>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace granuscope {
/// What a run left, as far as it is there: a run's folder has all of it, a summary.json alone only that.
struct RunRecord {               // NOLINT(bugprone-exception-escape): ordered_json has a move that may throw
  std::filesystem::path path;    ///< as named by the user
  std::filesystem::path folder;  ///< empty: only a summary
  nlohmann::ordered_json summary;
  std::optional<nlohmann::ordered_json> manifest;
  std::map<std::string, std::string> keys;  ///< measuring_keys of its experiment; empty if it is not there
  int blocks = 32;                          ///< of the jackknife
};

/// Reads a run's folder or a summary.json. Throws InputError.
RunRecord read_run(const std::filesystem::path& path);

/// The measuring_keys of a resolved experiment with the defaults of this program, where it can still read it: a key
/// that came later is none that differs.
std::map<std::string, std::string> keys_of_experiment(const std::string& resolved);

/// Every number of a summary with its place: captions, explanations and other words are left out.
std::map<std::string, double> numbers_of(const nlohmann::ordered_json& summary);

/// One word for all of these numbers.
std::string hash_of(const std::map<std::string, double>& numbers);

/// What numbers may depend on beside the experiment: program, commit, version of the sampling, libraries as loaded,
/// processor, programs that were run, by name.
std::map<std::string, std::string> environment_of(const nlohmann::ordered_json& manifest);

/// A key that two experiments have different values for; "" where one does not have it.
struct ChangedKey {
  std::string key, before, after;
};

/// Keys of a resolved experiment (print_experiment) with their values as written, by path, without those that change
/// nothing that is measured: name, description, figures, scenes, report, expected verdicts.
std::map<std::string, std::string> measuring_keys(std::string_view resolved_experiment);

std::vector<ChangedKey> changed_keys(const std::map<std::string, std::string>& before,
                                     const std::map<std::string, std::string>& after);

/// Whether only another part of the same ensembles is drawn: another seed or number of samples.
bool only_other_samples(const std::vector<ChangedKey>& changed);

/// "response.samples = 512 where 256 was, ...", the first few.
std::string in_words(const std::vector<ChangedKey>& changed);

}  // namespace granuscope
