#pragma once
#include <cstring>
#include <vector>

#include "model/pile.h"

namespace granuscope::test {

/// Equal bit by bit, so that -0.0 differs from 0.0 and a NaN equals itself.
inline bool same_bytes(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

/// Size, every force and the load. What the pile is called (law, mu, seed, sample) is not compared.
inline bool same_bytes(const Pile& a, const Pile& b) {
  return a.lattice.columns() == b.lattice.columns() && a.lattice.layers() == b.lattice.layers() &&
         same_bytes(a.V_R, b.V_R) && same_bytes(a.V_L, b.V_L) && same_bytes(a.H_R, b.H_R) && same_bytes(a.H_L, b.H_L) &&
         same_bytes(a.load, b.load);
}

/// What the pile is called: its key.
inline bool same_key(const Pile& a, const Pile& b) {
  return a.sample == b.sample && a.seed == b.seed && a.law == b.law && a.mu == b.mu;
}

}  // namespace granuscope::test
