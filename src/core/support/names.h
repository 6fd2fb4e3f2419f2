#pragma once
#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <string>
#include <utility>

#include "support/error.h"

namespace granuscope {
/// The names of an enumeration, as files and command lines have them.
template <class Choice, std::size_t count>
using Names = std::array<std::pair<Choice, const char*>, count>;

template <class Choice, std::size_t count>
std::string name_in(const Names<Choice, count>& names, Choice choice) {
  for (const auto& [one, name] : names) {
    if (one == choice) return name;
  }
  return {};
}

/// "granusolve, eloy-clement, rejection and polytope".
template <class Choice, std::size_t count>
std::string all_names(const Names<Choice, count>& names) {
  std::string all;
  for (std::size_t k = 0; k < count; ++k)
    all += (k == 0 ? "" : k + 1 == count ? " and " : ", ") + std::string(names[k].second);
  return all;
}

/// Throws InputError "there is no law ...", which names them all; `what`: "law".
template <class Choice, std::size_t count>
Choice named_in(const Names<Choice, count>& names, const std::string& wanted, const char* what) {
  for (const auto& [one, name] : names) {
    if (name == wanted) return one;
  }
  throw InputError("there is no {} \"{}\": known are {}; choose one", what, wanted, all_names(names));
}

}  // namespace granuscope
