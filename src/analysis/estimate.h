#pragma once
#include <cmath>
#include <limits>
#include <string>

namespace granuscope {

/// A number with its standard error (one standard deviation, delete-one-block jackknife), or the reason why unknown.
struct Estimate {
  double value = std::numeric_limits<double>::quiet_NaN();
  double standard_error = std::numeric_limits<double>::quiet_NaN();
  std::string reason;  ///< not empty if and only if the value is unknown

  bool known() const { return std::isfinite(value); }
};

}  // namespace granuscope
