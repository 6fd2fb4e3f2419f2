#pragma once
#include <filesystem>
#include <vector>

#include "support/progress.h"

namespace granuscope {

/// Joins what shards have left in several folders, blocks of any dealing and whole ensembles, into the ensembles of the
/// experiment that the first of them with one names, with the bytes of a run that drew them undivided. Throws
/// InputError, and has written nothing, where a block is missing (with the commands that draw it), belongs to another
/// experiment or sampling version, is damaged, or is there twice with different numbers. `out` may be one of the
/// folders.
void merge_folders(const std::vector<std::filesystem::path>& folders, const std::filesystem::path& out,
                   ProgressStyle progress);

}  // namespace granuscope
