#pragma once
#include "storage/ensemble_file.h"

namespace granuscope {

/// Adds the sums, counts and failures of `more` to `to`, block by block: afterwards each block holds the samples of
/// both. Throws InputError unless both have the same layers, blocks and quantities.
void merge_into(EnsembleRecord& to, const EnsembleRecord& more);

}  // namespace granuscope
