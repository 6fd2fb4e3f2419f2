#pragma once
#include <cstdint>
#include <string>

namespace granuscope {

/// How the top is loaded.
enum class Load {
  uniform,  ///< 1 on every top bead
  point,    ///< 1 on every top bead, 1 + overload on the middle one
};

/// How the response is measured.
struct ResponseSpec {
  std::string estimator = "point";  ///< the paper's procedure: point load, uniform load subtracted, mirror symmetrised
  double overload = 1.0;            ///< extra force on the middle top bead
  std::uint64_t samples = 3456;     ///< piles per friction coefficient
  int blocks = 32;                  ///< of whole groups of eight samples; at least 8
};

std::string name_of(Load load);
Load load_named(const std::string& name);

}  // namespace granuscope
