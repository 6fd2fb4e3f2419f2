#pragma once
#include <algorithm>
#include <cmath>

/// Formulas for vectors must be inlined where the instruction set is known.
#define GRANUSCOPE_INLINE inline __attribute__((always_inline))

/// The arithmetic that formulas for every kind of number are written in, beside + - * /, for double.
/// Vectors have the same in sampling/repair_arithmetic-inl.h.
namespace granuscope::scalar {

template <class X>
GRANUSCOPE_INLINE X number(double value) {
  return value;
}

// Of equal numbers the first.
GRANUSCOPE_INLINE double larger(double a, double b) { return std::max(a, b); }
GRANUSCOPE_INLINE double smaller(double a, double b) { return std::min(a, b); }
GRANUSCOPE_INLINE double negative(double a) { return -a; }
GRANUSCOPE_INLINE double root(double a) { return std::sqrt(a); }
GRANUSCOPE_INLINE double magnitude(double a) { return std::abs(a); }
GRANUSCOPE_INLINE double choose(bool where, double yes, double no) { return where ? yes : no; }
GRANUSCOPE_INLINE bool less(double a, double b) { return a < b; }
GRANUSCOPE_INLINE bool at_most(double a, double b) { return a <= b; }
GRANUSCOPE_INLINE bool both(bool a, bool b) { return a && b; }
GRANUSCOPE_INLINE bool either(bool a, bool b) { return a || b; }
GRANUSCOPE_INLINE bool only(bool without, bool with) { return !without && with; }

}  // namespace granuscope::scalar
