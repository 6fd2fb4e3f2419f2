#include "pipeline/block_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <mutex>
#include <system_error>
#include <utility>

#include "ensemble/ensemble_runner.h"
#include "pipeline/run_folder.h"
#include "storage/block_sums.h"
#include "storage/ensemble_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/provenance.h"

namespace granuscope {
std::string block_configuration(const PlannedEnsemble& planned, int block) {
  std::string text = configuration_text(planned.spec) + fmt::format("block={}\n", block);
  // The counters and failures of a grown block are those of its new groups only.
  if (planned.groups_before > 0) text += fmt::format("groups_before={}\n", planned.groups_before);
  return text;
}

fs::path BlockFiles::folder() const {
  fs::path folder = run_folder_ / planned_.file;
  return folder.replace_extension(".blocks");
}

fs::path BlockFiles::file(int block) const { return folder() / fmt::format("{}.h5", block); }

namespace {

/// The number of the block whose file has this name; nothing of other names.
std::optional<int> block_named(std::string_view name, std::string_view extension) {
  int block = -1;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), block);
  const std::string_view rest(end, static_cast<std::size_t>(name.data() + name.size() - end));
  if (error != std::errc() || block < 0 || rest != extension) return std::nullopt;
  return block;
}

}  // namespace

void BlockFiles::remove() const {
  remove_own_files(folder(), [](std::string_view name) {
    return block_named(name, ".h5") || block_named(name, ".part.h5") || name == "whole.h5" || name == "whole.notes";
  });
}

std::vector<fs::path> BlockFiles::there() const {
  std::vector<fs::path> found;
  for (const fs::path& entry : entries_of(folder())) {
    const std::string name = entry.filename().string();
    if (block_named(name, ".h5") || block_named(name, ".part.h5")) found.push_back(entry);
  }
  return found;
}

fs::path BlockFiles::part(int block) const { return folder() / fmt::format("{}.part.h5", block); }

std::string BlockFiles::configuration(int block) const { return block_configuration(planned_, block); }

int BlockFiles::count() const {
  if (run_folder_.empty()) return 0;
  const std::vector<fs::path> files = there();
  return static_cast<int>(std::ranges::count_if(files, [&](const fs::path& file) {
    const std::optional<int> block = block_named(file.filename().string(), ".h5");
    return block && *block < planned_.spec.response.blocks;
  }));
}

std::uint64_t BlockFiles::samples() const {
  std::uint64_t found = 0;
  for (int block = 0; block < planned_.spec.response.blocks; ++block) {
    if (path_exists(file(block))) found += samples_in_block(planned_.spec, block, groups_of(planned_.spec));
  }
  return found;
}

std::optional<std::string> BlockFiles::fault(int block) const {
  if (!path_exists(file(block))) return std::nullopt;
  try {
    const EnsembleReader reader(file(block));
    const EnsembleRecord& header = reader.header();
    if (header.configuration != configuration(block)) {
      return "it is of another experiment: " + describe_difference(header.configuration, configuration(block));
    }
    require_shape(file(block), header, planned_.spec, block, 1);
    (void)reader.read_block(0);
  } catch (const InputError& damage) {
    return damage.what();
  }
  return "";
}

bool BlockFiles::has(int block, ProgressStyle progress) const {
  const std::optional<std::string> found = fault(block);
  if (found && !found->empty()) {
    log_line(progress, "sampling {}: '{}' is drawn again and replaced: {}", planned_.label, file(block).string(),
             *found);
  }
  return found && found->empty();
}

EnsembleRecord BlockFiles::beginning(int block, std::uint64_t& groups) const {
  EnsembleRecord nothing = begin_blocks(planned_.spec, block, 1);
  if (path_exists(part(block))) {
    try {
      const std::string there = read_ensemble_configuration(part(block));
      const std::uint64_t drawn = count_in(there, "groups_drawn");
      if (there == configuration(block) + fmt::format("groups_drawn={}\n", drawn)) {
        EnsembleRecord begun = read_ensemble(part(block));
        require_shape(part(block), begun, planned_.spec, block, 1);
        groups = drawn;
        return begun;
      }
    } catch (const InputError&) {  // NOLINT(bugprone-empty-catch): damaged, so that it is drawn again
    }
  }
  groups = planned_.groups_before;
  if (groups > 0)
    nothing.sums = EnsembleReader(run_folder_ / planned_.file).read_block(static_cast<std::size_t>(block));
  return nothing;
}

