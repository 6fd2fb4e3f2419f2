#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "model/pile.h"
#include "sampling/sampler_spec.h"
#include "storage/ensemble_file.h"

namespace granuscope {

/// Where a pile could not be completed within the stated effort.
struct SamplingFailure {
  int layer;
};

/// Draws piles of one law at one friction coefficient on one lattice. Not thread-safe: one sampler per thread.
/// A pile depends on (spec, lattice, load, sample) only, never on what was drawn before.
class Sampler {
 public:
  virtual ~Sampler() = default;

  /// Fills `pile` (of this sampler's lattice) with sample number `sample` under `load` (shape [columns], each
  /// > 0; or 0, but not all of them, where mu >= 1/sqrt 3; InputError otherwise).
  /// Returns where it got stuck if the effort ran out; the pile's contents are then not a solution.
  virtual std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) = 0;

  /// Solves again under another load, keeping the random numbers of a first solution of the same sample: every bead
  /// tries first the number that its split in `first` stands for (split_numbers.h), and draws another one only where
  /// the law makes it change its split. A law that solves no bead by itself draws the sample anew, from the same key.
  /// The pile depends on (spec, lattice, load, sample, first) only. `first` and `pile` are two piles.
  virtual std::optional<SamplingFailure> draw_again(std::uint64_t sample, std::span<const double> load,
                                                    [[maybe_unused]] const Pile& first, Pile& pile) {
    return draw(sample, load, pile);
  }

  /// Samples first_sample, first_sample + 1, ... into `piles`, each under its own load: the piles that draw() gives,
  /// bit for bit. failures[k] says where sample first_sample + k got stuck, if it did. All spans have one entry per
  /// pile.
  virtual void draw_group(std::uint64_t first_sample, std::span<const std::span<const double>> loads,
                          std::span<Pile> piles, std::span<std::optional<SamplingFailure>> failures) {
    for (std::size_t k = 0; k < piles.size(); ++k) failures[k] = draw(first_sample + k, loads[k], piles[k]);
  }

  /// What was done since construction.
  const SamplerCounts& counts() const { return counts_; }

 protected:
  SamplerCounts counts_;
};

/// How many piles draw_group gains from being handed at once: eight where a law draws them side by side, else one.
std::size_t piles_at_once(const SamplerSpec& spec, const Lattice& lattice);

/// Memory that one thread needs for drawing that many piles, the piles included, in bytes.
double drawing_memory(const SamplerSpec& spec, const Lattice& lattice);

/// Throws InputError if the spec is out of range.
std::unique_ptr<Sampler> make_sampler(const SamplerSpec& spec, const Lattice& lattice);

}  // namespace granuscope
