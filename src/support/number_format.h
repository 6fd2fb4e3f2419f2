#pragma once
#include <string>

namespace granuscope {

/// A number with its standard error as physicists write it: value_with_error(0.07923, 0.0041) = "0.0792(41)".
/// Two digits of the error are given when they are below 30, one otherwise is never used: always two digits, so that
/// columns align. A zero error gives the value with `digits_if_exact` significant digits. Unknown (NaN): "n/a".
/// Minus signs are the typographic U+2212.
std::string value_with_error(double value, double standard_error, int digits_if_exact = 6);

/// The value rounded to `digits` significant digits, with a typographic minus; never in exponent form for 1e-4..1e6,
/// "3.2 × 10⁻⁷" beyond.
std::string significant(double value, int digits);

/// `value` in the shortest form that reads back to the same double (std::to_chars); for scripts and data files.
std::string exact(double value);

}  // namespace granuscope
