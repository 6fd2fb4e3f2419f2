#include "pipeline/shards.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <utility>

#include "ensemble/estimator.h"
#include "experiment/experiment_file.h"
#include "pipeline/run_folder.h"
#include "storage/ensemble_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {
constexpr const char* shards_folder = "shards";
constexpr int most_shards = 1'000'000;

/// A whole number and nothing else.
std::optional<int> number_in(std::string_view text) {
  int number = 0;
  return read_whole(text, number) ? std::optional(number) : std::nullopt;
}

/// A process by its number from 0 on among several.
struct Place {
  int index = 0, count = 1;
};

/// Two variables of an environment, if it sets both.
std::optional<Place> place_from(const std::function<std::string(const char*)>& variable, const char* index,
                                const char* count) {
  const auto i = number_in(variable(index)), n = number_in(variable(count));
  if (!i || !n || *n < 1) return std::nullopt;
  return Place{*i, *n};
}

std::optional<Place> place_in_array(const std::function<std::string(const char*)>& variable) {
  auto place = place_from(variable, "SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT");
  if (!place) return std::nullopt;
  const int first = number_in(variable("SLURM_ARRAY_TASK_MIN")).value_or(0);
  const int step = number_in(variable("SLURM_ARRAY_TASK_STEP")).value_or(1);
  const int last = number_in(variable("SLURM_ARRAY_TASK_MAX")).value_or(first + (place->count - 1) * std::max(1, step));
  // A part of an array (--array=3,7, or one task again) would be taken for another, smaller one.
  const bool even = step > 0 && (place->index - first) % step == 0 && last == first + (place->count - 1) * step;
  if (!even || (place->count == 1 && first > 1)) {
    throw InputError(
        "--shard auto: task {} of an array of {} from {} to {} is no place in a whole array, which has even steps and "
        "more than one task; submit all of it, or write --shard K/N with the N of the first submission",
        place->index, place->count, first, last);
  }
  place->index = (place->index - first) / step;
  return place;
}

std::optional<Place> place_among_tasks(const std::function<std::string(const char*)>& variable) {
  if (auto place = place_from(variable, "OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE")) return place;
  if (auto place = place_from(variable, "PMI_RANK", "PMI_SIZE")) return place;
  // The script of a batch job has SLURM_PROCID too, but is one process whatever --ntasks says.
  return place_from(variable, "SLURM_PROCID", "SLURM_STEP_NUM_TASKS");
}

/// Keeps other processes from being the same shard in the same folder.
FileDescriptor lock_shard(const fs::path& folder, Shard shard) {
  make_folder(folder / shards_folder);
  const fs::path name = folder / shards_folder / fmt::format("{}-of-{}", shard.number, shard.count);
  FileDescriptor lock(::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (!lock_file(lock, false)) {
    throw BusyError(
        "shard {}/{} is at work in '{}' already, and both would draw the same blocks; wait for its end, or give each "
        "process a number of its own (--shard auto)",
        shard.number, shard.count, folder.string());
  }
  return lock;
}

/// The shard whose lock has this name.
std::optional<Shard> shard_in_name(std::string_view name) {
  const std::size_t between = name.find("-of-");
  if (between == std::string_view::npos) return std::nullopt;
  const auto number = number_in(name.substr(0, between)), count = number_in(name.substr(between + 4));
  if (!number || !count) return std::nullopt;
  return Shard{*number, *count};
}

/// The largest count of shards that have worked in a folder; 0 if none has.
int shards_seen(const fs::path& folder) {
  int most = 0;
  for (const fs::path& entry : entries_of(folder / shards_folder)) {
    if (const auto shard = shard_in_name(entry.filename().string())) most = std::max(most, shard->count);
  }
  return most;
}

}  // namespace

