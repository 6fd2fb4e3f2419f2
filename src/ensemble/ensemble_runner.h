#pragma once
#include "ensemble/ensemble_spec.h"
#include "storage/ensemble_file.h"
#include "support/progress.h"

namespace granuscope {

/// Draws all samples on `threads` threads (0: as many as the machine has) and returns their block sums: the same bytes
/// for every number of threads. Every pile's exact identities are asserted. A pile that cannot be completed is listed
/// in `failed` and enters no sum. Throws Interrupted if the program is asked to stop. `progress` may be null; it is
/// advanced by one per sample.
EnsembleRecord run_ensemble(const EnsembleSpec& spec, int threads, Progress* progress);

}  // namespace granuscope
