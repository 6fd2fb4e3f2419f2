#include "pipeline/merge_folders.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <set>
#include <system_error>
#include <utility>

#include "experiment/experiment_file.h"
#include "pipeline/block_files.h"
#include "pipeline/run_folder.h"
#include "pipeline/shards.h"
#include "storage/ensemble_file.h"
#include "support/atomic_file.h"
#include "support/error.h"
#include "support/interruption.h"

namespace granuscope {
namespace fs = std::filesystem;
namespace {

/// One file with blocks of an ensemble: a single one, or all.
struct Source {
  fs::path file;
  EnsembleReader reader;
};

/// Where the blocks of an ensemble are to come from: a file of all of them, or one for each.
struct Found {
  std::shared_ptr<const Source> whole;
  std::map<int, std::shared_ptr<const Source>> single;
};

std::string key_of(const Source& source, int block) {
  return source.reader.keys().at(static_cast<std::size_t>(block - source.reader.header().sums.first_block));
}

/// Reads the numbers of a block to see whether they are those that were written; throws InputError if not.
void require_sound(const Source& source, int block) {
  (void)source.reader.read_block(static_cast<std::size_t>(block - source.reader.header().sums.first_block));
}

/// Counters and failures are known of single blocks only.
bool same_block(const Source& a, const Source& b, int block) {
  if (key_of(a, block) != key_of(b, block)) return false;
  const EnsembleRecord &one = a.reader.header(), &other = b.reader.header();
  if (one.sums.blocks() != other.sums.blocks()) return true;
  const auto same_failure = [](const FailedSample& x, const FailedSample& y) {
    return x.sample == y.sample && x.layer == y.layer;
  };
  return std::memcmp(&one.counts, &other.counts, sizeof one.counts) == 0 &&
         std::equal(one.failed.begin(), one.failed.end(), other.failed.begin(), other.failed.end(), same_failure);
}

void require_same(const PlannedEnsemble& planned, const Source& a, const Source& b, int block) {
  if (same_block(a, b, block)) return;
  require_sound(a, block);
  require_sound(b, block);
  throw InputError(
      fmt::format("'{}' and '{}' hold block {} of {} with different numbers, though of one experiment and sampling "
                  "version, so that at least one of them is wrong; draw it again, and remove the file that differs",
                  a.file.string(), b.file.string(), block, planned.label));
}

std::shared_ptr<const Source> open(const fs::path& file, const std::string& configuration, int first_block,
                                   int blocks) {
  auto source = std::make_shared<const Source>(Source{file, EnsembleReader(file)});
  const EnsembleRecord& header = source->reader.header();
  if (header.configuration != configuration) {
    throw InputError(fmt::format(
        "'{}' is of another experiment than the one to be merged, so that their piles do not belong together: {}; "
        "leave it out, or merge it with those of its own",
        file.string(), describe_difference(header.configuration, configuration)));
  }
  if (header.sums.first_block != first_block || header.sums.blocks() != blocks) {
    throw InputError(fmt::format("'{}' holds other blocks than its name says, {} from {} on; draw them again",
                                 file.string(), header.sums.blocks(), header.sums.first_block));
  }
  return source;
}

void look_into(const PlannedEnsemble& planned, const fs::path& folder, Found& found) {
  std::error_code ignored;
  const int blocks = planned.spec.response.blocks;
  if (const fs::path file = folder / planned.file; fs::exists(file, ignored)) {
    const auto whole = open(file, configuration_text(planned.spec) + planned.notes, 0, blocks);
    for (int block = 0; block < blocks && found.whole != nullptr; ++block) {
      require_same(planned, *found.whole, *whole, block);
    }
    if (found.whole == nullptr) found.whole = whole;
  }
  const BlockFiles files(planned, folder);
  for (int block = 0; block < blocks; ++block) {
    throw_if_interrupted();
    if (!fs::exists(files.file(block), ignored)) continue;
    const auto source = open(files.file(block), block_configuration(planned, block), block, 1);
    if (const auto [at, is_new] = found.single.emplace(block, source); !is_new) {
      require_same(planned, *at->second, *source, block);
    }
  }
}

/// A folder may hold blocks of an ensemble that the experiment does not have.
void require_known(const std::vector<PlannedEnsemble>& ensembles, const fs::path& folder) {
  std::set<std::string> known;
  for (const PlannedEnsemble& planned : ensembles) {
    known.insert(BlockFiles(planned, folder).folder().filename().string());
  }
  std::error_code ignored;
  for (auto at = fs::directory_iterator(folder / "ensembles", ignored); !ignored && at != fs::directory_iterator();
       at.increment(ignored)) {
    if (at->path().extension() == ".blocks" && !known.contains(at->path().filename().string())) {
      throw InputError(
          fmt::format("'{}' holds blocks of an ensemble that the experiment to be merged does not have; leave that "
                      "folder out, or merge it with those of its own",
                      at->path().string()));
    }
  }
}

/// "0, 4 to 7, 9".
std::string ranges_of(const std::vector<int>& blocks) {
  std::vector<std::string> ranges;
  for (std::size_t i = 0; i < blocks.size();) {
    std::size_t end = i + 1;
    while (end < blocks.size() && blocks[end] == blocks[end - 1] + 1) ++end;
    ranges.push_back(end - i == 1 ? std::to_string(blocks[i]) : fmt::format("{} to {}", blocks[i], blocks[end - 1]));
    i = end;
  }
  return fmt::format("{}", fmt::join(ranges, ", "));
}

void require_complete(const std::vector<PlannedEnsemble>& ensembles, const std::vector<Found>& found,
                      const std::vector<fs::path>& folders) {
  std::vector<Atom> missing;
  std::vector<std::string> words;
  for (std::size_t i = 0; i < ensembles.size(); ++i) {
    if (found[i].whole != nullptr) continue;
    std::vector<int> blocks;
    for (int block = 0; block < ensembles[i].spec.response.blocks; ++block) {
      if (!found[i].single.contains(block)) blocks.push_back(block);
    }
    if (blocks.empty()) continue;
    for (const int block : blocks) missing.push_back({i, block});
    words.push_back(fmt::format("of {}: {}", ensembles[i].label, ranges_of(blocks)));
  }
  if (missing.empty()) return;
  throw InputError(fmt::format("{} blocks are missing, so that nothing was merged ({}); draw them by: {}",
                               missing.size(), fmt::join(words, "; "),
                               fmt::join(commands_for(ensembles, missing, folders), "; ")));
}

Experiment experiment_of(const std::vector<fs::path>& folders) {
  std::error_code ignored;
  for (const fs::path& folder : folders) {
    if (!fs::is_directory(folder, ignored)) {
      throw InputError(fmt::format("'{}' is no folder; name folders in which shards have worked", folder.string()));
    }
  }
  for (const fs::path& folder : folders) {
    if (fs::exists(folder / "experiment.toml", ignored)) return read_experiment(folder / "experiment.toml");
  }
  throw InputError(
      fmt::format("'{}' holds no experiment.toml, so that nobody knows what to merge; name folders in "
                  "which shards (run --shard) have worked",
                  folders.front().string()));
}

/// While blocks are still being drawn, those that are missing are no fault. Each folder once, however it is named; that
/// of the result, which is made only when all is there, only if it is there.
std::vector<RunFolder> lock_folders(const std::vector<fs::path>& folders, const fs::path& out) {
  std::set<fs::path> sources;
  for (const fs::path& folder : folders) sources.insert(fs::canonical(folder));
  std::vector<RunFolder> locks;
  std::error_code ignored;
  if (fs::is_directory(out, ignored)) {
    sources.erase(fs::canonical(out));
    locks.emplace_back(out);
  }
  for (const fs::path& source : sources) locks.emplace_back(source, FolderUse::read);
  return locks;
}

/// A whole ensemble needs no joining, but all its numbers are looked at on the way.
void write_whole(const PlannedEnsemble& planned, const fs::path& target, const Found& found) {
  if (found.whole != nullptr) {
    const EnsembleReader& reader = found.whole->reader;
    write_ensemble(target, reader.header(), reader.keys(), [&](std::size_t block) { return reader.read_block(block); });
    return;
  }
  std::vector<EnsembleReader> readers;
  for (const auto& [block, source] : found.single) readers.push_back(source->reader);
  join_blocks(planned, target, readers, nullptr);
}

}  // namespace

void merge_folders(const std::vector<fs::path>& folders, const fs::path& out, ProgressStyle progress) {
  const Experiment experiment = experiment_of(folders);
  const std::vector<RunFolder> locks = lock_folders(folders, out);
  // What a folder holds is no part of what is wanted: the plan of an empty one.
  const std::vector<PlannedEnsemble> ensembles = all_ensembles(experiment, {});
  std::vector<Found> found(ensembles.size());
  for (const fs::path& folder : folders) {
    require_known(ensembles, folder);
    for (std::size_t i = 0; i < ensembles.size(); ++i) look_into(ensembles[i], folder, found[i]);
  }
  for (std::size_t i = 0; i < ensembles.size(); ++i) {
    if (found[i].whole == nullptr) continue;
    for (const auto& [block, source] : found[i].single) {
      require_same(ensembles[i], *found[i].whole, *source, block);
    }
  }
  require_complete(ensembles, found, folders);

  make_folder(out);
  require_own_results(out, print_experiment(experiment));
  keep_experiment(out, print_experiment(experiment));
  make_folder(out / "ensembles");
  for (std::size_t i = 0; i < ensembles.size(); ++i) {
    throw_if_interrupted();
    write_whole(ensembles[i], out / ensembles[i].file, found[i]);
    BlockFiles(ensembles[i], out).remove();
    log_line(progress, fmt::format("merged {}: {} blocks", ensembles[i].label, ensembles[i].spec.response.blocks));
  }
  forget_shards(out);
}

}  // namespace granuscope
