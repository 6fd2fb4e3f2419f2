#pragma once
#include <cstdint>
#include <span>

#include "model/friction_cone.h"
#include "model/pile.h"
#include "sampling/random_key.h"
#include "storage/ensemble_file.h"

namespace granuscope {

/// Draws one layer below what stands above it, every bead uniformly on its own interval and from the numbers of this
/// attempt, without any regard to the layers below. False, and the rest of the layer left as it was, at the first bead
/// that has no solution. Adds the numbers drawn to `counts`.
bool draw_layer_blindly(const RandomKey& key, std::uint32_t attempt, const FrictionCone& cone, int layer, Pile& pile,
                        SamplerCounts& counts);

}  // namespace granuscope
