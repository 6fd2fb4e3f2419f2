#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "history/night_book.h"
#include "pipeline/pipeline.h"

namespace granuscope {

/// How a night is run.
struct NightlyOptions {
  std::filesystem::path folder;  ///< of the history
  std::size_t keep = 30;         ///< reports kept
  std::uint64_t grow = 0;        ///< samples by which the pool grows; 0: response.samples
  int threads = 0;
  ProgressStyle progress = ProgressStyle::silent;
  std::string date;  ///< "2026-01-31T02:00:00Z"; empty: now
  /// What runs an experiment; tests put changes of program and libraries here.
  std::function<RunResult(const Experiment&, const RunOptions&)> run = run_experiment;
};

/// Samples that come in when so many are asked for, 0: response.samples.
std::uint64_t samples_of_night(const Experiment& experiment, std::uint64_t grow);

/// One night of an experiment, kept in the history.
///
/// A canary (response.samples / 8 with the experiment's own seed, always the same samples) must give the numbers of the
/// night that it was first run, but for rounding. Then the pool, a run in DIR/pool, takes in the next
/// samples; its result is, byte for byte, one run of as many samples. What came in by itself is held against the pool
/// before it, the primary numbers only and with a correction for how many they are.
///
/// A canary with other numbers, another experiment, a failed pile, a broken identity alarm at once; the pool takes
/// nothing in where the canary or the experiment is another one. A number that moved and a verdict that changed alarm
/// when they do so on two nights in a row. Throws BusyError if another night is at work, and EnvironmentError,
/// InputError and Interrupted as a run does: such a night is not kept, and the next one goes on from there.
Night run_night(const Experiment& experiment, const NightlyOptions& options);

/// Throws InputError if pool or reports of a history are in this folder. Call it where its database is not: nothing
/// else knows of its nights.
void require_no_lost_history(const std::filesystem::path& folder);

/// The alarms of a night become the new normal: the next canary is held against that night's, the experiment of that
/// night is the one to be run, and a pool of other samples is begun anew. Throws InputError for a night that has no
/// alarms or whose canary is not kept any more.
void accept_night(const std::filesystem::path& folder, std::int64_t night);

/// Removes the record of a night. Throws BusyError while a night is at work.
void forget_night(const std::filesystem::path& folder, std::int64_t night);

/// Whether a claim's number lies so near to where its verdict changes, three standard errors, that it says nothing.
bool at_the_edge(double z);

/// What moved or changed its verdict on this night, told if it did so on the one before, too; else watched.
void add_soft_alarms(Night& tonight, const std::vector<Night>& before);

}  // namespace granuscope
