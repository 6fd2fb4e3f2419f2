#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ensemble/ensemble_spec.h"
#include "sampling/sampler.h"
#include "storage/block_sums.h"

namespace granuscope {

/// A quantity that an estimator sums, and its width: the number of columns for a profile, 1 for a number per layer.
struct QuantityShape {
  std::string name;
  int width;
};

/// Measures samples one after another and adds them to the sums of one block: loads in, sums out. Not thread-safe: one
/// for each block. What it adds depends on the ensemble and the sample only.
class Estimator {
 public:
  virtual ~Estimator() = default;

  /// Draws what the sample needs and adds it. Where a pile could not be completed, returns where it got stuck and adds
  /// nothing. Every pile's exact identities are asserted.
  virtual std::optional<SamplingFailure> measure(std::uint64_t sample) = 0;

  /// What measure() adds and returns for one sample after the other; `failures` has an entry per sample.
  virtual void measure_samples(std::span<const std::uint64_t> samples,
                               std::span<std::optional<SamplingFailure>> failures) {
    for (std::size_t k = 0; k < samples.size(); ++k) failures[k] = measure(samples[k]);
  }
};

/// What the estimator of the ensemble sums.
std::vector<QuantityShape> quantities_of(const EnsembleSpec& spec);

/// What it reads of its piles.
KeptLayers layers_to_keep(const EnsembleSpec& spec);

/// How many piles an estimator hands a sampler at once.
std::size_t piles_at_once(const EnsembleSpec& spec);

/// What an estimator draws its piles with. Where each sample is two piles under two loads and the law keeps a chain for
/// a load, the two are different samplers.
struct Samplers {
  Sampler &first, &second;
};
bool needs_two_samplers(const EnsembleSpec& spec);

/// Piles that a sample consists of: two where each is drawn under two loads, the pair of `paired` or of opposite signs.
int piles_per_sample(const EnsembleSpec& spec);

/// Beads that so many samples consist of, in all their piles.
std::uint64_t beads_of(const EnsembleSpec& spec, std::uint64_t samples);

/// Memory that one thread needs for drawing the samples of the ensemble, in bytes.
double drawing_memory(const EnsembleSpec& spec);

/// `sums` holds zeros of these shapes; it and the samplers, which are of the ensemble, outlive the estimator.
std::unique_ptr<Estimator> make_estimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block);

}  // namespace granuscope