Shard shard_named(const std::string& text, const std::function<std::string(const char*)>& variable,
                  const fs::path& folder) {
  if (text == "auto") {
    const auto array = place_in_array(variable), tasks = place_among_tasks(variable);
    if (!array && !tasks) {
      throw InputError(
          "--shard auto finds no variables of a Slurm array, srun, Open MPI or MPICH, so that it cannot know which "
          "shard this is; start it by one of them, or write --shard K/N");
    }
    const Place outer = array.value_or(Place{}), inner = tasks.value_or(Place{});
    const Shard shard{outer.index * inner.count + inner.index + 1, outer.count * inner.count};
    if (shard.number < 1 || shard.number > shard.count || shard.count > most_shards) {
      throw InputError(
          "--shard auto: the environment says {} of {} (array {} of {}, task {} of {}), which is none of them; write "
          "--shard K/N",
          shard.number, shard.count, outer.index, outer.count, inner.index, inner.count);
    }
    if (const int seen = shards_seen(folder); array && shard.count < seen) {  // --array=1, or 3-6, of 1-16 again
      throw InputError(
          "--shard auto: this array makes {} where {} worked in '{}', and may be a part of theirs; submit all of it, "
          "write --shard K/{}, or remove the folder shards/ there",
          how_many(shard.count, "shard"), seen, folder.string(), seen);
    }
    return shard;
  }
  const std::size_t slash = text.find('/');
  const auto number = slash == std::string::npos ? std::nullopt : number_in(text.substr(0, slash));
  const auto count = slash == std::string::npos ? std::nullopt : number_in(text.substr(slash + 1));
  if (!number || !count || *number < 1 || *number > *count || *count > most_shards) {
    throw InputError("--shard {}: this names no shard; write K/N with K from 1 to N, such as 3/16, or auto", text);
  }
  return {*number, *count};
}

bool is_one_of_tasks(const std::function<std::string(const char*)>& variable) {
  return place_among_tasks(variable).value_or(Place{}).count > 1;
}

std::vector<PlannedEnsemble> all_ensembles(const Experiment& experiment, const fs::path& run_folder) {
  std::vector<PlannedEnsemble> ensembles = plan_ensembles(experiment, run_folder);
  for (const StudyEnsemble& one : experiment.studies.ensembles(experiment)) {
    ensembles.push_back(plan_ensemble(one, run_folder));
  }
  return ensembles;
}

double relative_cost(const EnsembleSpec& spec) {
  // Granusolve takes 12 to 20 ns a bead from mu = 0 to 1, chains hundreds of sweeps a pile; what is recorded costs less
  // than drawing. Only what does not divide evenly depends on it.
  const ModelSpec& model = spec.sampler.model;
  const double mu = spec.sampler.mu, grid = model.stochastic_osl.grid;
  double by_law = mu == 0 ? 0.1 : 1 + std::min(mu, 1.0);
  if (mu > 0 && spec.sampler.law != Law::granusolve) by_law *= 1000;
  // Three nanoseconds a bead; half a nanosecond a node; and 0.7 microseconds times the beads of the whole pile.
  if (!model.has_contacts()) by_law = 0.2;
  if (model.name == ModelName::stochastic_osl) by_law += 0.03 * grid * grid;
  if (model.name == ModelName::diluted_beads) by_law = 50.0 * spec.lattice.columns * spec.lattice.layers;
  if (spec.response.estimator == EstimatorName::fluctuation) by_law *= 2;
  return by_law * static_cast<double>(beads_of(spec, spec.response.samples)) / spec.response.blocks;
}

std::vector<Atom> atoms_of(const std::vector<PlannedEnsemble>& ensembles) {
  std::vector<double> cost;
  cost.reserve(ensembles.size());
  for (const PlannedEnsemble& planned : ensembles) cost.push_back(relative_cost(planned.spec));
  std::vector<std::size_t> order(ensembles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return cost[a] > cost[b]; });
  std::vector<Atom> atoms;
  for (const std::size_t ensemble : order) {
    for (int block = 0; block < ensembles[ensemble].spec.response.blocks; ++block) atoms.push_back({ensemble, block});
  }
  return atoms;
}

std::vector<std::vector<Atom>> deal(const std::vector<PlannedEnsemble>& ensembles, int count) {
  const std::vector<Atom> atoms = atoms_of(ensembles);
  if (atoms.size() < static_cast<std::size_t>(count)) {
    throw InputError(
        "{} shards are more than the {} blocks of this experiment, and a block is what one of them draws; raise "
        "response.blocks (with response.samples, eight piles for each block at least), or use fewer shards",
        count, atoms.size());
  }
  // Longest first, each to the shard that has least to do: blocks of one ensemble are alike, so they go round.
  std::vector<std::vector<Atom>> hands(static_cast<std::size_t>(count));
  std::set<std::pair<double, std::size_t>> load;
  for (std::size_t k = 0; k < hands.size(); ++k) load.insert({0.0, k});
  for (const Atom& atom : atoms) {
    auto [least, k] = *load.begin();
    load.erase(load.begin());
    hands[k].push_back(atom);
    load.insert({least + relative_cost(ensembles[atom.ensemble].spec), k});
  }
  return hands;
}

void keep_experiment(const fs::path& folder, const std::string& resolved) {
  const fs::path file = folder / "experiment.toml";
  if (path_exists(file)) {
    if (read_file(file) == resolved) return;
    throw InputError(
        "'{}' is another experiment than this one, and the blocks of both would be mixed up; choose another --out, or "
        "remove that folder",
        file.string());
  }
  write_file(file, resolved);
}

