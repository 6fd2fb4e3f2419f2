#pragma once

namespace granuscope {

/// base^exponent for base > 0 (finite or infinite) and 0 <= exponent <= 1, to about 1e-15 relative, from additions,
/// multiplications and divisions alone: the bytes are the same with every mathematical library, as those of its pow()
/// are not.
double portable_power(double base, double exponent);

}  // namespace granuscope
