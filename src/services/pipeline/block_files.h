#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/sample_stage.h"

namespace granuscope {
/// The blocks of one ensemble as files of their own, in a folder beside the place of the whole:
/// ensembles/mu-0.3.blocks/7.h5. Whoever draws a block writes its file, whole or not at all, and the same one as
/// everybody else would: shards and ranks share nothing but these files, and none of them waits for another.
class BlockFiles {
 public:
  /// Both must outlive this object.
  BlockFiles(const PlannedEnsemble& planned, const std::filesystem::path& run_folder)
      : planned_(planned), run_folder_(run_folder) {}

  std::filesystem::path folder() const;
  std::filesystem::path file(int block) const;
  /// Removes them all, and the folder unless somebody else keeps files there.
  void remove() const;

  /// The files of blocks, whole and begun ones, without a look into them.
  std::vector<std::filesystem::path> there() const;
  /// How many whole blocks there are, likewise.
  int count() const;
  /// Samples of these blocks.
  std::uint64_t samples() const;
  /// Why the file of a block cannot be taken for it: another configuration, damage. Empty if it can; nothing if there
  /// is no file.
  std::optional<std::string> fault(int block) const;
  /// Whether the block is there and whole. A file that is not is told and will be replaced.
  bool has(int block, ProgressStyle progress) const;

  /// Draws one block on the calling thread, going on from what a killed process has left of it, and keeps it.
  EnsembleRecord draw(int block, const SamplerSpec& measured, Progress* progress, const PartPolicy& parts) const;
  /// Draws those that are not there, and joins all.
  void complete(int threads, ProgressStyle progress, const PartPolicy& parts) const;
  /// Makes the whole ensemble from its blocks, with one block in memory at a time unless they are at their places
  /// already (block_files.h), and removes their files. The bytes are those of an ensemble drawn in one piece.
  void join(ProgressStyle progress) const;

 private:
  void copy_together() const;
  void draw_missing(int threads, ProgressStyle progress, const PartPolicy& parts) const;
  std::filesystem::path part(int block) const;
  std::string configuration(int block) const;
  EnsembleRecord beginning(int block, std::uint64_t& groups) const;

  const PlannedEnsemble& planned_;
  const std::filesystem::path& run_folder_;
};

/// Writes the whole ensemble to `target` from one reader for each of its blocks, in order, and for a grown ensemble the
/// file of the smaller one, or null.
void join_blocks(const PlannedEnsemble& planned, const std::filesystem::path& target,
                 const std::vector<EnsembleReader>& blocks, const EnsembleReader* smaller);

/// What the configuration of a single block says beside that of its ensemble.
std::string block_configuration(const PlannedEnsemble& planned, int block);

/// A block of one of several ensembles: what a shard or a rank takes up and leaves whole.
struct Atom {
  std::size_t ensemble = 0;
  int block = 0;
};

/// Draws the atoms that `next` hands out, until it hands out none, on `threads` threads (0: as many as the machine
/// has), each of which holds one block. `next` is called by all of them, and so is `done`, if there is one, with each
/// block; then those that are in their files already are read and not drawn again. Throws what the first of them
/// throws.
void draw_atoms(const std::vector<PlannedEnsemble>& ensembles, const std::filesystem::path& run_folder, int threads,
                ProgressStyle style, Progress* progress, const PartPolicy& parts,
                const std::function<std::optional<Atom>()>& next,
                const std::function<void(const Atom&, const EnsembleRecord&)>& done = {});

/// What is to be known of a block beside its numbers.
struct BlockNote {
  int block = 0;
  std::uint64_t samples = 0;  ///< that entered it
  std::string key;            ///< key_of_block
  SamplerCounts counts = {};
  std::vector<FailedSample> failed;

  static auto fields(auto& one) { return std::tie(one.block, one.samples, one.key, one.counts, one.failed); }
};

/// Of a record that holds a single block.
BlockNote note_of(const EnsembleRecord& block);

/// What a whole ensemble says of itself, from the notes of all its blocks in order, and for a grown ensemble from the
/// smaller one, or null.
EnsembleRecord header_of(const PlannedEnsemble& planned, const std::vector<BlockNote>& blocks,
                         const EnsembleRecord* smaller);

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