EnsembleRecord BlockFiles::draw(int block, const SamplerSpec& measured, Progress* progress,
                                const PartPolicy& parts) const {
  make_folder(folder());
  std::uint64_t groups = 0;
  EnsembleRecord record = beginning(block, groups);
  const auto keep = [&](const fs::path& target, const std::string& configuration) {
    record.configuration = configuration;
    record.configuration_key = cache_key(configuration);
    write_ensemble(target, record);
  };
  if (progress != nullptr) progress->advance(samples_in_block(planned_.spec, block, groups));
  draw_in_pieces(planned_.spec, measured, groups, record, 1, progress, parts, [&](std::uint64_t drawn) {
    keep(part(block), configuration(block) + fmt::format("groups_drawn={}\n", drawn));
  });
  keep(file(block), configuration(block));
  remove_if_there(part(block));
  return record;
}

void BlockFiles::draw_missing(int threads, ProgressStyle progress, const PartPolicy& parts) const {
  std::vector<int> missing;
  for (int block = 0; block < planned_.spec.response.blocks; ++block) {
    if (!has(block, progress)) missing.push_back(block);
  }
  log_line(progress, "sampling {}: {} of {} blocks are there already", planned_.label,
           planned_.spec.response.blocks - static_cast<int>(missing.size()), planned_.spec.response.blocks);
  if (missing.empty()) return;
  Progress shown(
      fmt::format("sampling {}", planned_.label),
      planned_.spec.response.samples * missing.size() / static_cast<std::uint64_t>(planned_.spec.response.blocks),
      progress);
  std::atomic<std::size_t> taken{0};
  draw_atoms({planned_}, run_folder_, threads, progress, &shown, parts, [&]() -> std::optional<Atom> {
    const std::size_t at = taken++;
    if (at >= missing.size()) return std::nullopt;
    return Atom{0, missing[at]};
  });
  shown.finish();
}

void join_blocks(const PlannedEnsemble& planned, const fs::path& target, const std::vector<EnsembleReader>& blocks,
                 const EnsembleReader* smaller) {
  std::vector<BlockNote> notes;
  std::vector<std::string> keys;
  for (const EnsembleReader& block : blocks) {
    const EnsembleRecord& one = block.header();
    keys.push_back(block.keys().at(0));
    notes.push_back({one.sums.first_block, one.sums.count.at(0), keys.back(), one.counts, one.failed});
  }
  write_ensemble(target, header_of(planned, notes, smaller == nullptr ? nullptr : &smaller->header()), keys,
                 [&](std::size_t block) { return blocks[block].read_block(0); });
}

void BlockFiles::complete(int threads, ProgressStyle progress, const PartPolicy& parts) const {
  if (count() == planned_.spec.response.blocks) {
    try {
      join(progress);
      return;
    } catch (const InputError&) {  // NOLINT(bugprone-empty-catch): the look at each block tells which and why
    }
  }
  draw_missing(threads, progress, parts);
  join(progress);
}

void BlockFiles::join(ProgressStyle progress) const {
  if (!PlacedBlocks(planned_, run_folder_).finish()) copy_together();
  (void)open_ensemble(run_folder_ / planned_.file);  // is whole on disk before its blocks are removed
  remove();
  log_line(progress, "sampling {}: joined {} blocks", planned_.label, planned_.spec.response.blocks);
}

void BlockFiles::copy_together() const {
  std::vector<EnsembleReader> blocks;
  for (int block = 0; block < planned_.spec.response.blocks; ++block) {
    const EnsembleRecord& header = blocks.emplace_back(file(block)).header();
    if (header.configuration != configuration(block)) {
      throw InputError("'{}' is not block {} of {}", file(block).string(), block, planned_.label);
    }
    require_shape(file(block), header, planned_.spec, block, 1);
  }
  const fs::path whole = run_folder_ / planned_.file;
  std::optional<EnsembleReader> smaller;
  if (planned_.groups_before > 0) smaller.emplace(whole);
  join_blocks(planned_, whole, blocks, smaller ? &*smaller : nullptr);
}

