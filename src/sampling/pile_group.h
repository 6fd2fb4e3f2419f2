#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "model/identities.h"
#include "model/lattice.h"
#include "model/pile.h"

namespace granuscope {

/// Piles that are solved side by side, one to a vector lane: bead i of pile k is entry 8 i + k of a row.
inline constexpr std::size_t group_lanes = 8;

/// Where a pile could not be completed within the stated effort.
struct SamplingFailure {
  int layer;
};

/// Piles that were drawn together, to be measured where they lie; it owns nothing. The arrays are those of Pile, of
/// shape [layers, columns, stride]: bead b of pile k is entry stride b + k.
struct PileGroup {
  Lattice lattice;
  std::size_t stride = 1;  ///< 1 or group_lanes
  std::size_t piles = 1;   ///< at most stride
  const double *V_R = nullptr, *V_L = nullptr, *H_R = nullptr, *H_L = nullptr;
  std::span<const std::span<const double>> loads;  ///< of each pile

  double mu = 0;
  std::string law;
  std::uint64_t seed = 0, first_sample = 0;

  /// Entry of pile 0's first bead of a layer.
  std::size_t row(int layer) const { return lattice.index(layer, 0) * stride; }
};

/// A single pile as a group of one; `load` holds the pile's load while the group is in use.
PileGroup group_of(const Pile& pile, const std::span<const double>& load);

/// Pile `k` of the group, taken out.
Pile pile_of(const PileGroup& group, std::size_t k);

/// The residuals of model/identities.h for each pile, all piles at once with the widest vectors the machine has.
std::array<IdentityResiduals, group_lanes> identity_residuals(const PileGroup& group);

/// Throws std::logic_error if an identity of a pile that did not fail is broken. `failures` has an entry per pile.
void assert_identities(const PileGroup& group, std::span<const std::optional<SamplingFailure>> failures);

}  // namespace granuscope
