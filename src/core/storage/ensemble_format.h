#pragma once
#include <cstdint>

/// What an ensemble file is called and holds, for those who write and read it.
namespace granuscope::ensemble_format {

inline constexpr const char* kind = "an ensemble file";
inline constexpr const char* name = "granuscope ensemble";
inline constexpr std::uint64_t version = 4;
/// More blocks than any ensemble has.
inline constexpr std::uint64_t most_blocks = 1'000'000;

/// Where the rows lie, if not as those of beads: a number in full, and "yes" or "no".
inline constexpr const char *row_spacing = "row_spacing", *row_pitch = "row_pitch", *rows_staggered = "rows_staggered";

/// The digest of all that is in no block. Files of before have none.
inline constexpr const char* record_key = "record_key";

/// Groups that are not quantities.
inline constexpr const char* counters_group = "counters";
inline constexpr const char* failed_group = "failed";

}  // namespace granuscope::ensemble_format
