#include "pipeline/placed_blocks.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "pipeline/block_files.h"
#include "storage/byte_record.h"
#include "support/atomic_file.h"
#include "support/digest.h"

namespace granuscope {
namespace fs = std::filesystem;
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
  std::sort(header.failed.begin(), header.failed.end(),
            [](const FailedSample& one, const FailedSample& other) { return one.sample < other.sample; });
  return header;
}

std::string to_bytes(const std::vector<BlockNote>& notes) {
  ByteWriter writer;
  writer.put(std::uint64_t{notes.size()});
  for (const BlockNote& note : notes) {
    writer.put(note.block);
    writer.put(note.samples);
    writer.put(note.key);
    writer.put(note.counts);
    writer.put(std::uint64_t{note.failed.size()});
    for (const FailedSample& one : note.failed) {
      writer.put(one.sample);
      writer.put(one.layer);
      writer.put(one.replay);
    }
  }
  return writer.take();
}

std::vector<BlockNote> notes_from(std::string_view bytes) {
  ByteReader reader(bytes);
  std::vector<BlockNote> notes;
  std::uint64_t count = 0;
  reader.get(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    BlockNote& note = notes.emplace_back();
    reader.get(note.block);
    reader.get(note.samples);
    reader.get(note.key);
    reader.get(note.counts);
    std::uint64_t failed = 0;
    reader.get(failed);
    for (std::uint64_t k = 0; k < failed; ++k) {
      FailedSample& one = note.failed.emplace_back();
      reader.get(one.sample);
      reader.get(one.layer);
      reader.get(one.replay);
    }
  }
  return notes;
}

PlacedBlocks::PlacedBlocks(const PlannedEnsemble& planned, const fs::path& run_folder)
    : planned_(planned), whole_(run_folder / planned.file) {
  const fs::path folder = BlockFiles(planned, run_folder).folder();
  file_ = folder / "whole.h5";
  notes_ = folder / "whole.notes";
}

void PlacedBlocks::begin() const {
  make_folder(file_.parent_path());
  std::error_code ignored;
  fs::remove(notes_, ignored);
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
  ByteWriter writer;
  writer.put(whole_configuration(planned_));
  const std::string bytes = writer.take() + to_bytes(notes);
  write_file(notes_, sha256(bytes) + bytes);
}

std::optional<std::vector<BlockNote>> PlacedBlocks::notes() const {
  std::error_code ignored;
  if (!fs::exists(notes_, ignored) || !fs::exists(file_, ignored)) return std::nullopt;
  const std::string bytes = read_file(notes_);
  const std::size_t digest = sha256("").size();
  if (bytes.size() < digest || sha256(std::string_view(bytes).substr(digest)) != bytes.substr(0, digest)) {
    return std::nullopt;
  }
  ByteReader reader(std::string_view(bytes).substr(digest));
  std::string configuration;
  reader.get(configuration);
  if (configuration != whole_configuration(planned_)) return std::nullopt;
  return notes_from(std::string_view(bytes).substr(digest + sizeof(std::uint64_t) + configuration.size()));
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
