#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "model/pile.h"
#include "sampling/pile_group.h"
#include "sampling/sampler_spec.h"

namespace granuscope {

/// Draws piles of one law at one friction coefficient on one lattice. Not thread-safe: one sampler per thread.
/// A pile depends on (spec, lattice, load, sample) only, never on what was drawn before.
class Sampler {
 public:
  virtual ~Sampler() = default;

  /// Fills `pile` (of this sampler's lattice) with sample number `sample` under `load` (shape [columns], each
  /// > 0; or 0, but not all of them, where mu >= 1/sqrt 3; InputError otherwise).
  /// Returns where it got stuck if the effort ran out; the pile's contents are then not a solution. Throws Interrupted
  /// if that was asked for.
  virtual std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) = 0;

  /// Solves again under another load, keeping the random numbers of a first solution of the same sample: every bead
  /// tries first the number that its split in `first` stands for (pile_group.h), and draws another one only where
  /// the law makes it change its split. A law that solves no bead by itself draws the sample anew, from the same key.
  /// The pile depends on (spec, lattice, load, sample, first) only. `first` and `pile` are two piles.
  virtual std::optional<SamplingFailure> draw_again(std::uint64_t sample, std::span<const double> load,
                                                    [[maybe_unused]] const Pile& first, Pile& pile) {
    return draw(sample, load, pile);
  }

  /// Several samples, each under its own load: the piles that draw() gives, bit for bit, in their order, in memory of
  /// the sampler that holds until it draws or keep_layers is called; `loads` must hold as long. failures[k] says where
  /// samples[k] got stuck, if it did; that pile's contents are then not a solution. All spans have one entry per pile.
  virtual std::span<const PileGroup> draw_groups(std::span<const std::uint64_t> samples,
                                                 std::span<const std::span<const double>> loads,
                                                 std::span<std::optional<SamplingFailure>> failures);

  /// What draw_groups has to keep for whoever measures the piles, at least one layer, ascending (std::logic_error
  /// otherwise); all forces of all layers, if this is never called. A law may give up the other layers, and keep of
  /// these layers only what is asked for and their moments (PileGroup).
  virtual void keep_layers([[maybe_unused]] const KeptLayers& kept) {}

  /// What was done since construction, or since the counts were last taken.
  const SamplerCounts& counts() const { return counts_; }
  SamplerCounts take_counts() { return std::exchange(counts_, {}); }

 protected:
  explicit Sampler(const Lattice& lattice) : lattice_(lattice) {}

  /// Draws one of the samples of draw_groups by itself.
  void draw_alone(std::uint64_t sample, const std::span<const double>& load, std::optional<SamplingFailure>& failure);

  Lattice lattice_;
  SamplerCounts counts_;
  std::vector<PileGroup> groups_;  ///< of the last call of draw_groups
  std::deque<Pile> alone_;         ///< piles of it that were drawn by themselves
  std::size_t drawn_alone_ = 0;    ///< how many of them are in use
};

/// What a pile says of itself beside its forces.
void begin_pile(const SamplerSpec& spec, Law law, std::uint64_t sample, std::span<const double> load, Pile& pile);

/// How many piles draw_groups gains from being handed at once: more than one where a law draws them side by side.
/// `kept`: of which these layers are kept; null: all of them.
std::size_t piles_at_once(const SamplerSpec& spec, const Lattice& lattice, const KeptLayers* kept = nullptr);

/// Memory that one thread needs for drawing that many piles, the piles included, in bytes.
double drawing_memory(const SamplerSpec& spec, const Lattice& lattice, const KeptLayers* kept = nullptr);

/// Throws InputError if the spec is out of range.
std::unique_ptr<Sampler> make_sampler(const SamplerSpec& spec, const Lattice& lattice);

}  // namespace granuscope
