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
  /// How far it depends on the window and the weights it was fitted with (fit_variations.h); NaN where that was not
  /// measured.
  double systematic = std::numeric_limits<double>::quiet_NaN();

  bool known() const { return std::isfinite(value); }
};

}  // namespace granuscope
