#include "history/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <sstream>

#include "support/single_line.h"

namespace granuscope {
namespace {

/// Tables of what is shown and told, and what is expected.
constexpr std::array untold_tables = {"experiment", "figures.", "scenes.", "report", "gate."};
/// What numbers the samples, and how many there are.
constexpr std::array sample_keys = {"sampling.seed", "response.samples", "precision.c", "precision.D",
                                    "precision.most_samples"};

/// Layers of the profiles are fitted beside the others, so that they are in the summary.
bool is_told_only(const std::string& key) {
  if (key == "figures.response_profiles.mu" || key == "figures.response_profiles.layers") return false;
  return std::any_of(untold_tables.begin(), untold_tables.end(),
                     [&](const char* table) { return key.starts_with(table); });
}

}  // namespace

std::map<std::string, std::string> measuring_keys(std::string_view resolved_experiment) {
  std::map<std::string, std::string> settings;
  std::istringstream lines{std::string(resolved_experiment)};
  std::string table;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('[')) {
      table = line.substr(1, line.find(']') - 1);
      continue;
    }
    const std::size_t equals = line.find(" = ");
    if (line.empty() || line.starts_with('#') || equals == std::string::npos) continue;
    const std::string key = table + "." + line.substr(0, equals);
    if (!is_told_only(key)) settings[key] = line.substr(equals + 3);
  }
  return settings;
}

std::vector<ChangedKey> changed_keys(const std::map<std::string, std::string>& before,
                                     const std::map<std::string, std::string>& after) {
  std::vector<ChangedKey> changed;
  for (const auto& [key, value] : before) {
    const auto found = after.find(key);
    if (found == after.end() || found->second != value) {
      changed.push_back({key, value, found == after.end() ? "" : found->second});
    }
  }
  for (const auto& [key, value] : after) {
    if (!before.contains(key)) changed.push_back({key, "", value});
  }
  return changed;
}

bool only_other_samples(const std::vector<ChangedKey>& changed) {
  return std::all_of(changed.begin(), changed.end(), [](const ChangedKey& one) {
    return std::find(sample_keys.begin(), sample_keys.end(), one.key) != sample_keys.end();
  });
}

std::string in_words(const std::vector<ChangedKey>& changed) {
  constexpr std::size_t most_told = 5, most_bytes = 60;
  const auto shown = [](const std::string& value) {
    return value.empty() ? "nothing" : single_line(value, most_bytes);
  };
  std::vector<std::string> told;
  for (std::size_t i = 0; i < std::min(changed.size(), most_told); ++i) {
    told.push_back(
        fmt::format("{} = {} where {} was", changed[i].key, shown(changed[i].after), shown(changed[i].before)));
  }
  return fmt::format("{}{}", fmt::join(told, ", "),
                     changed.size() > most_told ? fmt::format(", and {} more", changed.size() - most_told) : "");
}

}  // namespace granuscope
