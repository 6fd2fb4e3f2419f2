#pragma once
#include <cstdint>
#include <ostream>

#include "ensemble/ensemble_runner.h"
#include "report/clean_json.h"

namespace granuscope {
/// Draws spec.response.samples piles on `threads` threads (0: all) and measures every layer. Standard errors are known
/// from fewest_samples_with_errors on. `spec.response.blocks`, `layers` and `record_profiles` are set here. Every pile
/// is audited, or evenly spaced ones if they are too many; how many, and which piles failed, is told on `messages`.
SampleStatistics measure_samples(EnsembleSpec spec, int threads, std::ostream& messages);

/// min_blocks whole groups.
inline constexpr std::uint64_t fewest_samples_with_errors = static_cast<std::uint64_t>(min_blocks) * group_size;

}  // namespace granuscope
