#include "sampling/portable_power.h"

#include <cmath>

namespace granuscope {
namespace {

constexpr double ln2 = 0.69314718055994530942, half_sqrt2 = 0.70710678118654752440;

/// Natural logarithm: base = m 2^e with m in [sqrt(1/2), sqrt(2)), ln m = 2 artanh((m - 1)/(m + 1)) by its series.
double portable_log(double base) {
  int exponent = 0;
  double mantissa = std::frexp(base, &exponent);  // exact
  if (mantissa < half_sqrt2) {
    mantissa *= 2;
    --exponent;
  }
  const double s = (mantissa - 1) / (mantissa + 1), square = s * s;  // square < 0.0295
  double series = 0;
  for (int power = 21; power >= 3; power -= 2) series = (series + 1.0 / power) * square;
  return exponent * ln2 + 2 * s * (1 + series);
}

/// e^y: y = k ln 2 + f with |f| <= ln 2 / 2, e^f by its series.
double portable_exp(double y) {
  const double k = std::floor(y / ln2 + 0.5), f = y - k * ln2;
  double series = 1;
  for (int term = 17; term >= 1; --term) series = 1 + series * f / term;
  return std::ldexp(series, static_cast<int>(k));  // exact unless it leaves the range of normal numbers
}

}  // namespace

double portable_power(double base, double exponent) {
  if (exponent == 0) return 1;
  if (exponent == 1 || std::isinf(base)) return base;
  return portable_exp(exponent * portable_log(base));
}

}  // namespace granuscope
