#pragma once
#include <string>

#include "analysis/jackknife.h"

namespace granuscope::test {

inline Estimate known(double value, double standard_error) { return {value, standard_error, ""}; }

inline Estimate unknown(const std::string& reason) {
  Estimate estimate;
  estimate.reason = reason;
  return estimate;
}

}  // namespace granuscope::test
