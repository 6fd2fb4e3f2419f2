#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "model/sampler_counts.h"
#include "storage/block_sums.h"

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

/// Writes /<quantity>/sum and /sum_of_squares [blocks, layers, width], /count [blocks], /layers; attributes as above.
/// The same record gives the same bytes. Throws EnvironmentError.
void write_ensemble(const std::filesystem::path& file, const EnsembleRecord& record);

/// Throws InputError for a missing, damaged or foreign file, wrong shapes, or numbers that are not finite or not those
/// that were written (attribute sums_key).
EnsembleRecord read_ensemble(const std::filesystem::path& file);

/// The configuration alone, without reading the sums. Throws InputError as read_ensemble does for what it touches.
std::string read_ensemble_configuration(const std::filesystem::path& file);

}  // namespace granuscope
