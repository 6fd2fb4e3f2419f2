#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "model/sampler_counts.h"
#include "storage/block_sums.h"
#include "storage/raw_data.h"

namespace granuscope {

/// A pile that could not be completed within the stated effort.
struct FailedSample {
  std::uint64_t sample = 0;
  int layer = 0;       ///< the layer where the effort ran out
  std::string replay;  ///< the command that meets the same failure again
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

/// Throws InputError for a missing, damaged or foreign file, wrong shapes, or numbers that are not finite or not those
/// that were written (block_keys).
EnsembleRecord read_ensemble(const std::filesystem::path& file);

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
  struct Stored {
    RawData sum, sum_of_squares;
  };

  std::filesystem::path file_;
  EnsembleRecord header_;
  std::vector<std::string> keys_;
  std::map<std::string, Stored> stored_;
};

}  // namespace granuscope
