#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "experiment/experiment.h"
#include "pipeline/block_files.h"
#include "pipeline/pipeline.h"
#include "support/progress.h"

namespace granuscope {
/// One of `count` processes, from 1 on, that draw the ensembles of an experiment together.
struct Shard {
  int number = 1;
  int count = 1;
};

/// "3/16", or "auto": from the variables of a Slurm array, srun, Open MPI or MPICH, those of an array and of the tasks
/// in it; `variable` looks one up. Throws InputError, also for what may be a part of an array that worked in `folder`.
Shard shard_named(const std::string& text, const std::function<std::string(const char*)>& variable,
                  const std::filesystem::path& folder);

/// Whether Open MPI, MPICH or srun started several processes, of which this is one.
bool is_one_of_tasks(const std::function<std::string(const char*)>& variable);

/// All ensembles of an experiment, of its main line and its studies, in the order in which a run takes them.
std::vector<PlannedEnsemble> all_ensembles(const Experiment& experiment, const std::filesystem::path& run_folder);

/// The work of one block relative to that of others, by a rule that is the same on every machine.
double relative_cost(const EnsembleSpec& spec);

/// All blocks of all ensembles, those that take longest first.
std::vector<Atom> atoms_of(const std::vector<PlannedEnsemble>& ensembles);

/// The blocks of each of `count` shards: each ensemble is spread evenly over them, and what cannot be is dealt so that
/// the costs even out. Depends on the experiment and `count` only. Throws InputError if there are fewer blocks than
/// shards.
std::vector<std::vector<Atom>> deal(const std::vector<PlannedEnsemble>& ensembles, int count);

/// Leaves the resolved experiment in the folder. Throws InputError if another one is there.
void keep_experiment(const std::filesystem::path& folder, const std::string& resolved);

/// Draws the blocks of one shard that are not there yet, and leaves each in a file (block_files.h). Any number of
/// shards may share a folder, also of different counts, and with the same shard drawn twice, one after the other.
void run_shard(const Experiment& experiment, const RunOptions& options, Shard shard);

/// What run_shard would do, one step for each ensemble of which the shard has blocks.
std::vector<PlannedStep> plan_shard(const Experiment& experiment, const RunOptions& options, Shard shard);

/// Removes what shards leave behind to keep each other off.
void forget_shards(const std::filesystem::path& run_folder);

/// Joins what shards have left in several folders, blocks of any dealing and whole ensembles, into the ensembles of the
/// experiment that the first of them with one names, with the bytes of a run that drew them undivided. Throws
/// InputError, and has written nothing, where a block is missing (with the commands that draw it), belongs to another
/// experiment or sampling version, is damaged, or is there twice with different numbers. `out` may be one of the
/// folders. Returns whether blocks were joined: not where all ensembles were whole.
bool merge_folders(const std::vector<std::filesystem::path>& folders, const std::filesystem::path& out,
                   ProgressStyle progress);

}  // namespace granuscope
