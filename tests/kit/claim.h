#pragma once
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/results.h"

namespace granuscope::test {

/// The claim of this id; out_of_range if there is none.
inline const Claim& claim(const std::vector<Claim>& claims, const std::string& id) {
  for (const Claim& one : claims) {
    if (one.id == id) return one;
  }
  throw std::out_of_range(id);
}

}  // namespace granuscope::test
