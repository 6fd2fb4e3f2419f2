#pragma once
#include <cmath>
#include <numbers>

#include "analysis/double_gaussian.h"

namespace granuscope::test {

/// The plain twin of fourier_modes, one mode at a time: a sine and a cosine for each alias.
inline ModeValue fourier_mode(const DoubleGaussian& shape, int mode, int columns, bool half_shifted) {
  const double k = (2 * std::numbers::pi) * mode / columns;
  ModeValue sum{0, 0, 0};
  const auto add = [&](int l) {
    const double q = k + (2 * std::numbers::pi) * l;
    const double exponent = q * q * shape.width * shape.width / 2;
    if (exponent > 45) return false;
    const double bin = q == 0 ? 1.0 : std::sin(q / 2) / (q / 2);
    const double envelope = (half_shifted && l % 2 != 0 ? -1 : 1) * std::exp(-exponent) * bin;
    const double cosine = std::cos(q * shape.peak);
    sum.value += envelope * cosine;
    sum.by_peak -= envelope * q * std::sin(q * shape.peak);
    sum.by_width -= envelope * q * q * shape.width * cosine;
    return true;
  };
  add(0);
  for (int l = 1; l <= 64; ++l) {
    const bool minus = add(-l), plus = add(l);
    if (!minus && !plus) break;
  }
  return sum;
}

}  // namespace granuscope::test
