#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/ensemble_stage.h"

namespace granuscope {

/// What is to be known of a block beside its numbers.
struct BlockNote {
  int block = 0;
  std::uint64_t samples = 0;  ///< that entered it
  std::string key;            ///< key_of_block
  SamplerCounts counts = {};
  std::vector<FailedSample> failed;
};

/// Of a record that holds a single block.
BlockNote note_of(const EnsembleRecord& block);

/// What a whole ensemble says of itself, from the notes of all its blocks in order, and for a grown ensemble from the
/// smaller one, or null.
EnsembleRecord header_of(const PlannedEnsemble& planned, const std::vector<BlockNote>& blocks,
                         const EnsembleRecord* smaller);

std::string to_bytes(const std::vector<BlockNote>& notes);
std::vector<BlockNote> notes_from(std::string_view bytes);

/// The blocks of one ensemble at their places in one file beside their own (block_files.h), put there by whoever draws
/// them: then nobody has to join them one after the other when all are there. It counts for nothing until its notes are
/// complete.
class PlacedBlocks {
 public:
  PlacedBlocks(const PlannedEnsemble& planned, const std::filesystem::path& run_folder);

  const std::filesystem::path& file() const { return file_; }
  /// Makes the file, empty; one that is there is forgotten. Before anybody opens it.
  void begin() const;
  /// The file opened to put blocks there.
  std::unique_ptr<SharedEnsemble> open() const;
  /// All blocks are at their places.
  void keep_notes(const std::vector<BlockNote>& notes) const;
  bool complete() const { return notes().has_value(); }
  /// Makes the file the ensemble. False, with nothing done, if not all blocks are known to be there.
  bool finish() const;

 private:
  std::optional<std::vector<BlockNote>> notes() const;

  const PlannedEnsemble& planned_;
  std::filesystem::path whole_, file_, notes_;
};

}  // namespace granuscope
