#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "model/pile.h"
#include "storage/block_sums.h"
#include "storage/hdf5_file.h"

namespace granuscope {
/// A pile that could not be completed within the stated effort.
struct FailedSample {
  std::uint64_t sample = 0;
  int layer = 0;       ///< the layer where the effort ran out
  std::string replay;  ///< the command that meets the same failure again

  static auto fields(auto& one) { return std::tie(one.sample, one.layer, one.replay); }
};

/// An ensemble as stored: its sums, what the sampler did, which piles failed, and what it is an ensemble of.
struct EnsembleRecord {
  std::string configuration;      ///< resolved, canonical text; two ensembles may be merged only if it is equal
  std::string configuration_key;  ///< cache_key(configuration)
  std::string sampling_version;   ///< changes whenever the samples change
  BlockSums sums;
  SamplerCounts counts;
  std::vector<FailedSample> failed;
};

/// Writes /<quantity>/sum [blocks, layers, width], /sum_of_squares of those that have it, /count and /block_keys
/// [blocks], /layers; attributes as above. The same record gives the same bytes. Throws EnvironmentError.
void write_ensemble(const std::filesystem::path& file, const EnsembleRecord& record);

/// The same bytes with one block in memory at a time. The quantities of `header` have their widths, but need no
/// numbers; `keys` are the blocks' (key_of_block), and `block` gives the one at a place.
void write_ensemble(const std::filesystem::path& file, const EnsembleRecord& header,
                    const std::vector<std::string>& keys, const std::function<BlockSums(std::size_t)>& block);

/// The same file again, while its blocks are put at their places by any number of processes and in any order. `header`
/// is as above, but of the blocks only their number counts.
class SharedEnsemble {
 public:
  /// `file` is there, empty or opened by others before.
  SharedEnsemble(const std::filesystem::path& file, EnsembleRecord header);
  /// Puts a block at its place; it is on disk when this returns. Any number of threads may do so.
  void put(std::size_t at, const BlockSums& block);

 private:
  Hdf5Writer writer_;
};

/// Ends it: with all blocks at their places in `file`, writes what is to be known of them, and renames it to `target`.
/// False, with nothing done, if that leaves no place for them where they are.
bool finish_shared(const std::filesystem::path& file, const std::filesystem::path& target, const EnsembleRecord& header,
                   const std::vector<std::string>& keys);

/// Throws InputError for a missing, damaged or foreign file, wrong shapes, or numbers that are not finite or not those
/// that were written (block_keys).
EnsembleRecord read_ensemble(const std::filesystem::path& file);

/// The same with the profiles left in the file, from which they are read a layer at a time: the memory does not depend
/// on how large it is. All is read once, to find damage now and not later; the file may be replaced meanwhile, but not
/// changed.
EnsembleRecord open_ensemble(const std::filesystem::path& file);

/// The configuration alone, without reading the sums. Throws InputError as read_ensemble does for what it touches.
std::string read_ensemble_configuration(const std::filesystem::path& file);

/// An ensemble file whose blocks are read one at a time. Errors as of read_ensemble.
class EnsembleReader {
 public:
  explicit EnsembleReader(const std::filesystem::path& file);

  /// All but the numbers of the sums.
  const EnsembleRecord& header() const { return header_; }
  const std::vector<std::string>& keys() const { return keys_; }
  /// The block at this place of the file.
  BlockSums read_block(std::size_t at) const;

 private:
  friend EnsembleRecord open_ensemble(const std::filesystem::path& file);
  struct Stored {
    RawData sum, sum_of_squares;
  };
  class Profiles;

  BlockSums read_block(std::size_t at, const RawDataFile& numbers) const;

  std::filesystem::path file_;
  EnsembleRecord header_;
  std::vector<std::string> keys_;
  std::map<std::string, Stored> stored_;
};

/// The lines "key=value" of a configuration as one JSON object, for whoever reads a file without this program: numbers,
/// true and false as such, all else as text.
std::string configuration_json(std::string_view lines);

}  // namespace granuscope