std::vector<PlannedStep> plan_shard(const Experiment& experiment, const RunOptions& options, Shard shard) {
  const std::vector<PlannedEnsemble> ensembles = all_ensembles(experiment, options.folder);
  const std::vector<Atom> hand = deal(ensembles, shard.count).at(static_cast<std::size_t>(shard.number - 1));
  std::vector<PlannedStep> steps;
  for (std::size_t i = 0; i < ensembles.size(); ++i) {
    const PlannedEnsemble& planned = ensembles[i];
    int held = 0, there = 0;
    std::uint64_t left = 0;
    for (const Atom& atom : hand) {
      if (atom.ensemble != i) continue;
      ++held;
      const bool drawn = planned.reusable || BlockFiles(planned, options.folder).fault(atom.block) == "";
      there += drawn ? 1 : 0;
      left += drawn ? 0 : samples_in_block(planned.spec, atom.block, groups_of(planned.spec));
    }
    if (held == 0) continue;
    const std::string what = fmt::format("{} of {} blocks, {}{}", held, planned.spec.response.blocks, planned.label,
                                         there == 0 ? "" : fmt::format(", {} of them there already", there));
    steps.push_back({Stage::sample, what, there == held, beads_of(planned.spec, left), planned.spec, left});
  }
  return steps;
}

void run_shard(const Experiment& experiment, const RunOptions& options, Shard shard) {
  const RunFolder folder(options.folder, FolderUse::shared);
  const std::vector<PlannedEnsemble> ensembles = all_ensembles(experiment, options.folder);
  const std::vector<Atom> hand = deal(ensembles, shard.count).at(static_cast<std::size_t>(shard.number - 1));
  if (!options.force) require_own_results(options.folder, print_experiment(experiment));
  keep_experiment(options.folder, print_experiment(experiment));
  const FileDescriptor lock = lock_shard(options.folder, shard);
  std::vector<Atom> missing;
  std::uint64_t samples = 0;
  for (const Atom& atom : hand) {
    const PlannedEnsemble& planned = ensembles[atom.ensemble];
    if (planned.reusable || BlockFiles(planned, options.folder).has(atom.block, options.progress)) continue;
    missing.push_back(atom);
    samples += samples_in_block(planned.spec, atom.block, groups_of(planned.spec));
  }
  log_line(options.progress, "shard {}/{}: {} of the {} blocks of this experiment, {} of them to draw", shard.number,
           shard.count, hand.size(), atoms_of(ensembles).size(), missing.size());
  if (missing.empty()) return;
  Progress progress(fmt::format("shard {}/{}", shard.number, shard.count), samples, options.progress);
  std::atomic<std::size_t> taken{0};
  std::atomic<std::uint64_t> completed{0};
  draw_atoms(
      ensembles, options.folder, options.threads, options.progress, &progress, {},
      [&]() -> std::optional<Atom> {
        const std::size_t at = taken++;
        return at < missing.size() ? std::optional(missing[at]) : std::nullopt;
      },
      [&](const Atom&, const EnsembleRecord& block) { completed += block.sums.samples(); });
  progress.finish();
  if (completed == 0)
    throw InputError(
        "shard {}/{}: no pile of its blocks could be completed; take fewer columns or more sampling.effort",
        shard.number, shard.count);
}

void forget_shards(const fs::path& run_folder) {
  remove_own_files(run_folder / shards_folder, [](std::string_view name) { return shard_in_name(name).has_value(); });
}

namespace {

/// Commands that draw the given missing blocks, for a folder in which shards have worked: those of the shards that have
/// them, by the largest count of shards that the folder has seen.
std::vector<std::string> commands_for(const std::vector<PlannedEnsemble>& ensembles, const std::vector<Atom>& missing,
                                      const std::vector<fs::path>& folders) {
  fs::path folder = folders.front();
  int count = 0;
  for (const fs::path& one : folders) {
    if (const int seen = shards_seen(one); seen > count) {
      count = seen;
      folder = one;
    }
  }
  const std::string run = fmt::format("granuscope run {}", shell_word((folder / "experiment.toml").string()));
  const std::string out = fmt::format(" --out {}", shell_word(folder.string()));
  std::vector<std::string> commands;
  const std::size_t atoms = atoms_of(ensembles).size();
  if (count == 0 || static_cast<std::size_t>(count) > atoms) return {run + " --shard 1/1" + out};
  const auto hands = deal(ensembles, count);
  for (std::size_t k = 0; k < hands.size(); ++k) {
    const bool wanted = std::ranges::any_of(missing, [&](const Atom& atom) {
      return std::ranges::any_of(
          hands[k], [&](const Atom& held) { return held.ensemble == atom.ensemble && held.block == atom.block; });
    });
    if (wanted) commands.push_back(fmt::format("{} --shard {}/{}{}", run, k + 1, count, out));
  }
  return commands;
}

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
      "'{}' and '{}' hold block {} of {} with different numbers, though of one experiment and sampling version, so "
      "that at least one of them is wrong; draw it again, and remove the file that differs",
      a.file.string(), b.file.string(), block, planned.label);
}

