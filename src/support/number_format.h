#pragma once
#include <string>

namespace granuscope {

/// A number with its standard error as physicists write it: value_with_error(0.07923, 0.0041) = "0.0792(41)". Always
/// with two significant digits of the error, in units of the value's last digit; an error of 1 or more is written out:
/// "123.4(5.6)". Below 1e-4 and above 1e6: "3.21(14) × 10⁻⁷". A zero error (or one below the resolution of a double)
/// gives the value with `digits_if_exact` significant digits. Unknown (not finite, negative error): "n/a". Minus signs
/// are the typographic U+2212.
std::string value_with_error(double value, double standard_error, int digits_if_exact = 6,
                             int lowest_plain_exponent = -4);

/// The value rounded to `digits` significant digits, with a typographic minus; never in exponent form for 1e-4..1e6,
/// "3.2 × 10⁻⁷" beyond. Not finite: "n/a".
std::string significant(double value, int digits);

/// "10⁻⁷".
std::string power_of_ten(int exponent);

/// `value` in the shortest form that reads back to the same double (std::to_chars); for scripts and data files.
std::string exact(double value);

}  // namespace granuscope
