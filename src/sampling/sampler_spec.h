#pragma once
#include <cstdint>
#include <string>

namespace granuscope {

/// What "a random pile" means. The mean response depends on it, so it is a named choice.
enum class Law { granusolve, rejection };

/// Largest SamplerSpec::max_tries: the key of a random number has 24 bits for the attempt.
inline constexpr std::uint64_t most_tries = (std::uint64_t{1} << 24) - 1;

/// How the beads of one layer are ordered while it is solved.
enum class LayerOrder {
  random,  ///< a random first bead and a random direction for each layer: the law
  fixed,   ///< always from bead 0 rightwards: breaks mirror symmetry, kept to show that the tests would see it
};

struct SamplerSpec {
  Law law = Law::granusolve;
  double mu = 0.1;  ///< friction coefficient, 0 <= mu < sqrt(3)
  std::uint64_t seed = 1;
  double effort = 200;                  ///< granusolve: a pile fails by name after this many bead solutions per bead
  std::uint64_t max_tries = 1'000'000;  ///< rejection: a pile fails by name after this many tries
  LayerOrder order = LayerOrder::random;
};

/// "granusolve", "rejection".
std::string name_of(Law law);
/// Throws InputError naming the known laws.
Law law_named(const std::string& name);

/// "random", "fixed".
std::string name_of(LayerOrder order);
/// Throws InputError naming both.
LayerOrder layer_order_named(const std::string& name);

/// Changes whenever the same key gives another pile; part of every ensemble's configuration.
inline constexpr const char* sampling_version = "2";

}  // namespace granuscope
