#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ensemble/ensemble_spec.h"
#include "model/pile.h"
#include "sampling/pile_group.h"
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

/// Draws samples that all have one load, as many at once as there are `loads` (all the same), and hands each group to
/// `add` with the failures of its piles.
template <typename Add>
void draw_alike(Sampler& sampler, const std::vector<std::span<const double>>& loads,
                std::span<const std::uint64_t> samples, std::span<std::optional<SamplingFailure>> failures, Add add) {
  for (std::size_t done = 0; done < failures.size(); done += loads.size()) {
    const std::size_t count = std::min(loads.size(), failures.size() - done);
    std::size_t next = done;
    for (const PileGroup& group :
         sampler.draw_groups(samples.subspan(done, count), {loads.data(), count}, failures.subspan(done, count))) {
      add(group, failures.subspan(next, group.piles));
      next += group.piles;
    }
  }
}

/// Where the sums of one quantity in one block of the ensemble stand: entries [layers, width].
class BlockSlice {
 public:
  BlockSlice() = default;
  BlockSlice(BlockSums& sums, const std::string& quantity, int block) {
    QuantitySums& q = sums.quantities.at(quantity);
    width_ = static_cast<std::size_t>(q.width);
    const std::size_t offset = static_cast<std::size_t>(block - sums.first_block) * sums.layers.size() * width_;
    sum_ = q.sum.data() + offset;
    if (q.has_squares()) sum_of_squares_ = q.sum_of_squares.data() + offset;
  }

  /// Adds one sample's value at recorded layer number `row`: of a number per layer,
  void add(std::size_t row, double value) const {
    sum_[row] += value;
    sum_of_squares_[row] += value * value;
  }
  /// or of a profile.
  void add(std::size_t row, std::size_t column, double value) const { sum_[row * width_ + column] += value; }

 private:
  double* sum_ = nullptr;
  double* sum_of_squares_ = nullptr;
  std::size_t width_ = 0;
};

/// What every estimator sums of its piles, layer by layer: "thrust", sqrt(3) sum(H_R - H_L) / sum(w) over the contacts
/// leaving the layer, and "weight_variance", the mean over columns of (w/<w> - 1)^2, <w> known exactly,
/// and what the model counts besides (extra_names).
class LayerObservables {
 public:
  using Failures = std::span<const std::optional<SamplingFailure>>;

  static std::vector<QuantityShape> quantities(const EnsembleSpec& spec);
  LayerObservables(const EnsembleSpec& spec, BlockSums& sums, int block);
  void add(const Pile& pile) const;
  /// Those of the piles that did not fail; `failures` has an entry per pile.
  void add(const PileGroup& group, Failures failures) const;
  /// Of two groups whose piles make one sample each: the means of their observables.
  void add_mean(const PileGroup& one, const PileGroup& other, Failures failures) const;
  /// At recorded layer number l: their means over the layers that lie `offset` plus that layer below the bases.
  void add_means(const PileGroup& group, Failures failures, const std::vector<int>& bases, int offset) const;

 private:
  /// The moments of a layer, divided by what makes them the observables.
  static LayerMoments of_layer(const PileGroup& group, int layer);
  void add(std::size_t l, double thrust, double variance) const;
  /// Of both groups, the means; they may be the same one.
  void add_extras(std::size_t l, const PileGroup& one, const PileGroup& other, Failures failures) const;

  const std::vector<int>& layers_;
  BlockSlice thrust_, variance_;
  std::vector<BlockSlice> extras_;
};

}  // namespace granuscope
