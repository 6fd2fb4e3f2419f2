#pragma once
#include <cstdint>
#include <optional>

#include "ensemble/ensemble_spec.h"
#include "model/pile.h"
#include "sampling/sampler.h"

namespace granuscope {

/// Draws what the ensemble's estimator draws for one sample, in the same order and from the same numbers, and leaves
/// the last pile of it: the loaded one (point), the one solved again with the overload (paired), the one under the
/// sample's signs or, of an opposite pair, under the reversed ones (multiplexed). Or where it got stuck.
std::optional<SamplingFailure> replay(const EnsembleSpec& spec, std::uint64_t sample, Pile& pile);

}  // namespace granuscope
