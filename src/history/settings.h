#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace granuscope {

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
