#pragma once
#include <fmt/core.h>

#include <optional>
#include <string>
#include <utility>

namespace granuscope {

/// What makes the value of a key unusable.
struct KeyProblem {
  std::string key;      ///< "lattice.columns"; in what a spec says of itself "columns", as a table may have any name
  std::string message;  ///< what is wrong, why that is a problem, what to do
};
using Problem = std::optional<KeyProblem>;

template <class... Args>
Problem problem(const std::string& key, fmt::format_string<Args...> text, Args&&... args) {
  return KeyProblem{key, fmt::format(text, std::forward<Args>(args)...)};
}

/// What a spec says of itself, as the table of an experiment file that holds it.
Problem in_table(const std::string& table, Problem found);

/// Throws InputError "key: message" if there is a problem.
void refuse(const Problem& found);

}  // namespace granuscope