void draw_atoms(const std::vector<PlannedEnsemble>& ensembles, const fs::path& run_folder, int threads,
                ProgressStyle style, Progress* progress, const PartPolicy& parts,
                const std::function<std::optional<Atom>()>& next,
                const std::function<void(const Atom&, const EnsembleRecord&)>& done) {
  struct Measured {
    std::once_flag once;
    SamplerSpec sampler;
  };
  std::vector<std::unique_ptr<Measured>> measured;
  for (std::size_t i = 0; i < ensembles.size(); ++i) measured.push_back(std::make_unique<Measured>());
  const auto workers = static_cast<std::size_t>(worker_count(threads));
  std::atomic<bool> failed{false};
  for_each_index(workers, static_cast<int>(workers), [&](std::size_t) {
    while (!failed) {
      const std::optional<Atom> atom = next();
      if (!atom) return;
      try {
        const PlannedEnsemble& planned = ensembles[atom->ensemble];
        const BlockFiles files(planned, run_folder);
        if (done && files.has(atom->block, style)) {
          done(*atom, read_ensemble(files.file(atom->block)));
          continue;
        }
        Measured& one = *measured[atom->ensemble];
        std::call_once(one.once, [&] { one.sampler = measure_sampler(planned, style); });
        const EnsembleRecord drawn = files.draw(atom->block, one.sampler, progress, parts);
        if (done) done(*atom, drawn);
      } catch (...) {
        failed = true;
        throw;
      }
    }
  });
}

namespace {

std::string whole_configuration(const PlannedEnsemble& planned) {
  return configuration_text(planned.spec) + planned.notes + "\n" + block_configuration(planned, 0);
}

}  // namespace

BlockNote note_of(const EnsembleRecord& block) {
  return {block.sums.first_block, block.sums.count.at(0), key_of_block(block.sums, 0), block.counts, block.failed};
}

EnsembleRecord header_of(const PlannedEnsemble& planned, const std::vector<BlockNote>& blocks,
                         const EnsembleRecord* smaller) {
  EnsembleRecord header = begin_blocks(planned.spec, 0, 0);
  header.configuration += planned.notes;
  header.configuration_key = cache_key(header.configuration);
  if (smaller != nullptr) {
    header.counts = smaller->counts;
    header.failed = smaller->failed;
  }
  for (const BlockNote& block : blocks) {
    header.sums.count.push_back(block.samples);
    header.counts += block.counts;
    header.failed.insert(header.failed.end(), block.failed.begin(), block.failed.end());
  }
  std::ranges::sort(header.failed,
                    [](const FailedSample& one, const FailedSample& other) { return one.sample < other.sample; });
  return header;
}

PlacedBlocks::PlacedBlocks(const PlannedEnsemble& planned, const fs::path& run_folder)
    : planned_(planned), whole_(run_folder / planned.file) {
  const fs::path folder = BlockFiles(planned, run_folder).folder();
  file_ = folder / "whole.h5";
  notes_ = folder / "whole.notes";
}

void PlacedBlocks::begin() const {
  make_folder(file_.parent_path());
  remove_if_there(notes_);
  write_file(file_, "");
}

std::unique_ptr<SharedEnsemble> PlacedBlocks::open() const {
  EnsembleRecord header = begin_blocks(planned_.spec, 0, 0);
  header.configuration += planned_.notes;
  header.configuration_key = cache_key(header.configuration);
  header.sums.count.resize(static_cast<std::size_t>(planned_.spec.response.blocks));
  return std::make_unique<SharedEnsemble>(file_, std::move(header));
}

void PlacedBlocks::keep_notes(const std::vector<BlockNote>& notes) const {
  const std::string bytes = to_bytes(std::pair(whole_configuration(planned_), notes));
  write_file(notes_, sha256(bytes) + bytes);
}

std::optional<std::vector<BlockNote>> PlacedBlocks::notes() const {
  if (!path_exists(notes_) || !path_exists(file_)) return std::nullopt;
  const std::string bytes = read_file(notes_);
  const std::size_t digest = sha256("").size();
  if (bytes.size() < digest || sha256(std::string_view(bytes).substr(digest)) != bytes.substr(0, digest)) {
    return std::nullopt;
  }
  auto kept = from_bytes<std::pair<std::string, std::vector<BlockNote>>>(std::string_view(bytes).substr(digest));
  if (kept.first != whole_configuration(planned_)) return std::nullopt;
  return std::move(kept.second);
}

bool PlacedBlocks::finish() const {
  const auto blocks = notes();
  if (!blocks) return false;
  std::optional<EnsembleReader> smaller;
  if (planned_.groups_before > 0) smaller.emplace(whole_);
  std::vector<std::string> keys;
  for (const BlockNote& block : *blocks) keys.push_back(block.key);
  return finish_shared(file_, whole_, header_of(planned_, *blocks, smaller ? &smaller->header() : nullptr), keys);
}

}  // namespace granuscope