std::shared_ptr<const Source> open(const PlannedEnsemble& planned, const fs::path& file,
                                   const std::string& configuration, int first_block, int blocks) {
  auto source = std::make_shared<const Source>(Source{file, EnsembleReader(file)});
  const EnsembleRecord& header = source->reader.header();
  if (header.configuration != configuration) {
    throw InputError(
        "'{}' is of another experiment than the one to be merged, so that their piles do not belong together: {}; "
        "leave it out, or merge it with those of its own",
        file.string(), describe_difference(header.configuration, configuration));
  }
  require_shape(file, header, planned.spec, first_block, blocks);
  return source;
}

void look_into(const PlannedEnsemble& planned, const fs::path& folder, Found& found) {
  const int blocks = planned.spec.response.blocks;
  if (const fs::path file = folder / planned.file; path_exists(file)) {
    const auto whole = open(planned, file, configuration_text(planned.spec) + planned.notes, 0, blocks);
    for (int block = 0; block < blocks && found.whole != nullptr; ++block) {
      require_same(planned, *found.whole, *whole, block);
    }
    if (found.whole == nullptr) found.whole = whole;
  }
  const BlockFiles files(planned, folder);
  for (int block = 0; block < blocks; ++block) {
    throw_if_interrupted();
    if (!path_exists(files.file(block))) continue;
    const auto source = open(planned, files.file(block), block_configuration(planned, block), block, 1);
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
  for (const fs::path& entry : entries_of(folder / "ensembles")) {
    if (entry.extension() == ".blocks" && !known.contains(entry.filename().string())) {
      throw InputError(
          "'{}' holds blocks of an ensemble that the experiment to be merged does not have; leave that folder out, or "
          "merge it with those of its own",
          entry.string());
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
  throw InputError("{}, so that nothing was merged ({}); to be drawn by: {}",
                   how_many(missing.size(), "block is missing", "blocks are missing"), fmt::join(words, "; "),
                   fmt::join(commands_for(ensembles, missing, folders), "; "));
}

Experiment experiment_of(const std::vector<fs::path>& folders) {
  for (const fs::path& folder : folders) {
    require_visible(folder / "experiment.toml");
    if (!folder_exists(folder)) {
      throw InputError("'{}' is no folder; name folders in which shards have worked", folder.string());
    }
  }
  for (const fs::path& folder : folders) {
    if (path_exists(folder / "experiment.toml")) return read_experiment(folder / "experiment.toml");
  }
  throw InputError(
      "'{}' holds no experiment.toml, so that nobody knows what to merge; name folders in which shards (run --shard) "
      "have worked",
      folders.front().string());
}

/// While blocks are still being drawn, those that are missing are no fault. Each folder once, however it is named; that
/// of the result, which is made only when all is there, only if it is there.
std::vector<RunFolder> lock_folders(const std::vector<fs::path>& folders, const fs::path& out) {
  std::set<fs::path> sources;
  for (const fs::path& folder : folders) sources.insert(fs::canonical(folder));
  std::vector<RunFolder> locks;
  if (folder_exists(out)) {
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

bool merge_folders(const std::vector<fs::path>& folders, const fs::path& out, ProgressStyle progress) {
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
    for (const auto& [block, source] : found[i].single) require_same(ensembles[i], *found[i].whole, *source, block);
  }
  require_complete(ensembles, found, folders);

  make_folder(out);
  require_own_results(out, print_experiment(experiment));
  keep_experiment(out, print_experiment(experiment));
  make_folder(out / "ensembles");
  for (std::size_t i = 0; i < ensembles.size(); ++i) {
    throw_if_interrupted();
    write_whole(ensembles[i], out / ensembles[i].file, found[i]);
    (void)open_ensemble(out / ensembles[i].file);  // is whole on disk before its blocks are removed
    BlockFiles(ensembles[i], out).remove();
    log_line(progress, "{} {}: {} blocks", found[i].whole == nullptr ? "merged" : "whole already", ensembles[i].label,
             ensembles[i].spec.response.blocks);
  }
  forget_shards(out);
  return std::ranges::any_of(found, [](const Found& one) { return one.whole == nullptr; });
}

}  // namespace granuscope
