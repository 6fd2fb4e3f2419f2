#pragma once
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

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

}  // namespace granuscope
